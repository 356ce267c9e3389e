#pragma once

#include <cstddef>
#include <cstdint>

namespace metabuffer::analysis {

/// Earlier than any clock or position.
constexpr double kNever = -1e18;
/// How far two equal sums of clocks can be apart. Sums are whole numbers unless averages are among them.
constexpr double kRounding = 1e-6;

inline double as_double(std::int64_t value) { return static_cast<double>(value); }
inline std::int64_t as_int(std::size_t size) { return static_cast<std::int64_t>(size); }
inline std::int64_t divide_up(std::int64_t value, std::int64_t divisor) {
    return (value + divisor - 1) / divisor;
}

}  // namespace metabuffer::analysis
