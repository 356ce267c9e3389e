#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Core cycles at whose edges a fault of the scenario may hold a wire at another level than the driven one.
struct FaultWindow {
    std::int64_t first_cycle = 0;
    std::int64_t last_cycle = 0;

    explicit FaultWindow(const Fault& fault)
        : first_cycle(fault.from_cycle),
          last_cycle(fault.cycles ? fault.from_cycle + *fault.cycles - 1 : kForEver) {}

    /// The window with `cycles` more cycles at its end.
    FaultWindow and_behind(std::int64_t cycles) const {
        FaultWindow longer = *this;
        longer.last_cycle += cycles;
        return longer;
    }
    bool contains(std::int64_t cycle) const { return first_cycle <= cycle && cycle <= last_cycle; }

  private:
    static constexpr std::int64_t kForEver = std::numeric_limits<std::int64_t>::max() / 2;
};

using FaultWindows = std::vector<FaultWindow>;

/// Whether any of the windows has that cycle.
inline bool contain(const FaultWindows& windows, std::int64_t cycle) {
    return std::any_of(windows.begin(), windows.end(),
                       [cycle](const FaultWindow& window) { return window.contains(cycle); });
}

}  // namespace metabuffer::monitors
