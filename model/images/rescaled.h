#pragma once

#include <cstdint>

namespace metabuffer {

/// value / full * other_full to the nearest whole number: a share of one full scale as that of another. Exact: a full scale
/// is odd, so that there are no halves.
constexpr std::uint32_t rescaled(std::uint32_t value, std::uint32_t full, std::uint32_t other_full) {
    return static_cast<std::uint32_t>((std::uint64_t{value} * other_full + full / 2) / full);
}

}  // namespace metabuffer
