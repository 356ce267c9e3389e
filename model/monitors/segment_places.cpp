#include "monitors/segment_places.h"

#include <algorithm>

namespace metabuffer::monitors {
namespace {

/// [place, place + length) overlaps with [0, end).
bool shows(int place, int length, int end) { return place < end && place + length > 0; }

}  // namespace

SegmentPlaces::SegmentPlaces(const ViewportRow& row, int raster_width_pixels, int raster_height_pixels)
    : dx_(row.dx),
      dy_(row.dy),
      width_(row.sdx),
      height_(row.sdy),
      multiple_(std::max<int>(row.dmultiple, 1)),
      right_(std::min(raster_width_pixels, dx_ + width_ * multiple_)),
      bottom_(std::min(raster_height_pixels, dy_ + height_ * multiple_)) {
    const int last_x = dx_ + (width_ - 1) * multiple_;
    const int last_y = dy_ + (height_ - 1) * multiple_;
    legal_ = row.dmultiple >= 1 && row.dmultiple <= kMaximumMultiple && width_ > 0 && height_ > 0 &&
             shows(dx_, multiple_, raster_width_pixels) && shows(dy_, multiple_, raster_height_pixels) &&
             shows(last_x, multiple_, raster_width_pixels) && shows(last_y, multiple_, raster_height_pixels);
}

SegmentPlaces::RasterRow SegmentPlaces::raster_row(int y) const {
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
