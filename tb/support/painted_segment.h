#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "datapath/composer_buffer.h"
#include "formats/viewport_table.h"
#include "support/rows.h"

namespace metabuffer::test {

/// What a raster shows of a segment, and from when to when it needs each pixel: found by painting the block of every
/// source pixel, and by the formula of docs/design.md where they are mixed. It judges whatever counts or divides instead.
struct PaintedSegment {
    static constexpr std::int64_t kNone = -1;
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

    // At each position of the raster.
    std::vector<RasterStep> steps;
    std::vector<std::int64_t> newest;    ///< of the pixels that go into it, or kNone
    std::vector<std::int64_t> released;  ///< how many pixels are not needed behind it

    // Of each pixel of the segment.
    std::vector<std::int64_t> first;  ///< position that needs it or one that comes after it, or kNever
    std::vector<std::int64_t> last;   ///< the one that releases it and those before it; -1: the frame's start
    std::vector<bool> used;           ///< it goes into some position

    std::int64_t skipped = 0;  ///< pixels that the frame's start releases

    PaintedSegment(const std::optional<ViewportRow>& row, const Size& raster,
                   Smoothing smoothing = Smoothing::kReplicate)
        : steps(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height)),
          newest(steps.size(), kNone),
          released(steps.size()) {
        steps.back().last = true;
        if (!row) return;
        paint(*row, raster, smoothing == Smoothing::kBilinear && row->dmultiple > 1);
        find_uses(*row, raster);
    }

    /// The pixel that a position shows, or kNone.
    std::int64_t owner(std::int64_t position) const {
        const RasterStep& step = steps[static_cast<std::size_t>(position)];
        return step.covered ? step.pixel : kNone;
    }
    /// The four pixels that a position is mixed of: its own one, beside, across, and both. Where there is none, the own
    /// one is again.
    static std::vector<std::int64_t> parts(const RasterStep& step) {
        if (!step.covered) return {};
        return {step.pixel, step.pixel + step.beside, step.pixel + step.across,
                step.pixel + step.beside + step.across};
    }

  private:
    /// The source line beside one at a raster line of its block, and its weight of 256.
    struct Neighbour {
        int side = 0;
        int weight = 0;
        Neighbour(int phase, int multiple, int line, int count) {
            if (2 * phase + 1 < multiple && line > 0) side = -1;
            if (2 * phase + 1 > multiple && line + 1 < count) side = 1;
            if (side != 0) weight = 256 * std::abs(2 * phase + 1 - multiple) / (2 * multiple);
        }
    };

    void paint(const ViewportRow& row, const Size& raster, bool smooths) {
        const int m = row.dmultiple;
        for (int k = 0; k < row.sdx * row.sdy; ++k) {
            const int i = k % row.sdx;
            const int j = k / row.sdx;
            for (int repetition = 0; repetition < m * m; ++repetition) {
                const int x = row.dx + i * m + repetition % m;
                const int y = row.dy + j * m + repetition / m;
                if (x < 0 || x >= raster.width || y < 0 || y >= raster.height) continue;
                RasterStep& step = steps[static_cast<std::size_t>(y * raster.width + x)];
                step.covered = true;
                step.pixel = k;
                step.replayed = y > std::max(0, row.dy + j * m);
                if (!smooths) continue;
                const Neighbour beside(repetition % m, m, i, row.sdx);
                const Neighbour across(repetition / m, m, j, row.sdy);
                step.beside = beside.side;
                step.weight_x = static_cast<std::uint8_t>(beside.weight);
                step.across = across.side * row.sdx;
                step.weight_y = static_cast<std::uint8_t>(across.weight);
            }
        }
    }

    /// Pixels come and are released in order. What nothing needs is released with the pixel before it. But where the
    /// first column lies beside the raster, it is released as if the raster cut it: in column 0.
    void find_uses(const ViewportRow& row, const Size& raster) {
        const auto pixels = static_cast<std::size_t>(row.sdx) * row.sdy;
        first.assign(pixels, kNever);
        last.assign(pixels, kNone);
        used.assign(pixels, false);
        const auto positions = static_cast<std::int64_t>(steps.size());
        std::size_t needed = 0;
        for (std::int64_t position = 0; position < positions; ++position) {
            std::int64_t& most = newest[static_cast<std::size_t>(position)];
            for (const std::int64_t k : parts(steps[static_cast<std::size_t>(position)])) {
                most = std::max(most, k);
                last[static_cast<std::size_t>(k)] = position;
                used[static_cast<std::size_t>(k)] = true;
            }
            while (static_cast<std::int64_t>(needed) <= most) first[needed++] = position;
        }
        std::int64_t latest = kNone;
        for (std::size_t k = 0; k < pixels; ++k) {
            if (row.sdx > 1 && k % row.sdx == 0 && !used[k] && used[k + 1]) {
                last[k] = last[k + 1] - last[k + 1] % raster.width;
            }
            latest = last[k] = std::max(latest, last[k]);
        }
        skipped = std::count(last.begin(), last.end(), kNone);
        for (std::size_t position = 0; position < steps.size(); ++position) {
            released[position] =
                std::upper_bound(last.begin(), last.end(), static_cast<std::int64_t>(position)) -
                last.begin();
        }
    }
};

}  // namespace metabuffer::test
