#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "formats/pixel.h"
#include "host/range.h"

namespace metabuffer {

/// How wide and how high a renderer's image may be.
constexpr IntegerRange kImageSidePixels{1, 8192};

struct ImageSize {
    int width_pixels = 0;
    int height_pixels = 0;
};

/// A raster of values, row by row from the top left.
template <typename Value>
struct Raster {
    int width_pixels = 0;
    int height_pixels = 0;
    std::vector<Value> values;

    Raster() = default;
    Raster(int width, int height, Value fill = Value{})
        : width_pixels(width),
          height_pixels(height),
          values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_pixels) +
               static_cast<std::size_t>(x);
    }
    Value& at(int x, int y) { return values[index(x, y)]; }
    const Value& at(int x, int y) const { return values[index(x, y)]; }

    friend bool operator==(const Raster& left, const Raster& right) {
        return left.width_pixels == right.width_pixels && left.height_pixels == right.height_pixels &&
               left.values == right.values;
    }
};

using PixelImage = Raster<Pixel>;           ///< a renderer's image: colour, alpha and Z
using ColourImage = Raster<std::uint32_t>;  ///< what a display shows: 0xRRGGBB

/// Pixels of an image whose depth lay outside of the depth range.
struct ClampedDepths {
    std::int64_t before_near_pixels = 0;
    std::int64_t behind_far_pixels = 0;

    bool any() const { return before_near_pixels + behind_far_pixels > 0; }
};

/// A renderer's image with what was found when its file was read.
struct ReadImage : PixelImage {
    ReadImage() = default;
    ReadImage(PixelImage image, const ClampedDepths& depths = {})
        : PixelImage(std::move(image)), clamped(depths) {}

    ClampedDepths clamped;
};

}  // namespace metabuffer
