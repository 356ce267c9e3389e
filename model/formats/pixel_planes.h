#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace metabuffer {

/// Pixels with colour and depth apart, for code that works on runs of pixels. Row by row from the top left.
struct PixelPlanes {
    int width_pixels = 0;
    int height_pixels = 0;
    std::vector<std::uint32_t> argb;  ///< A [31:24], R [23:16], G [15:8], B [7:0]
    std::vector<std::uint32_t> z;     ///< 24 bits at most

    PixelPlanes() = default;
    PixelPlanes(int width, int height)
        : width_pixels(width),
          height_pixels(height),
          argb(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
          z(argb.size()) {}

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_pixels) +
               static_cast<std::size_t>(x);
    }
};

}  // namespace metabuffer
