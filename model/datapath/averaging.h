#pragma once

#include <cstdint>
#include <vector>

#include "formats/pixel.h"

namespace metabuffer {

/// The last step of supersampling (section 7 of the paper): averages each block of s x s raster pixels to one display
/// pixel, each channel (sum + s*s/2) >> (2 log2 s). Raster pixels come in raster order, and the last one of a block
/// completes its display pixel; the last one of a frame leaves it ready for the next. State: one row of channel sums.
class Averager {
  public:
    /// supersample is 1, 2 or 4.
    Averager(int display_width_pixels, int supersample);

    /// Adds the next raster pixel. True if it completes a display pixel; `colour` is then that pixel, 0xRRGGBB.
    bool push(Pixel pixel, std::uint32_t& colour);

    /// Calls see(name, value, largest value) for each register; the row of sums is a memory.
    template <typename See>
    void visit_state(const See& see) const {
        see("x", x_, raster_width_ - 1);
        see("y_in_block", y_in_block_, supersample_ - 1);
    }

  private:
    int raster_width_;
    int supersample_;
    int shift_;
    int x_ = 0;
    int y_in_block_ = 0;
    std::vector<std::uint32_t> red_;
    std::vector<std::uint32_t> green_;
    std::vector<std::uint32_t> blue_;
};

}  // namespace metabuffer
