#pragma once

#include <cstdint>
#include <functional>

#include "report/report.h"
#include "scenario/scenario.h"
#include "simulation/frame_shown.h"
#include "simulation/trace_window.h"
#include "tlm/schedule_observer.h"

namespace metabuffer::tlm {

struct RunOptions {
    /// False: the same clocks and counters, but no pixel is touched and on_frame_shown is not called.
    bool images = true;
    /// Called with each composited frame (from 0) of each display (from 1), once it has been shown in full.
    FrameShown on_frame_shown;
    /// Called now and then during the run: core clocks done, share of the run's raster pixels composited.
    std::function<void(std::int64_t core_cycles, double share)> on_progress;
    /// Not owned; null: nobody listens.
    ScheduleObserver* observer = nullptr;
};

struct RunResult {
    RunReport report;
    /// Wall time in the kernel, without start-up and without on_frame_shown.
    double simulation_seconds = 0.0;
};

/// Searches with this level's machine, without images, up to a frame after the event (scout() in
/// simulation/trace_window.h). The clocks are those of level rtl, if the scenario has no faults that only level rtl has.
WindowSearch find_event(const Scenario& scenario, const TraceWindow& window);

/// Builds the machine and runs the scenario to its end, at level tlm: every counter and picture as at level rtl.
/// SystemC elaborates once in a process, so this can be called once. Does not catch the blocks' sc_report errors.
RunResult run(const Scenario& scenario, const RunOptions& options);

}  // namespace metabuffer::tlm
