#include "rtl/link_clock.h"

namespace metabuffer::rtl {
namespace {

constexpr std::int64_t kMillion = 1'000'000;

}  // namespace

LinkClock::LinkClock(const sc_core::sc_module_name& name, std::int64_t nominal_period_picoseconds)
    : Block(name), nominal_period_picoseconds_(nominal_period_picoseconds) {
    SC_METHOD(step);
}

void LinkClock::step() {
    if (stopped_) return;
    high_ = !high_;
    clk_o.write(high_);
    if (!high_) {
        next_trigger(picoseconds(low_picoseconds_));
        return;
    }
    if (ppm_ != clock_ppm_i.read()) {
        ppm_ = clock_ppm_i.read();
        remainder_ = 0;
    }
    const std::int64_t divisor = kMillion + ppm_;
    const std::int64_t dividend = nominal_period_picoseconds_ * kMillion + remainder_;
    remainder_ = dividend % divisor;
    const std::int64_t period = dividend / divisor;
    low_picoseconds_ = period / 2;
    next_trigger(picoseconds(period - low_picoseconds_));
}

void LinkClock::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, clk_o.port(), path("clk"));
    sc_core::sc_trace(file, clock_ppm_i.port(), path("ppm"));
}

}  // namespace metabuffer::rtl
