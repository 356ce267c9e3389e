#include "datapath/segment.h"

#include <algorithm>

namespace metabuffer {

Segment::Segment(const ViewportRow& row, int raster_width_pixels, int raster_height_pixels)
    : row_(row),
      raster_width_(raster_width_pixels),
      left_(std::max<int>(0, row.dx)),
      right_(std::min(raster_width_pixels, row.dx + row.sdx * row.dmultiple)),
      top_(std::max<int>(0, row.dy)),
      bottom_(std::min(raster_height_pixels, row.dy + row.sdy * row.dmultiple)) {}

std::int64_t Segment::first_use(std::int64_t k) const {
    // A table field has 16 bits, so k fits 32; 64-bit division would cost several times as much.
    const auto index = static_cast<std::uint32_t>(k);
    const auto i = static_cast<int>(index % row_.sdx);
    const auto j = static_cast<int>(index / row_.sdx);
    const int x = std::max(left_, row_.dx + i * row_.dmultiple);
    const int y = std::max(top_, row_.dy + j * row_.dmultiple);
    return std::int64_t{y} * raster_width_ + x;
}

std::int64_t Segment::last_use(std::int64_t k) const {
    const auto index = static_cast<std::uint32_t>(k);
    const auto i = static_cast<int>(index % row_.sdx);
    const auto j = static_cast<int>(index / row_.sdx);
    const int x = std::min(right_, row_.dx + (i + 1) * row_.dmultiple) - 1;
    const int y = std::min(bottom_, row_.dy + (j + 1) * row_.dmultiple) - 1;
    return std::int64_t{y} * raster_width_ + x;
}

std::int64_t Segment::released_before(std::int64_t position) const {
    if (position >= std::int64_t{bottom_} * raster_width_) return pixels();
    if (position < std::int64_t{top_} * raster_width_) return 0;
    // A raster is at most 16384 pixels wide and high: its positions fit 32 bits too.
    const auto index = static_cast<std::uint32_t>(position);
    const auto width = static_cast<std::uint32_t>(raster_width_);
    const auto x = static_cast<int>(index % width);
    const auto y = static_cast<int>(index / width);

    // The source rows before j have had their last repetition. Row j is released only while its own last
    // repetition, possibly cut short by the bottom of the raster, is composited.
    const int j = (y - row_.dy) / row_.dmultiple;
    const int last_repetition = std::min(bottom_, row_.dy + (j + 1) * row_.dmultiple) - 1;
    const std::int64_t released = std::int64_t{j} * row_.sdx;
    if (y < last_repetition || x < left_) return released;
    if (x >= right_) return released + row_.sdx;
    return released + (x - row_.dx) / row_.dmultiple;
}

}  // namespace metabuffer
