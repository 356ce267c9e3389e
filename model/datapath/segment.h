#pragma once

#include <cstdint>

#include "formats/viewport_table.h"

namespace metabuffer {

/// Index arithmetic of one composer's segment on its display's raster (section 5.2 of the paper). Pixel k of the
/// segment, counted in its raster order, is needed from its first use to its last. That is one raster position with
/// dmultiple = 1, otherwise a block that is read row after row from the moving window. Positions on the raster are
/// counted in raster order from 0. The row must be valid for the raster (see validate_table).
class Segment {
  public:
    Segment() = default;
    Segment(const ViewportRow& row, int raster_width_pixels, int raster_height_pixels);

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

    /// Raster position that needs pixel k first.
    std::int64_t first_use(std::int64_t k) const;

    /// Raster position that needs pixel k last; the pixel is released there.
    std::int64_t last_use(std::int64_t k) const;

    /// How many pixels of the segment have been released once `position` raster pixels are composited: the
    /// number of k with last_use(k) < position.
    std::int64_t released_before(std::int64_t position) const;

  private:
    ViewportRow row_;
    int raster_width_ = 0;
    int left_ = 0;
    int right_ = 0;
    int top_ = 0;
    int bottom_ = 0;
};

}  // namespace metabuffer
