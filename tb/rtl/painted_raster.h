#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <vector>

#include "report/composer_record.h"
#include "rtl/composer_signals.h"
#include "support/rows.h"

namespace metabuffer::test {

/// The record of a composer whose part is tested alone.
struct Record final : ComposerRecord {};

/// What a composer shows of a segment at each raster position, and when its pixels have had their last use: found by
/// painting every source pixel's block, and by the formula of docs/design.md where it smooths.
struct PaintedRaster {
    std::vector<RasterStep> steps;
    /// Pixels that have had their last use before the first position.
    std::int64_t skipped = 0;
    /// How many have had it once a position is composited.
    std::vector<std::int64_t> released;

    PaintedRaster(const std::optional<ViewportRow>& row, const Size& raster,
                  Smoothing smoothing = Smoothing::kReplicate)
        : steps(static_cast<std::size_t>(raster.width * raster.height)), released(steps.size()) {
        steps.back().last = true;
        if (!row) return;
        paint(*row, raster, smoothing == Smoothing::kBilinear && row->dmultiple > 1);
        find_last_uses(*row, raster.width);
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

    /// Pixels are released in order. A source line that nothing needs is released as if the raster cut it short: a row
    /// above before the first position, a column on the left in the raster's first one, others with those beside them.
    void find_last_uses(const ViewportRow& row, int raster_width) {
        constexpr int kNever = -1;
        std::vector<int> last(static_cast<std::size_t>(row.sdx * row.sdy), kNever);
        int left = row.sdx, right = 0, top = row.sdy, bottom = 0;
        for (std::size_t position = 0; position < steps.size(); ++position) {
            const RasterStep& step = steps[position];
            if (!step.covered) continue;
            for (const std::int64_t across : {0, step.across}) {
                for (const std::int64_t beside : {0, step.beside}) {
                    const auto k = static_cast<int>(step.pixel + across + beside);
                    last[static_cast<std::size_t>(k)] = static_cast<int>(position);
                    left = std::min(left, k % row.sdx);
                    right = std::max(right, k % row.sdx);
                    top = std::min(top, k / row.sdx);
                    bottom = std::max(bottom, k / row.sdx);
                }
            }
        }
        skipped = std::int64_t{top} * row.sdx;
        int latest = kNever;
        for (int k = static_cast<int>(skipped); k < row.sdx * row.sdy; ++k) {
            const int column = k % row.sdx;
            const int used = std::min(k / row.sdx, bottom) * row.sdx + std::clamp(column, left, right);
            int position = last[static_cast<std::size_t>(used)];
            if (column < left) position -= position % raster_width;
            latest = std::max(latest, position);
            released[static_cast<std::size_t>(latest)] = k + 1;
        }
        std::int64_t so_far = skipped;
        for (std::int64_t& count : released) count = so_far = std::max(so_far, count);
    }
};

}  // namespace metabuffer::test
