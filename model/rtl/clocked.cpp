#include "rtl/clocked.h"

#include <algorithm>
#include <string>
#include <vector>

#include "rtl/block.h"
#include "rtl/gated_clock.h"
#include "rtl/spawn_method.h"
#include "rtl/wire.h"

namespace metabuffer::rtl {

Clocked::Clocked(sc_core::sc_module& module, sc_core::sc_in<bool>& clk_i, const sc_core::sc_in<bool>* reset_i,
                 RegisterSet* registers, Method edge, Method reset)
    : sc_core::sc_module(sc_core::sc_module_name(sc_core::sc_gen_unique_name("clocked"))),
      module_(module),
      registers_(registers == nullptr ? none_ : *registers),
      edge_(edge),
      reset_(reset),
      clk_i_(clk_i),
      reset_i_(reset_i) {}

void Clocked::end_of_elaboration() {
    static const bool kNever = false;
    in_reset_ = reset_i_ == nullptr ? &kNever : &(*reset_i_)->read();
    clock_ = dynamic_cast<GatedClock*>(clk_i_.get_interface());
    find_combinational_inputs();
    if (clock_ == nullptr) {
        spawn_method([this] { call_always(); }, {&clk_i_->posedge_event()});
        return;
    }
    find_inputs();
    if (has_event_inputs_) spawn_method([this] { sleep_or_wake(); }, {&falls_asleep_});
    clock_->add({this, &module_, &registers_, in_reset_, edge_, outputs_ != nullptr});
}

/// All of the module's, but for its clocks.
void Clocked::find_inputs() {
    std::vector<const sc_core::sc_object*> clocks;
    for (const sc_core::sc_object* const child : module_.get_child_objects()) {
        if (const auto* const method = dynamic_cast<const Clocked*>(child)) clocks.push_back(&method->clk_i_);
    }
    for (sc_core::sc_object* const child : module_.get_child_objects()) {
        auto* const port = dynamic_cast<sc_core::sc_port_base*>(child);
        if (port == nullptr || std::string(port->kind()) != "sc_in" ||
            std::find(clocks.begin(), clocks.end(), child) != clocks.end() ||
            (!reads_.empty() &&
             std::none_of(reads_.begin(), reads_.end(),
                          [port](const sc_core::sc_port_base& read) { return &read == port; }))) {
            continue;
        }
        if (auto* const wire = dynamic_cast<WakingWire*>(port->get_interface())) {
            wires_.push_back(wire);
        } else {
            event_inputs_ |= port->get_interface()->default_event();
            has_event_inputs_ = true;
        }
    }
}

void Clocked::find_combinational_inputs() {
    if (outputs_ == nullptr) return;
    std::vector<const sc_core::sc_event*> events;
    if (clock_ == nullptr) events.push_back(&registers_.changed_event());
    for (sc_core::sc_port_base& port : outputs_read_) {
        sc_core::sc_interface& channel = *port.get_interface();
        auto* const wire = dynamic_cast<WakingWire*>(&channel);
        if (clock_ != nullptr && wire != nullptr) {
            wire->add_follower(*this);
        } else {
            events.push_back(&channel.default_event());
        }
    }
    if (!events.empty()) spawn_method([this] { evaluate(); }, events);
}

void Clocked::settle() {
    if (settles_) return;
    settles_ = true;
    clock_->settle(*this);
}

void Clocked::evaluate() {
    settles_ = false;
    (module_.*outputs_)();
}

void Clocked::call_always() {
    previous_picoseconds_ = edge_picoseconds_;
    edge_picoseconds_ = now_picoseconds();
    (module_.*(*in_reset_ ? reset_ : edge_))();
    if (registers_.end_edge()) registers_.notify_changed();
}

void Clocked::end_sleep() {
    slept_edges_ = clock_->edge() - last_edge_ - 1;
    call_->woken = false;
}

void Clocked::fall_asleep() {
    call_->idle_edges = 0;
    asleep_ = true;
    last_edge_ = clock_->edge();
    for (WakingWire* const wire : wires_) wire->add_sleeper(*this);
    if (has_event_inputs_ && !armed_) {
        armed_ = arming_ = true;
        falls_asleep_.notify();  // in this evaluation phase, so that no change of an input is missed
    }
}

void Clocked::sleep_or_wake() {
    if (arming_) {
        arming_ = false;
        next_trigger(event_inputs_);
        return;
    }
    armed_ = false;
    if (asleep_) wake();
}

void Clocked::wake() {
    for (WakingWire* const wire : wires_) wire->remove_sleeper(*this);
    asleep_ = false;
    call_->woken = true;
    clock_->wake(*call_);
}

std::int64_t Clocked::edges_asleep() const {
    return asleep_ || (call_ != nullptr && call_->woken) ? clock_->edge() - last_edge_ : 0;
}

std::int64_t Clocked::previous_edge_picoseconds() const {
    return clock_ == nullptr ? previous_picoseconds_ : now_picoseconds() - clock_->period_picoseconds();
}

void WakingWire::note_change() {
    for (Clocked* const follower : followers_) follower->settle();
    while (!sleepers_.empty()) sleepers_.back()->wake();
}

void WakingWire::remove_sleeper(Clocked& sleeper) {
    sleepers_.erase(std::find(sleepers_.begin(), sleepers_.end(), &sleeper));
    --heard_;
}

}  // namespace metabuffer::rtl
