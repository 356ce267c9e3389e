#pragma once

#include <cstdint>
#include <vector>

#include "cover_group.h"

namespace metabuffer::coverage {

struct SwapGoals : CoverGroup {
    explicit SwapGoals(Coverage& coverage)
        : CoverGroup(coverage, {"display/swap", "how displays take over a frame"}) {}
    Bin single_display = bin("single display");
    Bin waits_for_slowest = bin("waits for the slowest column");
    Bin all_at_one_clock = bin("all columns done at one clock");
    Bin first_column_last = bin("first column last");
    Bin last_column_last = bin("last column last");
    Bin during_displayed_frame = bin("SWAPLOCK comes during a displayed frame");
    Bin dvi_frame_for_each = bin("a DVI frame for each frame");
    Bin displayed_twice = bin("frame displayed twice");
    Bin displayed_oftener = bin("frame displayed three times or more");
    Bin black_before_first = bin("black before the first");
    Bin several_before_first = bin("several DVI frames before the first");
    Bin kept = bin("kept as pixels were lost");
    Bin swapped_after_kept = bin("swapped after one that was kept");
};

/// The values of the display side's wires at a core clock edge, before the edge.
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
    /// The goals must outlive it.
    explicit DisplayCoverage(const SwapGoals& goals) : goals_(goals) {}
    void clock_edge(const DisplayWires& wires);

  private:
    void cover_swaplock(const DisplayWires& wires);
    void cover_swap(bool skipped);

    const SwapGoals& goals_;
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
