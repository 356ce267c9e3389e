#include "datapath/segment.h"

#include <algorithm>

namespace metabuffer {

Segment::Segment(const ViewportRow& row, int raster_width_pixels, int raster_height_pixels,
                 Smoothing smoothing)
    : row_(row),
      raster_width_(raster_width_pixels),
      raster_height_(raster_height_pixels),
      left_(std::max<int>(0, row.dx)),
      right_(std::min(raster_width_pixels, row.dx + row.sdx * row.dmultiple)),
      top_(std::max<int>(0, row.dy)),
      bottom_(std::min(raster_height_pixels, row.dy + row.sdy * row.dmultiple)),
      reach_(smoothing_reach(smoothing, row.dmultiple)) {
    if (smooths() && need_ends(row.dy, 0, row.sdy) <= top_) {
        skipped_rows_ = 1;
    }
}

std::int64_t Segment::first_use(std::int64_t k) const {
    // A table field has 16 bits, so k fits 32; 64-bit division would cost several times as much.
    const auto index = static_cast<std::uint32_t>(k);
    const auto i = static_cast<int>(index % row_.sdx);
    const auto j = static_cast<int>(index / row_.sdx);
    if (smooths()) return smoothed_first_use(i, j);
    const int x = std::max(left_, row_.dx + i * row_.dmultiple);
    const int y = std::max(top_, row_.dy + j * row_.dmultiple);
    return std::int64_t{y} * raster_width_ + x;
}

std::int64_t Segment::last_use(std::int64_t k) const {
    const auto index = static_cast<std::uint32_t>(k);
    const auto i = static_cast<int>(index % row_.sdx);
    const auto j = static_cast<int>(index / row_.sdx);
    if (smooths()) return smoothed_last_use(i, j);
    const int x = std::min(right_, row_.dx + (i + 1) * row_.dmultiple) - 1;
    const int y = std::min(bottom_, row_.dy + (j + 1) * row_.dmultiple) - 1;
    return std::int64_t{y} * raster_width_ + x;
}

std::int64_t Segment::released_before(std::int64_t position) const {
    if (smooths()) return smoothed_released_before(position);
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

// ---- smoothing ----

std::int64_t Segment::smoothed_first_use(int i, int j) const {
    const auto row_begins = [this](int of) { return std::max(top_, need_begins(row_.dy, of)); };
    const bool has_next = j + 1 < row_.sdy && row_begins(j + 1) < bottom_;
    if (row_begins(j) >= bottom_) return never();
    // At the top of the raster two source rows may be needed at once, and the later one comes last.
    if (has_next && row_begins(j + 1) == top_) return position(left_, top_);
    const int x = std::max(left_, need_begins(row_.dx, i));
    if (x < right_) return position(x, row_begins(j));
    return has_next ? position(left_, row_begins(j + 1)) : never();
}

std::int64_t Segment::smoothed_last_use(int i, int j) const {
    if (j < skipped_rows_) return -1;
    const int row_ends = need_ends(row_.dy, j, row_.sdy);
    // At the bottom two source rows may be in use to the end; the earlier one is released pixel by pixel.
    const bool with_row_before = j > skipped_rows_ && need_ends(row_.dy, j - 1, row_.sdy) >= bottom_;
    const int x = with_row_before ? right_ : std::clamp(need_ends(row_.dx, i, row_.sdx), left_ + 1, right_);
    return position(x - 1, std::min(bottom_, row_ends) - 1);
}

std::int64_t Segment::smoothed_released_before(std::int64_t position) const {
    const auto index = static_cast<std::uint32_t>(position);
    const auto width = static_cast<std::uint32_t>(raster_width_);
    const auto x = static_cast<int>(index % width);
    const auto y = static_cast<int>(index / width);
    if (y >= bottom_ || (y == bottom_ - 1 && x >= right_)) return pixels();
    if (y < top_) return skipped_pixels();

    const auto lines_before = [this](int distance, int count) {
        return distance < reach_ ? 0 : std::min(count - 1, (distance - reach_) / row_.dmultiple);
    };
    const int j = std::max(skipped_rows_, lines_before(y - row_.dy, row_.sdy));
    const std::int64_t released = std::int64_t{j} * row_.sdx;
    const int releasing = std::min(bottom_, need_ends(row_.dy, j, row_.sdy)) - 1;
    if (y < releasing || x <= left_) return released;
    if (x >= right_) return released + row_.sdx;
    return released + lines_before(x - row_.dx, row_.sdx);
}

bool Segment::has_unused_pixels() const {
    return smooths() &&
           (skipped_rows_ > 0 || need_ends(row_.dx, 0, row_.sdx) <= left_ ||
            need_begins(row_.dx, row_.sdx - 1) >= right_ || need_begins(row_.dy, row_.sdy - 1) >= bottom_);
}

BlendWindow<std::int64_t> Segment::window_at(int x, int y) const {
    const int m = row_.dmultiple;
    const auto neighbour = [m, this](int distance, int line, int count) {
        if (!smooths()) return line;
        const int halves = 2 * (distance - line * m) + 1;
        const int other = halves < m ? line - 1 : (halves > m ? line + 1 : line);
        return other < 0 || other >= count ? line : other;
    };
    const int i = (x - row_.dx) / m;
    const int j = (y - row_.dy) / m;
    const int other_i = neighbour(x - row_.dx, i, row_.sdx);
    const int other_j = neighbour(y - row_.dy, j, row_.sdy);
    const auto pixel = [this](int column, int line) { return std::int64_t{line} * row_.sdx + column; };
    BlendWindow<std::int64_t> window{pixel(i, j), kNoPixel, kNoPixel, kNoPixel};
    if (other_i != i) window.beside = pixel(other_i, j);
    if (other_j != j) window.across = pixel(i, other_j);
    if (other_i != i && other_j != j) window.diagonal = pixel(other_i, other_j);
    return window;
}

std::int64_t Segment::newest_at(int x, int y) const {
    if (!smooths()) return pixel_at(x, y);
    const BlendWindow<std::int64_t> window = window_at(x, y);
    return std::max({window.own, window.beside, window.across, window.diagonal});
}

}  // namespace metabuffer
