#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "formats/viewport_table.h"
#include "random_seed.h"

namespace metabuffer::test {

struct RasterSize {
    int width = 0;
    int height = 0;
};

/// What a raster shows of a segment when each source pixel is painted repetition by repetition.
struct PaintedSegment {
    static constexpr std::int64_t kNone = -1;

    std::vector<std::int64_t> owner;  ///< segment pixel at each raster position, or kNone
    std::vector<std::int64_t> first;  ///< first raster position of each segment pixel
    std::vector<std::int64_t> last;

    PaintedSegment(const ViewportRow& row, RasterSize raster)
        : owner(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height), kNone),
          first(std::size_t{row.sdx} * row.sdy, std::numeric_limits<std::int64_t>::max()),
          last(first.size(), kNone) {
        std::size_t k = 0;
        for (int j = 0; j < row.sdy; ++j) {
            for (int i = 0; i < row.sdx; ++i, ++k) {
                for (int y = row.dy + j * row.dmultiple; y < row.dy + (j + 1) * row.dmultiple; ++y) {
                    for (int x = row.dx + i * row.dmultiple; x < row.dx + (i + 1) * row.dmultiple; ++x) {
                        if (x < 0 || x >= raster.width || y < 0 || y >= raster.height) continue;
                        const std::int64_t position = std::int64_t{y} * raster.width + x;
                        owner[static_cast<std::size_t>(position)] = static_cast<std::int64_t>(k);
                        if (position < first[k]) first[k] = position;
                        if (position > last[k]) last[k] = position;
                    }
                }
            }
        }
    }
};

/// A valid row on the raster: its first and its last source pixel show, clipped at any side.
inline ViewportRow random_valid_row(Random& random, RasterSize raster, int largest_multiple) {
    const int multiple = random.one_in(3) ? 1 : random.between(1, largest_multiple);
    const auto extent = [&](int size, int& count) {
        const int from = random.between(1 - multiple, size - 1);
        int most = 1;
        while (from + most * multiple < size) ++most;
        count = random.one_in(3) ? most : random.between(1, most);
        return from;
    };
    int sdx = 0;
    int sdy = 0;
    const int dx = extent(raster.width, sdx);
    const int dy = extent(raster.height, sdy);
    ViewportRow row;
    row.dcomp = 1;
    row.sdx = static_cast<std::uint16_t>(sdx);
    row.sdy = static_cast<std::uint16_t>(sdy);
    row.dx = static_cast<std::int16_t>(dx);
    row.dy = static_cast<std::int16_t>(dy);
    row.dmultiple = static_cast<std::uint16_t>(multiple);
    return row;
}

}  // namespace metabuffer::test
