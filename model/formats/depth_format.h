#pragma once

#include <array>
#include <cstdint>

#include "host/enum_table.h"

namespace metabuffer {

/// What the 24 bits of a depth frame's pixel mean (sections 4 and 7 of the paper: colour on even frames,
/// alpha and Z on odd ones).
enum class DepthFormat : std::uint8_t { kA8Z16, kZ24 };

/// Where a format has alpha and Z among the 24 bits. Z is unsigned and 0 is nearest.
struct DepthLayout {
    DepthFormat value;
    const char* name;
    int z_bits;  ///< 1 to 24
    int z_shift;
    int alpha_bits;  ///< 8; or 0 for none, and alpha is taken as 255
    int alpha_shift;

    /// Also the far plane.
    constexpr std::uint32_t z_mask() const { return (1U << z_bits) - 1U; }
    constexpr std::uint32_t alpha_mask() const { return (1U << alpha_bits) - 1U; }
    /// What a receiver adds to the alpha from the link: 255 if the format has none.
    constexpr std::uint32_t opaque_alpha() const { return 0xFFU & ~alpha_mask(); }
    constexpr bool has_alpha() const { return alpha_bits > 0; }

    constexpr std::uint32_t z_of(std::uint32_t link_bits) const { return (link_bits >> z_shift) & z_mask(); }
    constexpr std::uint32_t alpha_of(std::uint32_t link_bits) const {
        return (link_bits >> alpha_shift) & alpha_mask();
    }
};

/// Messages list the names in this order.
inline constexpr std::array kDepthFormatTable{
    DepthLayout{DepthFormat::kA8Z16, "a8z16", 16, 0, 8, 16},
    DepthLayout{DepthFormat::kZ24, "z24", 24, 0, 0, 0},
};
static_assert(is_in_order(kDepthFormatTable));

constexpr const DepthLayout& layout_of(DepthFormat format) { return row_of(kDepthFormatTable, format); }

/// The far plane: all ones in the format's Z width.
constexpr std::uint32_t far_z(DepthFormat format) { return layout_of(format).z_mask(); }

}  // namespace metabuffer
