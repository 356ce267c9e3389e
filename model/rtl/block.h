#pragma once

#include <cstdint>
#include <string>
#include <systemc>

#include "rtl/clocked.h"
#include "rtl/pins.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// A time of 0 or more.
inline sc_core::sc_time picoseconds(std::int64_t count) {
    return sc_core::sc_time(static_cast<double>(count), sc_core::SC_PS);
}

inline std::int64_t now_picoseconds() { return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()); }

/// The base class of every block of the machine: a SystemC module that can add its signals to a waveform and say what
/// it waits for when nothing moves.
class Block : public sc_core::sc_module {
  public:
    /// Adds the block's ports and registers to a waveform, under the block's hierarchical name.
    void trace(sc_core::sc_trace_file* file) const override = 0;

    /// One line for the watchdog: what the block waits for; empty if it waits for nothing.
    virtual std::string waiting_for() const { return {}; }

  protected:
    /// Adds the blocks that this one is made of.
    void trace_parts(sc_core::sc_trace_file* file) const {
        for (const sc_core::sc_object* const part : get_child_objects()) {
            if (const auto* const block = dynamic_cast<const Block*>(part)) block->trace(file);
        }
    }

    explicit Block(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {}

    /// The name of the block that this one is a part of, for its errors; its own if it stands alone.
    std::string whole() const {
        const sc_core::sc_object* const parent = get_parent_object();
        return parent == nullptr ? name() : parent->name();
    }

    /// The full waveform name of one of the block's signals.
    std::string path(const char* signal) const { return std::string(this->name()) + "." + signal; }
};

/// The number of the clock edge that is being executed, from 0, on a clock of the given period that had its
/// first rising edge at time 0.
inline std::int64_t clock_edge_number(std::int64_t period_picoseconds) {
    return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()) / period_picoseconds;
}

}  // namespace metabuffer::rtl
