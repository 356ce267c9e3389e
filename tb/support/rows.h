#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "formats/viewport_table.h"
#include "support/random_seed.h"

namespace metabuffer::test {

struct Position {
    int x = 0;
    int y = 0;
};
struct Size {
    int width = 0;
    int height = 0;
};

/// A table row: `size` source pixels from `source`, to `destination` on the raster of display `dcomp`.
inline ViewportRow table_row(int dcomp, Position source, Size size, Position destination, int multiple = 1) {
    ViewportRow row;
    row.dcomp = static_cast<std::uint16_t>(dcomp);
    row.sx = static_cast<std::uint16_t>(source.x);
    row.sy = static_cast<std::uint16_t>(source.y);
    row.sdx = static_cast<std::uint16_t>(size.width);
    row.sdy = static_cast<std::uint16_t>(size.height);
    row.dx = static_cast<std::int16_t>(destination.x);
    row.dy = static_cast<std::int16_t>(destination.y);
    row.dmultiple = static_cast<std::uint16_t>(multiple);
    return row;
}

/// The row of a segment that begins at the image's first pixel.
inline ViewportRow segment_row(Size size, Position destination = {}, int multiple = 1, int dcomp = 1) {
    return table_row(dcomp, {0, 0}, size, destination, multiple);
}

/// One axis of a row that is valid there: how many source pixels, from where, to where.
struct RowAxis {
    int source = 0;
    int count = 1;
    int destination = 0;
};

/// Both the first and the last source pixel show at least in part.
inline RowAxis random_row_axis(Random& random, int image, int raster, int multiple) {
    RowAxis axis;
    const int most = std::min(image, (raster + 2 * multiple - 2) / multiple);
    axis.count = random.one_in(3) ? most : random.between(1, most);
    axis.source = random.between(0, image - axis.count);
    const int highest = std::min(raster - 1, raster + multiple - axis.count * multiple - 1);
    axis.destination = random.between(1 - multiple, highest);
    return axis;
}

/// A row that is valid on its own if the buffer is large enough, clipped at any side.
inline ViewportRow random_row(Random& random, Size image, Size raster, int display, int multiple) {
    const RowAxis x = random_row_axis(random, image.width, raster.width, multiple);
    const RowAxis y = random_row_axis(random, image.height, raster.height, multiple);
    return table_row(display, {x.source, y.source}, {x.count, y.count}, {x.destination, y.destination},
                     multiple);
}
inline ViewportRow random_row(Random& random, const ViewportLimits& limits, int display, int multiple) {
    return random_row(random, {limits.image_width_pixels, limits.image_height_pixels},
                      {limits.raster_width_pixels, limits.raster_height_pixels}, display, multiple);
}
/// The same for display 1, of an image that is no smaller than the raster.
inline ViewportRow random_valid_row(Random& random, Size raster, int largest_multiple) {
    const int multiple = random.one_in(3) ? 1 : random.between(1, largest_multiple);
    return random_row(random, raster, raster, 1, multiple);
}

/// The same for a composer that smooths: the outermost source lines may lie beside the raster.
inline ViewportRow random_smoothed_row(Random& random, Size raster, int largest_multiple) {
    ViewportLimits limits;
    limits.displays = 1;
    limits.image_width_pixels = raster.width + 2;
    limits.image_height_pixels = raster.height + 2;
    limits.raster_width_pixels = raster.width;
    limits.raster_height_pixels = raster.height;
    limits.buffer_pixels = 1 << 24;
    limits.smoothing = Smoothing::kBilinear;
    for (;;) {
        const int m = random.one_in(6) ? 1 : random.between(2, largest_multiple);
        const auto count = [&](int size) {
            return random.between(1, std::min(size, (size + m - 1) / m) + 2);
        };
        const ViewportRow row = segment_row(
            {count(raster.width), count(raster.height)},
            {random.between(1 - 2 * m, raster.width - 1), random.between(1 - 2 * m, raster.height - 1)}, m);
        if (row_defect(row, limits) == RowDefect::kNone) return row;
    }
}

/// Such rows, all for the same display, as the bus of one renderer may carry them.
inline ViewportTable random_valid_rows(Random& random, int rows, Size raster, int largest_multiple) {
    ViewportTable table;
    for (; rows > 0; --rows) table.push_back(random_valid_row(random, raster, largest_multiple));
    return table;
}

/// Puts the rows in any order, which is their order on the bus.
inline void shuffle_rows(Random& random, ViewportTable& table) {
    for (std::size_t i = table.size(); i > 1; --i) {
        std::swap(table[i - 1], table[static_cast<std::size_t>(random.between(0, static_cast<int>(i) - 1))]);
    }
}

}  // namespace metabuffer::test
