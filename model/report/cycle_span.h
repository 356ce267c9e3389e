#pragma once

#include <cstdint>

namespace metabuffer {

/// Core clocks from `first` to `last`, both included; none if `last` is before `first`.
struct CycleSpan {
    std::int64_t first = 0;
    std::int64_t last = -1;
    std::int64_t cycles() const { return last - first + 1; }
};

}  // namespace metabuffer
