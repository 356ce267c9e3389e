#include "display_coverage.h"

#include <algorithm>

namespace metabuffer::coverage {

void DisplayCoverage::clock_edge(const DisplayWires& wires) {
    ++edge_;
    done_edges_.resize(wires.framedone.size(), -1);
    for (std::size_t d = 0; d < wires.framedone.size(); ++d) {
        if (!wires.framedone[d]) {
            done_edges_[d] = -1;
        } else if (done_edges_[d] < 0) {
            done_edges_[d] = edge_;
        }
    }
    if (wires.vsync && !vsync_) ++dvi_frames_;
    vsync_ = wires.vsync;
    if (wires.swaplock && !swaplock_) cover_swaplock(wires);
    // FRAMEDONE falls as the swap is seen; SWAPSKIP, with it, a clock later at the earliest.
    if (!wires.swaplock && swaplock_) cover_swap(swapskip_);
    swaplock_ = wires.swaplock;
    swapskip_ = wires.swapskip;
}

void DisplayCoverage::cover_swaplock(const DisplayWires& wires) {
    const char* group = "display/swap";
    if (done_edges_.size() == 1) {
        coverage_.hit(group, "single display");
    } else {
        const auto [first, last] = std::minmax_element(done_edges_.begin(), done_edges_.end());
        coverage_.hit(group,
                      *first == *last ? "all columns done at one clock" : "waits for the slowest column");
        coverage_.hit_if(*first != *last && done_edges_.front() == *last, group, "first column last");
        coverage_.hit_if(*first != *last && done_edges_.back() == *last, group, "last column last");
    }
    coverage_.hit_if(wires.de, group, "SWAPLOCK comes during a displayed frame");
}

void DisplayCoverage::cover_swap(bool skipped) {
    const char* group = "display/swap";
    if (!swapped_before_) {
        coverage_.hit_if(dvi_frames_ > 0, group, "black before the first");
        coverage_.hit_if(dvi_frames_ > 1, group, "several DVI frames before the first");
    } else {
        coverage_.hit_if(dvi_frames_ == 1, group, "a DVI frame for each frame");
        coverage_.hit_if(dvi_frames_ == 2, group, "frame displayed twice");
        coverage_.hit_if(dvi_frames_ > 2, group, "frame displayed three times or more");
    }
    coverage_.hit_if(skipped, group, "kept as pixels were lost");
    coverage_.hit_if(!skipped && kept_before_, group, "swapped after one that was kept");
    swapped_before_ = true;
    kept_before_ = skipped;
    dvi_frames_ = 0;
}

}  // namespace metabuffer::coverage
