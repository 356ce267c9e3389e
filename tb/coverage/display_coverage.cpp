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
    // FRAMEDONE falls when the swap is seen, and SWAPSKIP with it, so the value of the edge before counts.
    if (!wires.swaplock && swaplock_) cover_swap(swapskip_);
    swaplock_ = wires.swaplock;
    swapskip_ = wires.swapskip;
}

void DisplayCoverage::cover_swaplock(const DisplayWires& wires) {
    if (done_edges_.size() == 1) {
        goals_.single_display.hit();
    } else {
        const auto [first, last] = std::minmax_element(done_edges_.begin(), done_edges_.end());
        const bool together = *first == *last;
        (together ? goals_.all_at_one_clock : goals_.waits_for_slowest).hit();
        goals_.first_column_last.hit_if(!together && done_edges_.front() == *last);
        goals_.last_column_last.hit_if(!together && done_edges_.back() == *last);
    }
    goals_.during_displayed_frame.hit_if(wires.de);
}

void DisplayCoverage::cover_swap(bool skipped) {
    if (!swapped_before_) {
        goals_.black_before_first.hit_if(dvi_frames_ > 0);
        goals_.several_before_first.hit_if(dvi_frames_ > 1);
    } else {
        goals_.dvi_frame_for_each.hit_if(dvi_frames_ == 1);
        goals_.displayed_twice.hit_if(dvi_frames_ == 2);
        goals_.displayed_oftener.hit_if(dvi_frames_ > 2);
    }
    goals_.kept.hit_if(skipped);
    goals_.swapped_after_kept.hit_if(!skipped && kept_before_);
    swapped_before_ = true;
    kept_before_ = skipped;
    dvi_frames_ = 0;
}

}  // namespace metabuffer::coverage
