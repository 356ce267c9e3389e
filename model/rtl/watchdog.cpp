#include "rtl/watchdog.h"

#include <utility>

namespace metabuffer::rtl {

Watchdog::Watchdog(const sc_core::sc_module_name& name, const sc_core::sc_time& interval,
                   std::function<std::int64_t()> progress, std::function<void()> on_timeout)
    : sc_core::sc_module(name),
      interval_(interval),
      progress_(std::move(progress)),
      on_timeout_(std::move(on_timeout)) {
    SC_METHOD(check);
}

void Watchdog::check() {
    const std::int64_t progress = progress_();
    if (progress == last_progress_) {
        on_timeout_();
        return;
    }
    last_progress_ = progress;
    next_trigger(interval_);
}

}  // namespace metabuffer::rtl
