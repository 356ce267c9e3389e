#pragma once

#include <cstdint>
#include <optional>

#include "formats/image.h"

namespace metabuffer {

/// Where two pictures differ.
struct ImageDifference {
    std::int64_t pixels = 0;  ///< how many differ
    int x = 0;                ///< the first of them, row by row
    int y = 0;
    std::uint32_t left = 0;  ///< its values
    std::uint32_t right = 0;
};

/// Of two pictures of one size; nothing if they are the same.
std::optional<ImageDifference> image_difference(const ColourImage& left, const ColourImage& right);

}  // namespace metabuffer
