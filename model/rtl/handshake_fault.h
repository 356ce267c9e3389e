#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rtl/block.h"
#include "rtl/fault_tally.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// The handshake wires that a fault can hold low.
enum class Handshake : std::uint8_t { kBusready, kTableready, kPipeready, kPairRequest };

/// A wire of one of the renderers' rows, between the block that raises it and the block that reads it, that faults
/// of the scenario hold low: always for a while (busready_low, pipeready_low) or in some of the clocks at random
/// (random_stalls). Not in the paper: a double for a wire that is broken or slow.
///
/// Timing: while no fault holds it the output follows the input within the clock. A fault that lasts from core
/// cycle c on holds the wire as the edge of core cycle c reads it. What the protocol of the wire asks for is kept:
/// - PIPEREADY is not taken back: a hold delays its rise, and one that stands stays until it falls itself.
/// - BUSREADY that is taken away stays low until its composer has lowered it too, or has had the time to see by the
///   silence of the bus that its burst was stopped: a page miss, two beats and two clocks. A composer that still
///   counted on the rest of its burst could be sent more than it has room for.
/// - TABLEREADY and PAIR_REQUEST may fall and rise at any clock.
///
/// Random holds depend on the fault's seed, the wire and the number of its clock alone.
class HandshakeFault final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};    ///< the clock of the block that reads the wire
    sc_core::sc_in<bool> wire_i{"wire_i"};  ///< as it is raised
    sc_core::sc_out<bool> wire_o{"wire_o"};

    struct Wire {
        Handshake handshake;
        std::size_t renderer = 0;  ///< of the block that raises it, index
        std::size_t display = 0;   ///< index; 0 where there is one for all
        std::string name;          ///< "BUSREADY_1_2", for the watchdog's report
    };

    /// The row (index) of the PIPEREADY wires at which a fault of a renderer's composer sits: its own, but for the
    /// PIPEMASTER, which answers its own PIPEREADY without a wire. It is kept from raising it by the wire that it waits
    /// for.
    static constexpr int pipeready_row(int renderer) { return renderer == 0 ? 1 : renderer; }
    /// Core cycles for which BUSREADY stays low behind a fault at most, see above.
    static constexpr int stopped_burst_cycles(const Scenario& scenario) {
        return scenario.memory.page_miss_cycles + 2 * cycles_per_beat(scenario.bus) + 2;
    }

    /// faults: places in Scenario::faults of those that hold this wire. Scenario and tally must outlive the module.
    HandshakeFault(const sc_core::sc_module_name& name, const Scenario& scenario, Wire wire,
                   std::vector<std::size_t> faults, FaultTally& tally);
    SC_HAS_PROCESS(HandshakeFault);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

  private:
    void clock_edge();
    void update();
    bool holds(std::size_t fault, std::int64_t core_cycle, std::int64_t edge) const;
    bool any_holds(std::int64_t core_cycle, std::int64_t edge) const;

    const Scenario& scenario_;
    Wire wire_;
    std::vector<std::size_t> faults_;
    FaultTally& tally_;
    std::int64_t core_period_picoseconds_;
    int stopped_burst_cycles_;

    sc_core::sc_signal<bool> hold_;
    std::int64_t edge_ = -1;       ///< number of the clock's edge
    std::int64_t core_cycle_ = 0;  ///< by which the faults have been asked for the edge to come
    int stopped_left_ = 0;         ///< BUSREADY: clocks for which it stays low since it was taken away
};

}  // namespace metabuffer::rtl
