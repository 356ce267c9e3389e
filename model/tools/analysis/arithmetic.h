#pragma once

#include <cstddef>
#include <cstdint>

namespace metabuffer::analysis {

/// Before any clock or position that there is.
constexpr double kNever = -1e18;
/// Sums of clocks are whole but for averages: how far two that are equal can be apart.
constexpr double kRounding = 1e-6;

inline double as_double(std::int64_t value) { return static_cast<double>(value); }
inline std::int64_t as_int(std::size_t size) { return static_cast<std::int64_t>(size); }
inline std::int64_t divide_up(std::int64_t value, std::int64_t divisor) {
    return (value + divisor - 1) / divisor;
}

}  // namespace metabuffer::analysis
