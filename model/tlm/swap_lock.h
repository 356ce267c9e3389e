#pragma once

#include <cstdint>
#include <functional>
#include <systemc>
#include <utility>
#include <vector>

#include "formats/dvi_timing.h"
#include "report/machine_report.h"
#include "scenario/scenario.h"
#include "tlm/cycle.h"
#include "tlm/schedule_observer.h"

namespace metabuffer::tlm {

/// The swap lock between the output framebuffers (section 5.4 of the paper): SWAPLOCK is high while every column has
/// composited its frame, and all displays swap at the start of the next DVI frame that sees it. The swap crosses back
/// to the core clock and FRAMEDONE falls; it does not rise again before the answer has been withdrawn. Clocks are as in
/// docs/design.md.
class SwapLock final : public sc_core::sc_module {
  public:
    /// first_edge: the first DVI output clock without reset. pipeready_cycle: the core clock in which the output
    /// framebuffers raise PIPEREADY for the first time.
    SwapLock(const sc_core::sc_module_name& name, const Scenario& scenario, std::int64_t first_edge,
             std::int64_t pipeready_cycle);

    /// Called when all displays swap together to a frame, which has been shown in full at shown_picoseconds. At
    /// pipeready_cycle a bank is free and PIPEREADY rises.
    using Swapped =
        std::function<void(int frame, std::int64_t pipeready_cycle, std::int64_t shown_picoseconds)>;
    /// One for each display, before the simulation starts.
    void on_swap(Swapped callback) { on_swap_.push_back(std::move(callback)); }
    void on_shown_by(ScheduleObserver* observer) { observer_ = observer; }

    /// A column has composited a frame at that core clock.
    void frame_done(int frame, std::int64_t cycle);

    /// Swaps before a time; all displays swap together.
    std::int64_t swaps_before(std::int64_t picoseconds) const;
    /// The swap to a frame, if its time is known.
    Swap swap_to(int frame) const { return {swap_picoseconds_[static_cast<std::size_t>(frame)], false}; }
    /// Swaps whose time is known.
    int swaps() const { return static_cast<int>(swap_picoseconds_.size()); }
    /// The core clock in which the output framebuffers see the last of these swaps, or come out of reset.
    std::int64_t pipeready_cycle() const { return pipeready_cycle_; }
    /// When the run ends, once that is known; otherwise kUnknownCycle.
    std::int64_t end_picoseconds() const { return end_picoseconds_; }

  private:
    void swap(int frame);

    const Scenario& scenario_;
    ClockDomain core_;
    ClockDomain dvi_;
    DviTiming timing_;
    std::int64_t first_frame_edge_;  ///< DVI output clock of the first DVI frame's first line
    std::vector<Swapped> on_swap_;
    ScheduleObserver* observer_ = nullptr;
    int columns_done_ = 0;
    std::int64_t last_done_cycle_ = 0;
    std::int64_t earliest_framedone_ = 0;  ///< the answer to the swap before has been withdrawn
    std::int64_t pipeready_cycle_;
    std::int64_t end_picoseconds_;
    std::vector<std::int64_t> swap_picoseconds_;  ///< by frame
};

}  // namespace metabuffer::tlm
