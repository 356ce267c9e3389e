#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rtl/block.h"

namespace metabuffer::rtl {

/// Ends a run in which nothing moves: checks a progress count every `interval` and calls `on_timeout` if it has not
/// changed since the last check. It is not a part of the machine and costs nothing between two checks.
class Watchdog final : public sc_core::sc_module {
  public:
    Watchdog(const sc_core::sc_module_name& name, const sc_core::sc_time& interval,
             std::function<std::int64_t()> progress, std::function<void()> on_timeout);
    SC_HAS_PROCESS(Watchdog);

  private:
    void check();

    sc_core::sc_time interval_;
    std::function<std::int64_t()> progress_;
    std::function<void()> on_timeout_;
    std::optional<std::int64_t> last_progress_;
};

}  // namespace metabuffer::rtl
