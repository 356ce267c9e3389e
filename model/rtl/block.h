#pragma once

#include <cstdint>
#include <string>
#include <systemc>
#include <utility>

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
    explicit Block(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {}

    /// The full waveform name of one of the block's signals.
    std::string path(const char* signal) const { return std::string(this->name()) + "." + signal; }
};

/// kOff is for the test that shows that gating changes nothing.
enum class ClockGating : std::uint8_t { kOn, kOff };

/// Clock gating for a clocked method that has nothing to do. After a few idle edges in a row the method sleeps until
/// one of its inputs changes, and it runs again from the clock edge after that change. Behaviour is the same as without
/// gating; only activations that would do nothing are saved.
///
///     void clock_edge() {
///         if (gate_.opened()) return;  // woken by an input, between two edges
///         ...
///         if (gate_.idle_edge(nothing_to_do)) next_trigger(wake_events_);
///     }
///
/// "Nothing to do" must mean: with the inputs as they are, no register changes at any later edge.
class ClockGate {
  public:
    explicit ClockGate(ClockGating gating) : gating_(gating) {}

    /// True, once, when the method has been called because an input changed while it slept.
    bool opened() { return std::exchange(closed_, false); }
    /// Call at each edge; true when the method may sleep.
    bool idle_edge(bool idle) {
        idle_edges_ = idle ? idle_edges_ + 1 : 0;
        if (idle_edges_ < kIdleEdges || gating_ == ClockGating::kOff) {
            return false;
        }
        idle_edges_ = 0;
        closed_ = true;
        return true;
    }

  private:
    /// Waking costs an activation, so the method does not sleep in short pauses.
    static constexpr int kIdleEdges = 8;
    ClockGating gating_;
    int idle_edges_ = 0;
    bool closed_ = false;
};

/// The number of the clock edge that is being executed, from 0, on a clock of the given period that had its
/// first rising edge at time 0.
inline std::int64_t clock_edge_number(std::int64_t period_picoseconds) {
    return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()) / period_picoseconds;
}

}  // namespace metabuffer::rtl
