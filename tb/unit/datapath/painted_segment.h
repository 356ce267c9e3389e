#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "formats/viewport_table.h"
#include "support/rows.h"

namespace metabuffer::test {

/// What a raster shows of a segment when each source pixel is painted repetition by repetition.
struct PaintedSegment {
    static constexpr std::int64_t kNone = -1;

    std::vector<std::int64_t> owner;  ///< segment pixel at each raster position, or kNone
    std::vector<std::int64_t> first;  ///< first raster position of each segment pixel
    std::vector<std::int64_t> last;

    PaintedSegment(const ViewportRow& row, Size raster)
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

}  // namespace metabuffer::test
