#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "report/report.h"
#include "scenario/names.h"
#include "scenario/scenario.h"
#include "simulation/trace_window.h"
#include "tools/program/exit_status.h"

namespace metabuffer {

/// The levels that a scenario runs at.
enum class RunLevel : std::uint8_t { kTlm, kRtl, kFunctional };

template <>
struct EnumNames<RunLevel> {
    static constexpr const char* kWhat = "a level";
    static constexpr auto kTable = name_table<RunLevel>(
        {{RunLevel::kTlm, "tlm"}, {RunLevel::kRtl, "rtl"}, {RunLevel::kFunctional, "functional"}});
};

/// What a run is asked for beside its scenario.
struct LevelRequest {
    struct Trace {
        std::string file;  ///< the name says which kind
        TraceWindow window;
        bool names_window = false;        ///< or it is the usual one
        std::vector<std::string> blocks;  ///< of a waveform; all if empty
    };

    RunLevel level = RunLevel::kTlm;
    bool images = true;
    bool check = false;
    std::optional<Trace> trace;
};

/// Whoever follows a run. Either may be empty.
struct RunFollower {
    /// Each frame (from 0) on each display (from 1) once it has been shown, if images are asked for.
    std::function<void(int frame, int display, const ColourImage& picture)> on_picture;
    /// Now and then: core clocks done, and the share of the run's raster pixels composited.
    std::function<void(std::int64_t core_cycles, double share)> on_progress;
};

/// What a run leaves, at any level.
struct LevelOutcome {
    RunReport report;
    double simulation_seconds = 0.0;  ///< 0: the level has no time
    std::string trace_line;           ///< what the trace shows, empty if there is none
    std::string trace_note;  ///< why there is none although one was asked for, or what is wrong with it
    std::string compared;    ///< what a check has compared, empty without one
    std::string check_trace_options;  ///< what shows a check's first violation, empty if there is none
};

/// Throws InputError for a check, or for no images, at a level that does not have it.
void check_request(const LevelRequest& request);

/// Whether the run needs the pixels of images. Level tlm needs only their sizes if there are no pictures.
bool needs_pixels(const LevelRequest& request);

/// Runs a scenario at a level, the whole of `metabuffer run` but its files. SystemC elaborates once in a process, so this
/// can be called once. An exception leaves in `outcome` what a check has found until then. Throws InputError, and lets the
/// blocks' errors through.
void run_level(const Scenario& scenario, const LevelRequest& request, const RunFollower& follower,
               LevelOutcome& outcome);

/// What a caller is to be told of a run: a status, and lines that say why it is not kExitDone.
struct Judgement {
    ExitStatus status = kExitDone;
    std::string text;
};
/// file: the scenario's, begins the lines. strict: whether something starved, stalled or was rejected counts.
Judgement judge(const LevelOutcome& outcome, const std::string& file, bool strict);

/// What a check has found, in lines; empty if that is nothing.
std::string violations_text(const LevelOutcome& outcome, const std::string& file);

}  // namespace metabuffer
