#include "rtl/clock_gate.h"

#include <algorithm>

namespace metabuffer::rtl {

void ClockGate::attach(const sc_core::sc_in<bool>& clock) {
    attached_ = true;
    clock_ = dynamic_cast<GatedClock*>(const_cast<sc_core::sc_interface*>(clock.get_interface()));
}

void ClockGate::wake() {
    asleep_ = false;
    if (clock_ != nullptr) {
        clock_->start_again();
    }
}

GatedClock::GatedClock(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void GatedClock::start_again() {
    if (stands_still_) {
        start_again_.notify(sc_core::SC_ZERO_TIME);
    }
}

bool GatedClock::all_sleep() const {
    return std::all_of(sleepers_.begin(), sleepers_.end(), [](const auto& sleeps) { return sleeps(); });
}

void GatedClock::clock_edge() {
    if (stands_still_) {
        stands_still_ = false;  // called between two edges
    } else if (all_sleep()) {
        stands_still_ = true;
        next_trigger(start_again_);
    } else {
        posedge_.notify();
    }
}

}  // namespace metabuffer::rtl
