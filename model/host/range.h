#pragma once

#include <cstdint>

namespace metabuffer {

/// Whole numbers, both ends included.
struct IntegerRange {
    std::int64_t low = 0;
    std::int64_t high = 0;

    constexpr bool contains(std::int64_t value) const { return low <= value && value <= high; }
};

/// Numbers, both ends included.
struct NumberRange {
    double low = 0.0;
    double high = 0.0;

    constexpr bool contains(double value) const { return low <= value && value <= high; }
};

}  // namespace metabuffer
