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

/// Index arithmetic of one composer's segment on its display's raster (section 5.2 of the paper). The segment's pixels k
/// and the raster's positions count from 0 in raster order. Pixel k is needed from its first use to its last: at one
/// position with dmultiple = 1, otherwise in a block of positions. The row must be valid for the raster (see
/// validate_table).
///
/// With smoothing up to four pixels go into a raster pixel, so a pixel is also needed in the half blocks around its own
/// block (smoothing_reach). Pixels come and are released in order: a position waits for the newest of its pixels, and a
/// pixel is released with the last use of those before it. Source lines beside the raster may be needed nowhere: rows
/// above the raster are released at the frame's start, other lines as if the raster had cut them short.
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

    /// The first raster position that needs pixel k or a later one; never() if there is none.
    std::int64_t first_use(std::int64_t k) const;

    /// The raster position that releases pixel k; -1: the frame's start does.
    std::int64_t last_use(std::int64_t k) const;

    /// How many pixels of the segment have been released once the frame has started and `position` raster pixels are
    /// composited: the number of k with last_use(k) < position.
    std::int64_t released_before(std::int64_t position) const;

    // ---- smoothing ----

    static constexpr std::int64_t kNoPixel = -1;

    /// Several pixels may go into a raster pixel.
    bool smooths() const { return reach_ > 0; }
    int reach() const { return reach_; }
    /// The position after the raster's last.
    std::int64_t never() const { return std::int64_t{raster_width_} * raster_height_; }
    /// Pixels of source rows above the raster that no raster pixel needs: the frame's start releases them.
    std::int64_t skipped_pixels() const { return std::int64_t{skipped_rows_} * row_.sdx; }
    /// Some pixels are not needed by any raster pixel.
    bool has_unused_pixels() const;
    /// The pixels that go into a covered raster pixel; kNoPixel for a neighbour that is not there.
    BlendWindow<std::int64_t> window_at(int x, int y) const;
    /// The newest pixel that a covered raster position needs.
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
