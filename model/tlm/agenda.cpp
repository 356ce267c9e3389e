#include "tlm/agenda.h"

#include <utility>

namespace metabuffer::tlm {

Agenda::Agenda(const sc_core::sc_module_name& name, const ClockDomain& core,
               std::function<std::int64_t()> horizon)
    : sc_core::sc_module(name), core_(core), horizon_(std::move(horizon)) {
    SC_METHOD(run);
    sensitive << wake_;
    dont_initialize();
}

std::size_t Agenda::add(Decider decider) {
    deciders_.push_back(std::move(decider));
    next_cycles_.push_back(kUnknownCycle);
    return deciders_.size() - 1;
}

void Agenda::schedule(std::size_t number, std::int64_t cycle) {
    if (next_cycles_[number] == cycle) {
        return;
    }
    next_cycles_[number] = cycle;
    if (cycle == kUnknownCycle) {
        return;
    }
    entries_.push({cycle, number});
    if (!is_running_) {
        wake_.notify(core_.until(cycle));
    }
}

/// Whether an entry is left.
bool Agenda::forget_replaced() {
    while (!entries_.empty() && next_cycles_[entries_.top().number] != entries_.top().cycle) {
        entries_.pop();
    }
    return !entries_.empty();
}

/// The horizon only moves on.
bool Agenda::is_within_horizon(std::int64_t cycle) {
    if (cycle > known_horizon_) {
        known_horizon_ = horizon_();
    }
    return cycle <= known_horizon_;
}

void Agenda::run() {
    is_running_ = true;
    while (forget_replaced()) {
        const Entry next = entries_.top();
        const sc_core::sc_time until = core_.until(next.cycle);
        if (until > sc_core::sc_time_to_pending_activity()) {
            wake_.notify(until);
            break;
        }
        entries_.pop();
        next_cycles_[next.number] = kUnknownCycle;
        cycle_ = next.cycle;
        const Decider& decide = deciders_[next.number];
        Decision decision = decide(next.cycle);
        while (decision.is_certain && is_within_horizon(decision.cycle)) {
            decision = decide(decision.cycle);
        }
        schedule(next.number, decision.cycle);
    }
    is_running_ = false;
}

}  // namespace metabuffer::tlm
