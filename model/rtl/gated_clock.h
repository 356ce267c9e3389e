#pragma once

#include <cstdint>
#include <systemc>
#include <vector>

#include "rtl/clocked.h"

namespace metabuffer::rtl {

class GatedClock;

/// An sc_clock that rises at time 0. Each thing that it does takes time, so it does without what nobody sees:
///
/// - it falls only if somebody waits for that or sees it in a waveform;
/// - as any signal it rises one delta cycle before the edges of its blocks. Where nothing else happens at that time, and
///   nobody waits for the signal, both are one.
class RisingClock final : public sc_core::sc_clock {
  public:
    RisingClock(const char* name, const sc_core::sc_time& period) : sc_core::sc_clock(name, period) {}
    /// It falls from its next rise on.
    void show_falls() { falls_ = true; }
    /// It has no more edges.
    void stop() { stopped_ = true; }
    /// The blocks of this one have their edges when the clock rises.
    void drives(GatedClock& gated) { gated_.push_back(&gated); }

  private:
    void before_end_of_elaboration() override {}
    void start_of_simulation() override;
    void tick();
    void rise();
    void call_blocks();
    bool is_heard() const {
        return m_change_event_p != nullptr || m_posedge_event_p != nullptr || m_negedge_event_p != nullptr;
    }

    std::vector<GatedClock*> gated_;
    sc_core::sc_event risen_;
    bool falls_ = false;
    bool stopped_ = false;
};

/// Whether a machine's blocks are on gated clocks. kOff is for the test that shows that gating changes nothing.
enum class ClockGating : std::uint8_t { kOn, kOff };

/// A clock gating cell: a clock for many modules, which stands still while the clocked methods of all of them sleep. It
/// calls those that are awake itself, at clk_i's edge, before any signal changes. Anything else that is bound to it sees the
/// edges of clk_i, and then it never stands still.
///
/// clk_i must be bound to an sc_clock that rises at time 0.
class GatedClock final : public sc_core::sc_module, public sc_core::sc_signal_in_if<bool> {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};

    explicit GatedClock(const sc_core::sc_module_name& name);
    SC_HAS_PROCESS(GatedClock);

    std::int64_t period_picoseconds() const { return period_picoseconds_; }
    /// The number of the last edge, from 0.
    std::int64_t edge() const;
    bool stands_still() const { return awake_methods_ == 0 && !has_listeners_; }
    /// Calls the methods that are awake.
    void clock_edge();
    /// How many of the methods sleep.
    std::size_t sleepers() const { return calls_.size() - awake_methods_; }

    const sc_core::sc_event& value_changed_event() const override { return clk_i->value_changed_event(); }
    const sc_core::sc_event& posedge_event() const override {
        has_listeners_ = true;
        clk_i->posedge_event();  // so that clk_i rises for who asks which edge it is
        return posedge_;
    }
    const sc_core::sc_event& negedge_event() const override { return clk_i->negedge_event(); }
    const sc_core::sc_event& default_event() const override { return value_changed_event(); }
    const bool& read() const override { return clk_i->read(); }
    const bool& get_data_ref() const override { return clk_i->get_data_ref(); }
    bool event() const override { return clk_i->event(); }
    bool posedge() const override { return clk_i->posedge(); }
    bool negedge() const override { return clk_i->negedge(); }

  private:
    friend class Clocked;
    static constexpr std::size_t kWordBits = 64;

    void end_of_elaboration() override;
    void start_of_simulation() override;
    void add(const EdgeCall& call);
    /// Calls the method at each edge from the next one on, until it sleeps.
    void wake(const EdgeCall& call);
    /// Evaluates what of its module is combinational, in the next delta cycle.
    void settle(Clocked& method);
    void evaluate();

    std::int64_t period_picoseconds_ = 1;
    std::vector<EdgeCall> calls_;
    std::vector<std::uint64_t> awake_;  ///< a bit for each call
    std::size_t awake_methods_ = 0;
    std::vector<Clocked*> settling_;
    mutable bool has_listeners_ = false;
    sc_core::sc_event settles_{"settles"};
    sc_core::sc_event posedge_{"posedge"};
};

}  // namespace metabuffer::rtl
