#pragma once

#include <cstdint>
#include <vector>

#include "coverage.h"

namespace metabuffer::coverage {

/// What stands on the display side's wires at a core clock edge, before the edge.
struct DisplayWires {
    std::vector<bool> framedone;
    bool swaplock = false;
    bool swapskip = false;
    bool vsync = false;  ///< of the first display's link; all run in step
    bool de = false;
};

/// Follows the output framebuffers: how columns wait for each other and displays take over frames.
class DisplayCoverage {
  public:
    explicit DisplayCoverage(Coverage& coverage) : coverage_(coverage) {}
    void clock_edge(const DisplayWires& wires);

  private:
    void cover_swaplock(const DisplayWires& wires);
    void cover_swap(bool skipped);

    Coverage& coverage_;
    std::int64_t edge_ = 0;
    std::vector<std::int64_t> done_edges_;
    bool swaplock_ = false;
    bool swapskip_ = false;
    bool vsync_ = false;
    bool swapped_before_ = false;
    bool kept_before_ = false;
    int dvi_frames_ = 0;  ///< since the last swap
};

}  // namespace metabuffer::coverage
