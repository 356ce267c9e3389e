#pragma once

#include <algorithm>
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
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

    std::vector<std::int64_t> owner;  ///< segment pixel at each raster position, or kNone
    /// First raster position that cannot be composited without each segment pixel and those before it, or kNever.
    std::vector<std::int64_t> first;
    std::vector<std::int64_t> last;  ///< the one that releases it; -1 for the frame's start

    // With smoothing a raster position needs more than its own pixel; without, these say the same.
    std::vector<std::int64_t> newest;  ///< needed at each raster position, or kNone
    std::vector<std::int64_t>
        shown;  ///< first raster position that shows each segment pixel itself, or kNever

    PaintedSegment(const ViewportRow& row, Size raster, Smoothing smoothing = Smoothing::kReplicate)
        : owner(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height), kNone),
          first(std::size_t{row.sdx} * row.sdy, kNever),
          last(first.size(), kNone),
          newest(owner.size(), kNone),
          shown(first.size(), kNever) {
        std::size_t k = 0;
        for (int j = 0; j < row.sdy; ++j) {
            for (int i = 0; i < row.sdx; ++i, ++k) {
                for (int y = row.dy + j * row.dmultiple; y < row.dy + (j + 1) * row.dmultiple; ++y) {
                    for (int x = row.dx + i * row.dmultiple; x < row.dx + (i + 1) * row.dmultiple; ++x) {
                        if (x < 0 || x >= raster.width || y < 0 || y >= raster.height) continue;
                        const std::int64_t position = std::int64_t{y} * raster.width + x;
                        owner[static_cast<std::size_t>(position)] = static_cast<std::int64_t>(k);
                        newest[static_cast<std::size_t>(position)] = static_cast<std::int64_t>(k);
                        if (position < first[k]) first[k] = position;
                        if (position > last[k]) last[k] = position;
                    }
                }
            }
        }
        shown = first;
        if (smoothing == Smoothing::kBilinear && row.dmultiple > 1) smooth(row, raster);
    }

  private:
    /// The neighbour of source line `own` that raster line `at` of its block is mixed with; `own` if there is none.
    static int neighbour(int own, int at, int multiple, int count) {
        const double off_centre = at + 0.5 - multiple / 2.0;
        const int other = off_centre < 0.0 ? own - 1 : (off_centre > 0.0 ? own + 1 : own);
        return other >= 0 && other < count ? other : own;
    }

    /// Each raster position uses the source lines of its own pixel and the neighbours of both axes.
    void smooth(const ViewportRow& row, Size raster) {
        const int m = row.dmultiple;
        std::vector<std::int64_t> last_column(row.sdx, kNone);
        std::vector<std::int64_t> last_row(row.sdy, kNone);
        std::fill(first.begin(), first.end(), kNever);
        std::int64_t left = kNever;
        std::int64_t bottom = kNone;
        bool used_rows_begin = false;
        for (std::size_t position = 0; position < owner.size(); ++position) {
            if (owner[position] == kNone) continue;
            const auto x = static_cast<int>(position % static_cast<std::size_t>(raster.width));
            const auto y = static_cast<int>(position / static_cast<std::size_t>(raster.width));
            const auto i = static_cast<int>(owner[position] % row.sdx);
            const auto j = static_cast<int>(owner[position] / row.sdx);
            const int other_i = neighbour(i, x - row.dx - i * m, m, row.sdx);
            const int other_j = neighbour(j, y - row.dy - j * m, m, row.sdy);
            for (const int column : {i, other_i}) {
                auto& of = last_column[static_cast<std::size_t>(column)];
                of = std::max<std::int64_t>(of, x);
            }
            for (const int line : {j, other_j}) last_row[static_cast<std::size_t>(line)] = y;
            newest[position] = std::int64_t{std::max(j, other_j)} * row.sdx + std::max(i, other_i);
            left = std::min<std::int64_t>(left, x);
            bottom = std::max<std::int64_t>(bottom, y);
        }
        for (std::size_t position = owner.size(); position-- > 0;) {
            // What needs a pixel needs those before it, since they come first.
            for (std::int64_t k = 0; newest[position] != kNone && k <= newest[position]; ++k) {
                first[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(position);
            }
        }
        std::int64_t released = kNone;
        for (std::size_t k = 0; k < last.size(); ++k) {
            const std::int64_t of_row = last_row[k / row.sdx];
            const std::int64_t of_column = last_column[k % row.sdx];
            used_rows_begin = used_rows_begin || of_row != kNone;
            if (!used_rows_begin) {
                last[k] = kNone;  // a row above the raster that nothing is mixed with
                continue;
            }
            const std::int64_t y = of_row == kNone ? bottom : of_row;
            const std::int64_t x = of_column == kNone ? left : of_column;
            released = std::max(released, y * raster.width + x);
            last[k] = released;  // in the order in which they came
        }
    }
};

}  // namespace metabuffer::test
