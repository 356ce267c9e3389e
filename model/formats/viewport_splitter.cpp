#include "formats/viewport_splitter.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace metabuffer {
namespace {

constexpr std::int64_t floor_div(std::int64_t dividend, std::int64_t divisor) {
    const std::int64_t quotient = dividend / divisor;
    return dividend % divisor < 0 ? quotient - 1 : quotient;
}

/// The source pixels of one axis that show on one display, and where the first of them lies on its raster.
struct Span {
    std::int64_t first = 0;
    std::int64_t count = 0;
    std::int64_t destination = 0;
};

/// `position` is the image's start relative to the display's first raster pixel. A source pixel belongs to
/// the display if any of its `multiple` repetitions lies in 0 .. raster - 1, or if `apron` more do on each side.
Span visible_span(std::int64_t position, std::int64_t multiple, std::int64_t image, std::int64_t raster,
                  std::int64_t apron) {
    std::int64_t first = std::max<std::int64_t>(0, floor_div(-position, multiple));
    std::int64_t last = std::min(image - 1, floor_div(raster - 1 - position, multiple));
    if (first <= last) {
        first = std::max<std::int64_t>(0, first - apron);
        last = std::min(image - 1, last + apron);
    }
    return {first, std::max<std::int64_t>(0, last - first + 1), position + first * multiple};
}

template <typename Field>
Field row_field(const char* name, std::int64_t value) {
    constexpr std::int64_t kLowest = std::numeric_limits<Field>::min();
    constexpr std::int64_t kHighest = std::numeric_limits<Field>::max();
    if (value < kLowest || value > kHighest) {
        throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) +
                                    " does not fit its 16-bit field: " + std::to_string(kLowest) + " to " +
                                    std::to_string(kHighest));
    }
    return static_cast<Field>(value);
}

ViewportRow make_row(std::int64_t display, const Span& x, const Span& y, int multiple) {
    ViewportRow row;
    row.dcomp = row_field<std::uint16_t>("Dcomp", display);
    row.sx = row_field<std::uint16_t>("Sx", x.first);
    row.sy = row_field<std::uint16_t>("Sy", y.first);
    row.sdx = row_field<std::uint16_t>("Sdx", x.count);
    row.sdy = row_field<std::uint16_t>("Sdy", y.count);
    row.dx = row_field<std::int16_t>("Dx", x.destination);
    row.dy = row_field<std::int16_t>("Dy", y.destination);
    row.dmultiple = static_cast<std::uint16_t>(multiple);
    return row;
}

}  // namespace

ViewportTable split_viewport(const Viewport& viewport, int image_width_pixels, int image_height_pixels,
                             const DisplayWall& wall, Smoothing smoothing) {
    const int multiple = viewport.multiple;
    if (multiple < 1 || multiple > kMaximumMultiple) {
        throw std::invalid_argument("multiple " + std::to_string(multiple) + " is outside 1 to " +
                                    std::to_string(kMaximumMultiple));
    }
    const std::int64_t raster_width = wall.raster_width_pixels;
    const std::int64_t raster_height = wall.raster_height_pixels;
    const std::int64_t pitch_x = raster_width + wall.gap_x_pixels;
    const std::int64_t pitch_y = raster_height + wall.gap_y_pixels;
    const std::int64_t apron = smoothing_reach(smoothing, multiple) > 0 ? 1 : 0;
    ViewportTable table;
    std::int64_t display = 0;
    for (int row = 0; row < wall.rows; ++row) {
        const Span y =
            visible_span(viewport.y - row * pitch_y, multiple, image_height_pixels, raster_height, apron);
        for (int column = 0; column < wall.columns; ++column) {
            ++display;
            const Span x = visible_span(viewport.x - column * pitch_x, multiple, image_width_pixels,
                                        raster_width, apron);
            if (x.count > 0 && y.count > 0) table.push_back(make_row(display, x, y, multiple));
        }
    }
    return table;
}

}  // namespace metabuffer
