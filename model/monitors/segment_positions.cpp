#include "monitors/segment_positions.h"

#include <algorithm>
#include <cstddef>

namespace metabuffer::monitors {
namespace {

/// [first, first + length) overlaps with [0, end).
bool shows(int first, int length, int end) { return first < end && first + length > 0; }

}  // namespace

SegmentPositions::SegmentPositions(const ViewportRow& row, int raster_width_pixels, int raster_height_pixels,
                                   Smoothing smoothing)
    : dx_(row.dx),
      dy_(row.dy),
      width_(row.sdx),
      height_(row.sdy),
      multiple_(std::max<int>(row.dmultiple, 1)),
      right_(std::min(raster_width_pixels, dx_ + width_ * multiple_)),
      bottom_(std::min(raster_height_pixels, dy_ + height_ * multiple_)) {
    smooths_ = smoothing == Smoothing::kBilinear && multiple_ > 1;
    const auto axis_is_legal = [this](int first, int count, int end) {
        // The outermost line may lie outside if the one beside it goes into what shows.
        const int inset = smooths_ && count > 1 ? multiple_ : 0;
        const int last = first + (count - 1) * multiple_;
        return first < end && shows(first, multiple_ + inset, end) && last + multiple_ > 0 &&
               shows(last - inset, multiple_ + inset, end);
    };
    legal_ = row.dmultiple >= 1 && row.dmultiple <= kMaximumMultiple && width_ > 0 && height_ > 0 &&
             axis_is_legal(dx_, width_, raster_width_pixels) &&
             axis_is_legal(dy_, height_, raster_height_pixels);
    smooths_ = smooths_ && legal_;
    if (smooths_) {
        find_last_uses();
    }
}

void SegmentPositions::find_last_uses() {
    last_column_.assign(static_cast<std::size_t>(width_), -1);
    for (int x = left(); x < right_; ++x) {
        const ReferenceLines lines = columns_at(x);
        last_column_[static_cast<std::size_t>(lines.own)] = x;
        last_column_[static_cast<std::size_t>(lines.other)] = x;
    }
    last_row_.assign(static_cast<std::size_t>(height_), -1);
    for (int y = std::max(dy_, 0); y < bottom_; ++y) {
        const ReferenceLines lines = rows_at(y);
        last_row_[static_cast<std::size_t>(lines.own)] = y;
        last_row_[static_cast<std::size_t>(lines.other)] = y;
    }
}

std::int64_t SegmentPositions::used_up_after(int x, int y, std::int64_t used_up) const {
    for (; used_up < pixels(); ++used_up) {
        const int last_y = last_row_[static_cast<std::size_t>(used_up / width_)];
        const int last_x = last_column_[static_cast<std::size_t>(used_up % width_)];
        if (last_y > y || (last_y == y && y >= 0 && last_x > x)) {
            break;
        }
    }
    return used_up;
}

SegmentPositions::RasterRow SegmentPositions::raster_row(int y) const {
    RasterRow row;
    row.covered = y >= dy_ && y < bottom_;
    if (row.covered) {
        const int repetition = (y - dy_) % multiple_;
        row.repeats = y > 0 && repetition > 0;
        row.last = repetition == multiple_ - 1 || y == bottom_ - 1;
        row.first_pixel = std::int64_t{(y - dy_) / multiple_} * width_;
    }
    return row;
}

}  // namespace metabuffer::monitors
