#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "report/report.h"
#include "scenario/names.h"
#include "scenario/scenario.h"
#include "simulation/frame_shown.h"
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

/// The options of a run, besides its scenario.
struct LevelRequest {
    struct Trace {
        std::string file;  ///< its extension decides the kind of trace
        TraceWindow window;
        bool names_window = false;        ///< false: the window is the default one
        std::vector<std::string> blocks;  ///< of a waveform; all if empty
    };

    RunLevel level = RunLevel::kTlm;
    bool images = true;
    bool check = false;
    std::optional<Trace> trace;
};

/// Called while a run goes on. Each may be empty.
struct RunFollower {
    /// For each frame (from 0) on each display (from 1) once it has been shown, if the request has images.
    std::function<void(int frame, int display, const ColourImage& picture)> on_picture;
    /// Now and then, with the core clocks done and the share of the run's raster pixels composited.
    std::function<void(std::int64_t core_cycles, double share)> on_progress;
    /// As on_picture, with the pairs, and with the picture's wrong pixels (functional/wrong_pixels.h) at a level that has time.
    std::function<void(const DisplayedFrame& displayed, const std::vector<std::size_t>& wrong_pixels)>
        on_shown{};
};

/// The outcome of a run, at any level.
struct LevelOutcome {
    RunReport report;
    double simulation_seconds = 0.0;  ///< 0: the level has no time
    std::string trace_line;           ///< what the trace shows; empty if there is no trace
    std::string trace_note;           ///< why a requested trace was not written, or what is wrong with it
    std::string compared;             ///< what a check has compared; empty without a check
    std::string check_trace_options;  ///< show the first violation in a waveform; empty if there is none
};

/// Whether level tlm, which is faster, knows the clock of every event of level rtl. It does not if the machine has a
/// replaced block, or a fault that only level rtl has.
bool level_tlm_knows_clocks(const Scenario& scenario);

/// Throws InputError if the level cannot do what is requested: level functional has no check and always makes images,
/// and the check of level tlm needs images.
void check_request(const LevelRequest& request);

/// Whether the run needs the pixels of images. Level tlm needs only their sizes if there are no pictures.
bool needs_pixels(const LevelRequest& request);

/// Runs a scenario at a level: all of `metabuffer run` except its pictures and report files. SystemC elaborates only
/// once in a process, so call this only once. If it throws, `outcome` has what a check has found until then. Throws
/// InputError; errors of the blocks pass through.
void run_level(const Scenario& scenario, const LevelRequest& request, const RunFollower& follower,
               LevelOutcome& outcome);

/// The exit status of a run, and lines that say why it is not kExitDone.
struct Judgement {
    ExitStatus status = kExitDone;
    std::string text;
};
/// `file`: the scenario's file; its name begins the lines. `strict`: whether the result is kExitStrict if something
/// starved, stalled or was rejected.
Judgement judge(const LevelOutcome& outcome, const std::string& file, bool strict);

/// The violations that a check has found, in lines; empty if there are none.
std::string violations_text(const LevelOutcome& outcome, const std::string& file);

}  // namespace metabuffer
