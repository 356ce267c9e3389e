#pragma once

#include <cstdint>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer {

/// What the hardware of a scenario needs: bits of memories, wires and pins, memory devices, and the results of
/// synthesis for the blocks in SystemVerilog (synthesis_table.h).
struct MachineCost {
    // Bits that are held.
    std::int64_t buffer_bits = 0;  ///< composers' FIFOs
    std::int64_t input_framebuffer_bits =
        0;  ///< two images each, and with shared ports the two halves of a write buffer
    std::int64_t output_framebuffer_bits = 0;  ///< two pictures each
    std::int64_t correction_bits = 0;          ///< colour tables of displays that have one

    // Wires and pins.
    std::int64_t bus_wires = 0;       ///< data, side band and handshakes
    std::int64_t pipeline_wires = 0;  ///< from each composer to the one below it or to the output framebuffer
    std::int64_t memory_pins = 0;  ///< of input framebuffers: data, byte masks, command, bank, row and column
    std::int64_t dvi_pins = 0;     ///< of links and displays, behind the receiver and before the transmitter

    std::int64_t memory_devices =
        0;  ///< 64 bits wide: words_per_cycle of them side by side, twice with dual ports
    double memory_megabytes_per_second = 0.0;

    // Composers and arbiters together, on an FPGA.
    std::int64_t lookup_tables = 0;
    std::int64_t registers = 0;
    std::int64_t block_rams = 0;
    std::int64_t multipliers = 0;

    // The clock that each reaches in standard cells, without wires.
    double composer_mhz = 0.0;
    double arbiter_mhz = 0.0;

    /// In one number, by the usual weights (cost_items): a wire costs 1.
    double weighted() const;
};

MachineCost machine_cost(const Scenario& scenario);

/// A part of the cost, for reports, figures and documentation.
struct CostItem {
    const char* name = nullptr;
    const char* unit = nullptr;
    const char* meaning = nullptr;
    double (*value)(const MachineCost&) = nullptr;
    double weight = 0.0;   ///< in MachineCost::weighted(); 0: not a part of it
    bool is_whole = true;  ///< a whole number
};
const std::vector<CostItem>& cost_items();

}  // namespace metabuffer
