#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "formats/viewport_table.h"
#include "monitors/reference_composition.h"

namespace metabuffer::monitors {

/// The positions of a table row's segment on its display's raster, by division. Written independently of
/// model/datapath, which it checks. Pixels count from 0 in their segment's raster order. Any row can be given, also one
/// that no table may have.
class SegmentPositions {
  public:
    SegmentPositions() = default;
    SegmentPositions(const ViewportRow& row, int raster_width_pixels, int raster_height_pixels,
                     Smoothing smoothing = Smoothing::kReplicate);

    /// Pixels that the bus sends for the row.
    std::int64_t pixels() const { return std::int64_t{width_} * height_; }
    int source_width() const { return width_; }
    int multiple() const { return multiple_; }
    /// First and one past the last column of the raster in which the segment shows.
    int left() const { return std::max(dx_, 0); }
    int right() const { return right_; }
    /// The row is one that a table may carry for this raster: a multiple of 1 to 255, a source that is not empty, its
    /// first and last pixel on the raster at least in part, or, smoothed, its second and last but one.
    bool legal() const { return legal_; }

    /// A row of the raster.
    struct RasterRow {
        bool covered = false;          ///< the segment shows in it
        bool repeats = false;          ///< the same source row as in the raster row above
        bool last = false;             ///< the source row does not show below it
        std::int64_t first_pixel = 0;  ///< of the source row
    };
    RasterRow raster_row(int y) const;

    /// Only in a covered row: the segment shows at that column of the raster.
    bool covers(int x) const { return x >= dx_ && x < right_; }
    /// Only at a covered position: the pixel's index in its source row.
    int column_at(int x) const { return multiple_ == 1 ? x - dx_ : (x - dx_) / multiple_; }
    /// Only at a covered position: pixels of the source row that do not show to the right of it.
    int columns_used_up(int x) const { return x + 1 == right_ ? width_ : column_at(x + 1); }

    // ---- smoothing ----

    bool smooths() const { return smooths_; }
    /// How many pixels, from the first on, no position needs after (x, y), given that the first `used_up` are not
    /// needed. y = -1: before the frame's first position. What no position needs goes with those before it, in the last
    /// raster row of its source row.
    std::int64_t used_up_after(int x, int y, std::int64_t used_up) const;
    /// The two source lines that are mixed at a covered column or row of the raster.
    ReferenceLines columns_at(int x) const { return reference_lines(x - dx_, width_, multiple_); }
    ReferenceLines rows_at(int y) const { return reference_lines(y - dy_, height_, multiple_); }

  private:
    void find_last_uses();

    int dx_ = 0;
    int dy_ = 0;
    int width_ = 0;   ///< source pixels
    int height_ = 0;  ///< source pixels
    int multiple_ = 1;
    int right_ = 0;   ///< one past the last covered column of the raster
    int bottom_ = 0;  ///< one past the last covered row
    bool legal_ = false;
    bool smooths_ = false;
    std::vector<int>
        last_column_;  ///< smoothed: by source column, the last raster column that it goes into; -1: none
    std::vector<int> last_row_;  ///< the same of source rows
};

}  // namespace metabuffer::monitors
