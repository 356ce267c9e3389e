#include "datapath/averaging.h"

#include <cstddef>

namespace metabuffer {
namespace {

constexpr int log2_of(int supersample) { return supersample == 4 ? 2 : supersample == 2 ? 1 : 0; }

}  // namespace

Averager::Averager(int display_width_pixels, int supersample)
    : raster_width_(display_width_pixels * supersample),
      supersample_(supersample),
      shift_(2 * log2_of(supersample)),
      red_(static_cast<std::size_t>(display_width_pixels)),
      green_(red_.size()),
      blue_(red_.size()) {}

bool Averager::push(Pixel pixel, std::uint32_t& colour) {
    const auto block = static_cast<std::size_t>(x_ / supersample_);
    const int x_in_block = x_ % supersample_;
    const bool complete = x_in_block == supersample_ - 1 && y_in_block_ == supersample_ - 1;

    if (x_in_block == 0 && y_in_block_ == 0) {
        // A block starts from the rounding term, so that its sums need no clearing between blocks or frames.
        const auto half = static_cast<std::uint32_t>(supersample_ * supersample_ / 2);
        red_[block] = half;
        green_[block] = half;
        blue_[block] = half;
    }
    red_[block] += pixel.r();
    green_[block] += pixel.g();
    blue_[block] += pixel.b();
    if (complete) {
        colour =
            ((red_[block] >> shift_) << 16) | ((green_[block] >> shift_) << 8) | (blue_[block] >> shift_);
    }

    if (++x_ == raster_width_) {
        x_ = 0;
        y_in_block_ = (y_in_block_ + 1) % supersample_;
    }
    return complete;
}

}  // namespace metabuffer
