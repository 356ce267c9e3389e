#include "tlm/swap_lock.h"

#include <algorithm>

#include "tlm/column_time.h"

namespace metabuffer::tlm {

SwapLock::SwapLock(const sc_core::sc_module_name& name, const Scenario& scenario, std::int64_t first_edge,
                   std::int64_t pipeready_cycle)
    : sc_core::sc_module(name),
      scenario_(scenario),
      core_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      dvi_(clock_period_picoseconds(scenario.clocks.dvi_out_mhz)),
      timing_(scenario.displays.timing()),
      // The first frame is preceded by its vertical sync.
      first_frame_edge_(first_edge + std::int64_t{DviTiming::kVerticalSyncLines} * timing_.line_clocks()),
      pipeready_cycle_(pipeready_cycle),
      end_picoseconds_(kUnknownCycle) {}

void SwapLock::frame_done(int frame, std::int64_t cycle) {
    last_done_cycle_ = std::max(last_done_cycle_, cycle);
    if (++columns_done_ == scenario_.displays.count()) {
        columns_done_ = 0;
        swap(frame);
    }
}

/// Everything that follows from SWAPLOCK's rise, crossing by crossing.
void SwapLock::swap(int frame) {
    const std::int64_t rise = std::max(last_done_cycle_, earliest_framedone_);
    const std::int64_t seen = dvi_.edge_seeing(core_.picoseconds_of(rise));
    const std::int64_t since_first = std::max<std::int64_t>(0, seen - first_frame_edge_);
    const std::int64_t frame_clocks = timing_.frame_clocks();
    const std::int64_t swap_edge =
        first_frame_edge_ + (since_first + frame_clocks - 1) / frame_clocks * frame_clocks;
    pipeready_cycle_ = core_.edge_seeing(dvi_.picoseconds_of(swap_edge));
    const std::int64_t answer_falls = dvi_.edge_seeing(core_.picoseconds_of(pipeready_cycle_));
    earliest_framedone_ = core_.edge_seeing(dvi_.picoseconds_of(answer_falls));

    // A display has captured the frame at the clock that reads the vertical sync after it, at its end of the link.
    constexpr int kLinesAround = DviTiming::kVerticalBackLines + DviTiming::kVerticalFrontLines;
    const std::int64_t shown_edge =
        swap_edge + std::int64_t{timing_.active_lines + kLinesAround} * timing_.line_clocks() + 1 +
        scenario_.links.latency_clocks();
    swap_picoseconds_.push_back(dvi_.picoseconds_of(swap_edge));
    const std::int64_t shown = dvi_.picoseconds_of(shown_edge);
    if (frame == scenario_.frames - 1) {
        end_picoseconds_ = shown;
    }
    if (observer_ != nullptr) {
        const CycleSpan span{core_.edge_at(dvi_.picoseconds_of(swap_edge)), core_.edge_at(shown)};
        for (int display = 1; display <= scenario_.displays.count(); ++display) {
            observer_->shown(display, frame, span);
        }
    }
    for (const Swapped& swapped : on_swap_) swapped(frame, pipeready_cycle_, shown);
}

std::int64_t SwapLock::swaps_before(std::int64_t picoseconds) const {
    return std::count_if(swap_picoseconds_.begin(), swap_picoseconds_.end(),
                         [picoseconds](std::int64_t swap) { return swap < picoseconds; });
}

}  // namespace metabuffer::tlm
