#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "report/report.h"
#include "scenario/scenario.h"
#include "simulation/frame_shown.h"
#include "simulation/trace_window.h"

namespace metabuffer::rtl {

class Metabuffer;

/// A waveform that a run is asked for.
struct TraceRequest {
    std::filesystem::path file;  ///< must end in .vcd or .fst
    TraceWindow window;
    std::vector<std::string> blocks;  ///< shell patterns for block names such as composer_1_*; all if empty
    std::string header{};             ///< lines that say what made it; a comment in the file
    /// What a search has found for a window that depends on the run: this level's find_event() or, sooner, another level's.
    std::optional<WindowEvent> event{};
};

struct RunOptions {
    std::optional<TraceRequest> trace;
    /// Called once the machine has been built and before it starts, for code that binds to its wires. The machine lives
    /// until the run ends. It is not called for a run that only searches for a waveform's window.
    std::function<void(Metabuffer& machine)> on_built;
    /// Called for each composited frame (from 0) on each display (from 1), once it has been shown in full.
    FrameShown on_frame_shown;
    /// Called now and then during the run: core clocks done, share of the run's raster pixels composited.
    std::function<void(std::int64_t core_cycles, double share)> on_progress;
};

struct RunResult {
    RunReport report;
    std::optional<CycleSpan> traced;  ///< what the waveform holds, if one was written
    /// Wall time in the kernel, without start-up and without on_frame_shown.
    double simulation_seconds = 0.0;
    std::string trace_note;     ///< why there is no waveform although one was asked for
    std::string trace_warning;  ///< where the event is, if the search has it elsewhere
};

/// Throws InputError unless the file's name ends in .vcd or .fst.
void check_trace_name(const std::filesystem::path& file);

/// Searches with this level's machine (scout() in simulation/trace_window.h).
WindowSearch find_event(const Scenario& scenario, const TraceWindow& window);

/// Builds the machine and runs the scenario to its end, at level rtl. SystemC elaborates once in a process,
/// so this can be called once. Throws InputError for a trace that cannot be made as asked, and lets the
/// blocks' sc_report errors through.
RunResult run(const Scenario& scenario, const RunOptions& options);

}  // namespace metabuffer::rtl
