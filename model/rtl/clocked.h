#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <systemc>
#include <utility>
#include <vector>

#include "rtl/register.h"

namespace metabuffer::rtl {

class Clocked;
class GatedClock;
class WakingWire;

/// What a clock needs of a clocked method at an edge. It fills a line of the processor's cache, and those of a clock lie
/// together.
struct alignas(64) EdgeCall {
    Clocked* clocked = nullptr;
    sc_core::sc_module* module = nullptr;
    RegisterSet* registers = nullptr;
    const bool* in_reset = nullptr;
    void (sc_core::sc_module::*edge)() = nullptr;
    bool has_outputs = false;  ///< something is combinational
    int idle_edges = 0;
    bool woken = false;  ///< since the last edge
    bool may_sleep = false;

    /// An edge. False: the method sleeps from now on.
    inline bool execute();
};

/// What a module does at the rising edges of one of its clocks: a clocked method with its registers.
///
///     RegisterSet registers_;
///     Register<bool> running_{registers_, "running"};
///     Clocked clocked_{*this, clk_i, reset_i, registers_, &Composer::clock_edge, &Composer::reset};
///
/// On a GatedClock the method sleeps while it would change nothing: after kIdleEdges edges in a row at which no register
/// has changed it is not called until an input of the module changes. It runs again at the first edge after that change.
/// Behaviour is the same as on any other clock, where it is called at every edge. What is neither a register nor a memory
/// that the same inputs leave as it is has to be noted by stay_awake() in each edge at which it changes.
///
/// What of the module is combinational is evaluated by a second method, see evaluates().
///
/// Reset is synchronous and active high. A reset that changes at the very time of an edge is seen at the next one; it
/// lasts two edges at least.
class Clocked final : public sc_core::sc_module {
  public:
    /// Edges that change nothing, in a row, after which the method sleeps. Waking costs time, so it does not in short
    /// pauses.
    static constexpr int kIdleEdges = 8;

    using Ports = std::initializer_list<std::reference_wrapper<sc_core::sc_port_base>>;
    using Method = void (sc_core::sc_module::*)();

    /// reset: what is done instead of edge while reset_i is high.
    template <typename Module>
    Clocked(Module& module, sc_core::sc_in<bool>& clk_i, sc_core::sc_in<bool>& reset_i,
            RegisterSet& registers, void (Module::*edge)(), void (Module::*reset)())
        : Clocked(module, clk_i, &reset_i, &registers, static_cast<Method>(edge),
                  static_cast<Method>(reset)) {}
    /// Without registers, and without a reset.
    template <typename Module>
    Clocked(Module& module, sc_core::sc_in<bool>& clk_i, void (Module::*edge)())
        : Clocked(module, clk_i, nullptr, nullptr, static_cast<Method>(edge), nullptr) {}

    /// In a module with several clocks: the inputs that this method reads, if others shall not wake it.
    void reads(Ports inputs) { reads_ = inputs; }
    /// What is combinational in the module. It is called in the next delta cycle after an edge at which a register has
    /// changed, or a change of one of these inputs.
    template <typename Module>
    void evaluates(void (Module::*outputs)(), Ports inputs) {
        outputs_ = static_cast<Method>(outputs);
        evaluates_with(inputs);
    }
    /// Further inputs of what is combinational.
    void evaluates_with(Ports inputs) { outputs_read_.insert(outputs_read_.end(), inputs); }
    /// Something besides registers changes at this edge.
    void stay_awake() { registers_.note_change(); }
    /// Though registers change at this edge, later ones need not be executed: slept_edges() is enough to make up for them.
    void may_sleep() {
        if (call_ != nullptr) call_->may_sleep = true;
    }
    /// Edges that have passed in the sleep that this edge ends.
    std::int64_t slept_edges() const { return slept_edges_; }
    /// Between edges: those that have passed in a sleep that no edge has ended yet.
    std::int64_t edges_asleep() const;
    /// When the clock had the edge before this one.
    std::int64_t previous_edge_picoseconds() const;

    /// It sleeps, and an input of the module has changed.
    void wake();
    /// An input of what is combinational has changed, or a register.
    void settle();

  private:
    friend struct EdgeCall;
    friend class GatedClock;

    Clocked(sc_core::sc_module& module, sc_core::sc_in<bool>& clk_i, const sc_core::sc_in<bool>* reset_i,
            RegisterSet* registers, Method edge, Method reset);

    void end_of_elaboration() override;
    void find_inputs();
    void find_combinational_inputs();
    void evaluate();
    void in_reset() { (module_.*reset_)(); }
    void end_sleep();
    void call_always();
    void fall_asleep();
    /// Begins or ends a sleep by the events of inputs that are no Wires.
    void sleep_or_wake();

    sc_core::sc_module& module_;
    RegisterSet& registers_;
    const bool* in_reset_ = nullptr;
    Method edge_ = nullptr;
    Method reset_ = nullptr;
    Method outputs_ = nullptr;  ///< null: nothing is combinational
    EdgeCall* call_ = nullptr;  ///< null: it never sleeps
    std::int64_t slept_edges_ = 0;
    std::int64_t last_edge_ = -1;  ///< number of the last one before a sleep
    bool asleep_ = false;
    bool settles_ = false;  ///< its clock calls evaluate() in the next delta cycle
    bool arming_ = false;   ///< sleep_or_wake() is called to wait for event_inputs_
    bool armed_ = false;    ///< it waits
    bool has_event_inputs_ = false;

    RegisterSet none_;
    sc_core::sc_in<bool>& clk_i_;
    const sc_core::sc_in<bool>* reset_i_ = nullptr;
    GatedClock* clock_ = nullptr;                                       ///< null: it never sleeps
    std::vector<std::reference_wrapper<sc_core::sc_port_base>> reads_;  ///< none: all inputs
    std::vector<std::reference_wrapper<sc_core::sc_port_base>> outputs_read_;
    std::vector<WakingWire*> wires_;          ///< inputs
    sc_core::sc_event_or_list event_inputs_;  ///< inputs that are no wires
    sc_core::sc_event falls_asleep_;
    std::int64_t edge_picoseconds_ = 0;      ///< without a GatedClock: of the last edge
    std::int64_t previous_picoseconds_ = 0;  ///< and of the one before
};

inline bool EdgeCall::execute() {
    const bool wakes = woken;
    if (wakes) clocked->end_sleep();
    if (*in_reset) {
        clocked->in_reset();
    } else {
        (module->*edge)();
    }
    if (wakes) clocked->slept_edges_ = 0;
    if (registers->end_edge()) {
        if (has_outputs) clocked->settle();
        if (!may_sleep) {
            idle_edges = 0;
            return true;
        }
    }
    may_sleep = false;
    if (++idle_edges < Clocked::kIdleEdges) return true;
    clocked->fall_asleep();
    return false;
}

}  // namespace metabuffer::rtl
