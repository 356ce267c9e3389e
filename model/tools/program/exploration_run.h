#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "tools/exploration/explorer.h"
#include "tools/exploration/sweep_plan.h"
#include "tools/program/exit_status.h"
#include "tools/program/failure.h"
#include "tools/program/timed_level.h"

namespace CLI {
class App;
}

namespace metabuffer {

/// How the simulations of an exploration run.
struct ProcessOptions {
    int processes = 0;                ///< at once; 0: the usual number
    double time_limit_seconds = 0.0;  ///< for one simulation; 0: none
    TimedLevel level = TimedLevel::kTlm;
};
/// Adds --processes, --time-limit and --level to a command, which keeps a reference to `options`.
void add_options(CLI::App& command, ProcessOptions& options);

/// Makes the folder of the file that the option names. Throws InputError if it cannot.
void make_folder_of(const std::filesystem::path& file, const std::string& option);

/// Runs a plan with a progress line, for sweep and size. Ctrl-C ends it in good order. `results`: the file that keeps
/// the results; none is kept without it. `keeps_points`, `known`: as in ExploreOptions. Throws InputError and
/// OutputError.
exploration::Exploration run_exploration(const exploration::SweepPlan& plan,
                                         const std::optional<std::filesystem::path>& results,
                                         const ProcessOptions& processes, bool quiet, bool keeps_points,
                                         std::function<exploration::KnownAnswer(const Scenario&)> known = {});

/// Runs one shard of a sweep. Once in each interval it hands new results in to a folder that computers share (see
/// PartsFolder).
exploration::Exploration run_shard(const exploration::SweepPlan& plan, const std::filesystem::path& folder,
                                   std::chrono::seconds interval, const ProcessOptions& processes,
                                   bool quiet);

/// What the results of a plan are made from: this build, the level and the plan's input.
exploration::ResultsIdentity identity_of(const exploration::SweepPlan& plan, const ProcessOptions& processes);

/// Prints how many points have ended, and in what time.
void print_pace(const exploration::Exploration& exploration);
/// For a search, prints each point's settings, its smallest value and a remark about it.
void print_smallest(const exploration::SweepPlan& plan, const exploration::Exploration& exploration);
/// A figure of a point's run as text, with `digits` digits after the decimal point; empty if there is none.
std::string figure_text(const exploration::PointRecord& point, const std::string& figure, int digits = 2);
/// Prints how many points have a bus that is wider than its memory fills, if any.
void print_idle_buses(const exploration::Exploration& exploration);
/// Prints how the points ended, with the reasons of the first that failed.
void print_outcomes(const exploration::Exploration& exploration);
/// The exit status, with a line that says so if it was stopped or if no point makes a scenario.
Failure verdict(const exploration::Exploration& exploration);
/// The status of verdict(); with `strict` another one if points have no result. Writes the line of verdict(), or how many
/// points have none, to stderr.
ExitStatus judge(const exploration::Exploration& exploration, bool strict = false);

}  // namespace metabuffer
