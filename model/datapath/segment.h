#pragma once

#include <algorithm>
#include <cstdint>

#include "datapath/smoothing.h"
#include "formats/viewport_table.h"

namespace metabuffer {

/// Pixels of the largest segment on a raster: a smoothed one has up to two rows and columns that do not show.
constexpr std::int64_t most_segment_pixels(int raster_width_pixels, int raster_height_pixels) {
    return (raster_width_pixels + std::int64_t{2}) * (raster_height_pixels + std::int64_t{2});
}

/// Index arithmetic of one composer's segment on its display's raster (section 5.2 of the paper). Pixel k of the
/// segment, counted in its raster order, is needed from its first use to its last. That is one raster position with
/// dmultiple = 1, otherwise a block that is read row after row from the moving window. Positions on the raster are
/// counted in raster order from 0. The row must be valid for the raster (see validate_table).
///
/// With smoothing a raster pixel is mixed of up to four pixels, so a pixel is also needed in the half blocks around its
/// own one (smoothing_reach). Pixels come and are released in order. So a position waits for the newest of its pixels,
/// and a pixel is released with the last use of those before it. The outermost source lines may lie beside the raster,
/// and then need not be used at all: rows above are released at the frame's start, others as if they were cut short.
class Segment {
  public:
    Segment() = default;
    Segment(const ViewportRow& row, int raster_width_pixels, int raster_height_pixels,
            Smoothing smoothing = Smoothing::kReplicate);

    std::int64_t pixels() const { return std::int64_t{row_.sdx} * row_.sdy; }
    const ViewportRow& row() const { return row_; }

    /// First and one-past-last raster column and row of the segment, clipped to the raster.
    int left() const { return left_; }
    int right() const { return right_; }
    int top() const { return top_; }
    int bottom() const { return bottom_; }

    bool covers(int x, int y) const { return x >= left_ && x < right_ && y >= top_ && y < bottom_; }

    /// The segment pixel shown at a raster position that the segment covers.
    std::int64_t pixel_at(int x, int y) const {
        const int i = (x - row_.dx) / row_.dmultiple;
        const int j = (y - row_.dy) / row_.dmultiple;
        return std::int64_t{j} * row_.sdx + i;
    }

    /// Raster position that cannot be composited without pixel k and those before it; never() if there is none.
    std::int64_t first_use(std::int64_t k) const;

    /// Raster position that releases pixel k; -1 for one that the frame's start releases.
    std::int64_t last_use(std::int64_t k) const;

    /// How many pixels of the segment have been released once the frame has started and `position` raster pixels are
    /// composited: the number of k with last_use(k) < position.
    std::int64_t released_before(std::int64_t position) const;

    // ---- smoothing ----

    static constexpr std::int64_t kNoPixel = -1;

    /// More than one pixel goes into a raster pixel.
    bool smooths() const { return reach_ > 0; }
    int reach() const { return reach_; }
    /// After the last raster position.
    std::int64_t never() const { return std::int64_t{raster_width_} * raster_height_; }
    /// Pixels that no raster pixel needs, of a source row above the raster: the frame's start releases them.
    std::int64_t skipped_pixels() const { return std::int64_t{skipped_rows_} * row_.sdx; }
    /// Some pixels are not needed by any raster pixel.
    bool has_unused_pixels() const;
    /// The pixels that go into a raster pixel that the segment covers; kNoPixel for a neighbour that is not there.
    BlendWindow<std::int64_t> window_at(int x, int y) const;
    /// The newest pixel that a raster position that the segment covers needs.
    std::int64_t newest_at(int x, int y) const;

    /// A half-open range of raster columns or rows.
    struct Range {
        int begin = 0;
        int end = 0;
    };
    /// Raster columns at which the segment's column i is the newest one needed, and the same for rows.
    Range newest_columns(int i) const {
        return {std::clamp(need_begins(row_.dx, i), left_, right_),
                i + 1 < row_.sdx ? std::clamp(need_begins(row_.dx, i + 1), left_, right_) : right_};
    }
    Range newest_rows(int j) const {
        return {std::clamp(need_begins(row_.dy, j), top_, bottom_),
                j + 1 < row_.sdy ? std::clamp(need_begins(row_.dy, j + 1), top_, bottom_) : bottom_};
    }

  private:
    /// Where the need of source line i of an axis begins and ends, not clipped.
    int need_begins(int destination, int i) const {
        return destination + i * row_.dmultiple - (i > 0 ? reach_ : 0);
    }
    int need_ends(int destination, int i, int count) const {
        return destination + (i + 1) * row_.dmultiple + (i + 1 < count ? reach_ : 0);
    }
    std::int64_t position(int x, int y) const { return std::int64_t{y} * raster_width_ + x; }
    std::int64_t smoothed_first_use(int i, int j) const;
    std::int64_t smoothed_last_use(int i, int j) const;
    std::int64_t smoothed_released_before(std::int64_t position) const;

    ViewportRow row_;
    int raster_width_ = 0;
    int raster_height_ = 0;
    int left_ = 0;
    int right_ = 0;
    int top_ = 0;
    int bottom_ = 0;
    int reach_ = 0;
    int skipped_rows_ = 0;
};

}  // namespace metabuffer
