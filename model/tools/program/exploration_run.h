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
    int processes = 0;                ///< at once; 0: one for each processor
    double time_limit_seconds = 0.0;  ///< for one of them; 0: none
    TimedLevel level = TimedLevel::kTlm;
};
/// --processes, --time-limit and --level, for a command that keeps `options`.
void add_options(CLI::App& command, ProcessOptions& options);

/// Throws InputError if the folder of the file that the option names cannot be made.
void make_folder_of(const std::filesystem::path& file, const std::string& option);

/// Runs a plan with a progress line, Ctrl-C ending it in order; what sweep and size have in common.
/// `results`: where to keep it; none: nowhere. keeps_points, known: as ExploreOptions has them. Throws InputError and OutputError.
exploration::Exploration run_exploration(const exploration::SweepPlan& plan,
                                         const std::optional<std::filesystem::path>& results,
                                         const ProcessOptions& processes, bool quiet, bool keeps_points,
                                         std::function<exploration::KnownAnswer(const Scenario&)> known = {});

/// Runs one shard of a sweep; its results go to a folder that computers share, as PartsFolder has it: what is new, once
/// in each interval.
exploration::Exploration run_shard(const exploration::SweepPlan& plan, const std::filesystem::path& folder,
                                   std::chrono::seconds interval, const ProcessOptions& processes,
                                   bool quiet);

/// What the results of a plan are made from: this build, its level and the plan's input.
exploration::ResultsIdentity identity_of(const exploration::SweepPlan& plan, const ProcessOptions& processes);

/// How many points took how long.
void print_pace(const exploration::Exploration& exploration);
/// Of a search: each point's settings, its smallest value and what is to be said about it.
void print_smallest(const exploration::SweepPlan& plan, const exploration::Exploration& exploration);
/// A figure of a point's run as text, rounded to a number of digits; empty if there is none.
std::string figure_text(const exploration::PointRecord& point, const std::string& figure, int digits = 2);
/// How the points ended, with the reasons of the first that failed.
void print_outcomes(const exploration::Exploration& exploration);
/// What the caller is told: if it was stopped, or if no point makes a scenario, with a line that says so.
Failure verdict(const exploration::Exploration& exploration);
/// The same status, with the line on stderr if it was stopped or if no point makes a scenario.
ExitStatus judge(const exploration::Exploration& exploration);

}  // namespace metabuffer
