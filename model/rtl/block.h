#pragma once

#include <string>
#include <systemc>

#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// What every block of the machine is: a SystemC module that can put its signals into a waveform and say what
/// it waits for when nothing moves.
class Block : public sc_core::sc_module {
  public:
    /// Adds the block's ports and registers to a waveform, under the block's hierarchical name.
    void trace(sc_core::sc_trace_file* file) const override = 0;

    /// One line for the watchdog: what the block waits for; empty if it waits for nothing.
    virtual std::string waiting_for() const { return {}; }

  protected:
    explicit Block(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {}

    /// The full waveform name of one of the block's signals.
    std::string path(const char* signal) const { return std::string(this->name()) + "." + signal; }
};

/// The number of the clock edge that is being executed, from 0, on a clock of the given period that had its
/// first rising edge at time 0.
inline std::int64_t clock_edge_number(std::int64_t period_picoseconds) {
    return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()) / period_picoseconds;
}

/// A level that crosses from another clock domain: two registers in the receiver's domain, so a change is seen
/// at the second receiver edge after it at the earliest. Call sample() once at each edge.
template <typename Value>
class Synchronizer {
  public:
    /// The value as the receiver's logic sees it at this edge, given what stands at the input now.
    const Value& sample(const Value& input) {
        stable_ = captured_;
        captured_ = input;
        return stable_;
    }
    void reset() { captured_ = stable_ = Value{}; }

  private:
    Value captured_{};
    Value stable_{};
};

}  // namespace metabuffer::rtl
