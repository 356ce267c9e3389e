#include "rtl/gated_clock.h"

#include "rtl/clocked.h"

namespace metabuffer::rtl {

GatedClock::GatedClock(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void GatedClock::end_of_elaboration() {
    const auto& clock = dynamic_cast<const sc_core::sc_clock&>(*clk_i.get_interface());
    period_picoseconds_ = static_cast<std::int64_t>(clock.period().value());
}

std::int64_t GatedClock::edge() const {
    return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()) / period_picoseconds_;
}

void GatedClock::add(Clocked& method) {
    ++methods_;
    wake(method);
}

void GatedClock::wake(Clocked& method) {
    awake_.push_back(&method);
    if (stands_still_) {
        start_again_.notify(sc_core::SC_ZERO_TIME);
    }
}

void GatedClock::clock_edge() {
    if (stands_still_) {
        stands_still_ = false;  // called between two edges
        return;
    }
    for (std::size_t i = 0; i < awake_.size();) {
        if (awake_[i]->call()) {
            ++i;
        } else {
            awake_[i] = awake_.back();
            awake_.pop_back();
        }
    }
    if (has_listeners_) {
        posedge_.notify();
    } else if (awake_.empty()) {
        stands_still_ = true;
        next_trigger(start_again_);
    }
}

}  // namespace metabuffer::rtl
