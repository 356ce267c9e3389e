#pragma once

#include <cstdint>
#include <functional>
#include <systemc>
#include <utility>
#include <vector>

namespace metabuffer::rtl {

class GatedClock;

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
/// "Nothing to do" must mean: with the inputs as they are, no register changes at any later edge. A reset that changes at
/// the very time of an edge is seen at the next one; it lasts two edges at least.
class ClockGate {
  public:
    /// Idle edges in a row after which the method sleeps. Waking costs an activation, so it does not in short pauses.
    static constexpr int kIdleEdges = 8;

    explicit ClockGate(ClockGating gating) : gating_(gating) {}

    /// Call it at the end of elaboration if Block::sleeps() depends on this gate. If the clock is a GatedClock, the gate
    /// starts it again when it opens.
    void attach(const sc_core::sc_in<bool>& clock);

    /// True, once, when the method has been called because an input changed while it slept.
    bool opened() {
        if (!asleep_) {
            return false;
        }
        wake();
        return true;
    }
    /// Call at each edge; true when the method may sleep.
    bool idle_edge(bool idle) {
        idle_edges_ = idle ? idle_edges_ + 1 : 0;
        if (idle_edges_ < kIdleEdges || gating_ == ClockGating::kOff) {
            return false;
        }
        idle_edges_ = 0;
        asleep_ = true;
        return true;
    }
    /// The method sleeps, and the gate is attached to the clock.
    bool asleep() const { return asleep_ && attached_; }

  private:
    void wake();

    ClockGating gating_;
    int idle_edges_ = 0;
    bool asleep_ = false;
    bool attached_ = false;
    GatedClock* clock_ = nullptr;
};

/// Counts the edges of a steady clock for a method that may sleep: those that it has slept through follow from the time.
class EdgeCounter {
  public:
    /// Call it at each edge at which the method runs. Edges since the last call, this one included.
    std::int64_t count() {
        const auto now = static_cast<std::int64_t>(sc_core::sc_time_stamp().value());
        const std::int64_t passed = now - last_picoseconds_;
        last_picoseconds_ = now;
        if (!sleeps_) {
            period_picoseconds_ = passed;
            return 1;
        }
        sleeps_ = false;
        return passed / period_picoseconds_;
    }
    /// The method does not run again until an input has changed. It has run at two edges in a row at least.
    void sleep() { sleeps_ = true; }

  private:
    std::int64_t last_picoseconds_ = 0;
    std::int64_t period_picoseconds_ = 0;
    bool sleeps_ = false;
};

/// A clock gating cell for many blocks: their clock, which stands still while all of them sleep. A sleeping method is
/// still among those that its clock's event visits at each edge, so that many sleeping methods take time, too.
///
/// The blocks' methods run in the very delta cycle of clk_i's edge, before any signal changes, as if they were bound to
/// clk_i itself. Falling edges are those of clk_i.
class GatedClock final : public sc_core::sc_module, public sc_core::sc_signal_in_if<bool> {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};

    explicit GatedClock(const sc_core::sc_module_name& name);
    SC_HAS_PROCESS(GatedClock);

    /// A block that is bound to this clock: sleeps() tells whether all its methods of this clock do. Every such block must
    /// be added, or it misses edges.
    void add(std::function<bool()> sleeps) { sleepers_.push_back(std::move(sleeps)); }

    /// One of the blocks has been woken between two edges.
    void start_again();

    const sc_core::sc_event& value_changed_event() const override { return clk_i->value_changed_event(); }
    const sc_core::sc_event& posedge_event() const override { return posedge_; }
    const sc_core::sc_event& negedge_event() const override { return clk_i->negedge_event(); }
    const sc_core::sc_event& default_event() const override { return value_changed_event(); }
    const bool& read() const override { return clk_i->read(); }
    const bool& get_data_ref() const override { return clk_i->get_data_ref(); }
    bool event() const override { return clk_i->event(); }
    bool posedge() const override { return clk_i->posedge(); }
    bool negedge() const override { return clk_i->negedge(); }

  private:
    void clock_edge();
    bool all_sleep() const;

    std::vector<std::function<bool()>> sleepers_;
    bool stands_still_ = false;
    sc_core::sc_event start_again_{"start_again"};
    sc_core::sc_event posedge_{"posedge"};
};

}  // namespace metabuffer::rtl
