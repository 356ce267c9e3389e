#pragma once

#include <array>
#include <cstdint>

#include "host/enum_table.h"

namespace metabuffer {

/// How a composer magnifies its segment (section 5.2 of the paper).
enum class Smoothing : std::uint8_t {
    kReplicate,  ///< a source pixel fills its block of raster pixels
    kBilinear,   ///< a raster pixel is mixed of the source pixels around it
};

struct SmoothingRow {
    Smoothing value;
    const char* name;
    int window_rows;  ///< source rows that a composer must hold at once to magnify
};

/// Messages list the names in this order.
inline constexpr std::array kSmoothingTable{
    SmoothingRow{Smoothing::kReplicate, "replicate", 1},
    SmoothingRow{Smoothing::kBilinear, "bilinear", 2},
};
static_assert(is_in_order(kSmoothingTable));

/// Source rows that a composer must hold at once: none at the multiple 1, where each pixel is used once.
constexpr int window_rows(Smoothing smoothing, int multiple) {
    return multiple > 1 ? row_of(kSmoothingTable, smoothing).window_rows : 0;
}

/// How far beyond its own block a source pixel is mixed in, in raster pixels on each side: half of the next block.
constexpr int smoothing_reach(Smoothing smoothing, int multiple) {
    return smoothing == Smoothing::kBilinear ? multiple / 2 : 0;
}

}  // namespace metabuffer
