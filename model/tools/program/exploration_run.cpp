#include "tools/program/exploration_run.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "build_info/build_info.h"
#include "host/text.h"
#include "report/text_table.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/parts_folder.h"
#include "tools/program/level_simulation.h"
#include "tools/program/number_option.h"
#include "tools/program/option_ranges.h"
#include "tools/program/progress_line.h"
#include "tools/program/stop_signals.h"

namespace metabuffer {
namespace {

using exploration::Exploration;
using exploration::PointRecord;
using exploration::Progress;
using exploration::Setting;
using exploration::Value;

/// "1 h 02 min", "3 min 20 s", "7 s".
std::string duration(double seconds) {
    const auto whole = std::llround(seconds);
    if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
    if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    return fmt::format("{} s", whole);
}

void show(const ProgressLine& line, const Progress& progress) {
    const auto seconds_to_go = progress.seconds_to_go();
    line.show(fmt::format("{} of {} points, {} runs, {:.1f} points/s, to go: {}", progress.points_ended,
                          progress.points, progress.runs, progress.rate(),
                          seconds_to_go ? duration(*seconds_to_go) : std::string("?")));
}

/// A reason that is short enough to print. A watchdog's reason names every block that waits; the results have all of
/// it.
std::string shortened(const std::string& reason) {
    constexpr std::size_t kMostCharacters = 240;
    return reason.size() <= kMostCharacters ? reason : reason.substr(0, kMostCharacters) + "...";
}

std::string described(const std::vector<Setting>& settings) {
    std::string text;
    for (const Setting& setting : settings) {
        text += (text.empty() ? "" : " ") + setting.key + "=" + setting.value;
    }
    return text;
}

const Value* figure_of(const PointRecord& point, const std::string& figure) {
    const std::size_t index = exploration::figure_index(figure).value();
    return index < point.figures.size() ? &point.figures[index] : nullptr;
}

/// What the point's run waited for most: "displays 75 %".
std::string bottleneck(const PointRecord& point) {
    const Value* const share = figure_of(point, "bottleneck_share");
    const auto* const part = share != nullptr ? std::get_if<double>(share) : nullptr;
    if (part == nullptr) return "";
    constexpr double kPercent = 100.0;
    return figure_text(point, "bottleneck") + fmt::format(" {:.0f} %", kPercent * *part);
}

/// The last column: why there is no smallest value, which values are not monotonic, or which range alone was searched.
std::string remark(const PointRecord& point) {
    if (!point.smallest) return point.reason;
    return point.note.empty() ? point.bounds : point.note;
}

/// How many points have which bottleneck.
void print_bottlenecks(const Exploration& exploration) {
    const std::map<std::string, std::size_t>& counts = exploration.outcomes.bottlenecks();
    std::vector<std::string> parts;
    parts.reserve(counts.size());
    for (const auto& [name, count] : counts)
        parts.push_back(name + " of " + text::counted(static_cast<std::int64_t>(count), "point"));
    if (!parts.empty()) std::cout << "  bottleneck: " << text::listed(parts) << '\n';
}

}  // namespace

void make_folder_of(const std::filesystem::path& file, const std::string& option) {
    if (!file.has_parent_path()) return;
    std::error_code error;
    std::filesystem::create_directories(file.parent_path(), error);
    if (error) {
        throw InputError(option + " " + file.string() + ": its folder cannot be made: " + error.message() +
                         "; name a file in a place that can be written");
    }
}

void add_options(CLI::App& command, ProcessOptions& options) {
    command
        .add_option("--processes", options.processes,
                    "Simulations at once (default: one for each processor and one more)")
        ->check(CLI::Range(kProcesses.low, kProcesses.high));
    command
        .add_option("--time-limit", options.time_limit_seconds,
                    "Seconds after which a simulation is given up, as a crash (default: none)")
        ->check(number_within(kTimeLimitSeconds));
    command
        .add_option_function<std::string>(
            "--level", [&options](const std::string& name) { options.level = *from_name<TimedLevel>(name); },
            "tlm: by transactions; rtl: clock by clock, with the blocks that the program was built with "
            "(default: tlm)")
        ->check(CLI::IsMember(enum_names<TimedLevel>()));
}

namespace {

/// Runs the plan. `results`: the open file that keeps the results, or null.
Exploration run_into(const exploration::Explorer& explorer, exploration::ResultsDatabase* results,
                     const ProcessOptions& processes, bool quiet, const StopSignals& signals,
                     exploration::ExploreOptions options) {
    options.processes = processes.processes > 0 ? processes.processes : exploration::usual_process_count();
    options.time_limit_seconds = processes.time_limit_seconds;
    const ProgressLine line(!quiet);
    const auto on_progress = std::move(options.on_progress);
    options.on_progress = [&](const Progress& progress) {
        show(line, progress);
        if (on_progress) on_progress(progress);
    };
    options.stop_descriptor = signals.descriptor();
    return explorer.run(results, options);
}

exploration::ShardRecord shard_of(const exploration::SweepPlan& plan, std::size_t ended = 0) {
    return {plan.digest, plan.shard, static_cast<std::int64_t>(plan.points.size()),
            static_cast<std::int64_t>(ended)};
}

exploration::ResultsIdentity identity_of(const exploration::Explorer& explorer,
                                         const ProcessOptions& processes) {
    return explorer.identity(build_version(), to_string(processes.level));
}

}  // namespace

Exploration run_exploration(const exploration::SweepPlan& plan,
                            const std::optional<std::filesystem::path>& results,
                            const ProcessOptions& processes, bool quiet, bool keeps_points,
                            std::function<exploration::KnownAnswer(const Scenario&)> known) {
    const exploration::Explorer explorer(plan, simulation_at(processes.level),
                                         always_needs_pixels(processes.level));
    std::optional<exploration::ResultsDatabase> database;
    if (results) {
        make_folder_of(*results, "--out");
        database.emplace(exploration::ResultsDatabase::open(*results, identity_of(explorer, processes)));
        database->put_shard(shard_of(plan));
    }
    exploration::ExploreOptions options;
    options.known = std::move(known);
    options.keeps_points = keeps_points;
    Exploration exploration = run_into(explorer, database ? &*database : nullptr, processes, quiet,
                                       StopSignals(), std::move(options));
    if (database) database->put_shard(shard_of(plan, exploration.progress.points_ended));
    return exploration;
}

Exploration run_shard(const exploration::SweepPlan& plan, const std::filesystem::path& folder,
                      std::chrono::seconds interval, const ProcessOptions& processes, bool quiet) {
    // Lives until the last results have been handed in: a second signal must not interrupt that.
    const StopSignals signals;
    const exploration::Explorer explorer(plan, simulation_at(processes.level),
                                         always_needs_pixels(processes.level));
    make_folder_of(folder / "part", "--parts");
    exploration::PartsFolder parts(folder, identity_of(explorer, processes), shard_of(plan), interval);
    std::int64_t ended = 0;
    bool has_failed = false;
    exploration::ExploreOptions options;
    options.keeps_points = false;
    options.on_progress = [&ended](const Progress& progress) {
        ended = static_cast<std::int64_t>(progress.points_ended);
    };
    options.on_tick = [&] {
        try {
            parts.hand_in_if_due(ended);
        } catch (const std::runtime_error& error) {
            // A shared disk may be unavailable for a while. The next attempt hands in what this one did not.
            if (!has_failed) std::cerr << "cannot hand in yet: " << text::message(error.what()) << std::endl;
            has_failed = true;
        }
    };
    std::optional<Exploration> exploration;
    try {
        exploration = run_into(explorer, &parts.results(), processes, quiet, signals, std::move(options));
    } catch (...) {
        parts.hand_in(ended);
        throw;
    }
    parts.hand_in(ended);
    return std::move(*exploration);
}

exploration::ResultsIdentity identity_of(const exploration::SweepPlan& plan,
                                         const ProcessOptions& processes) {
    return identity_of(exploration::Explorer(plan, simulation_at(processes.level)), processes);
}

void print_pace(const Exploration& exploration) {
    const Progress& progress = exploration.progress;
    std::printf("%zu of %zu points in %.1f s: %.1f points/s, %zu simulations", progress.points_ended,
                progress.points, progress.seconds, progress.rate(), progress.runs);
    if (progress.points_reused > 0) std::printf("; %zu points were there already", progress.points_reused);
    std::printf("\n");
    std::fflush(stdout);
}

std::string figure_text(const PointRecord& point, const std::string& figure, int digits) {
    const Value* const value = figure_of(point, figure);
    if (value == nullptr) return "";
    const auto* const number = std::get_if<double>(value);
    return number != nullptr ? text::decimal(*number, digits) : exploration::text_of(*value);
}

void print_smallest(const exploration::SweepPlan& plan, const Exploration& exploration) {
    const std::size_t keys = plan.keys.size();
    // The settings, the value and its runs are aligned to the right, the bottleneck and the remark to the left.
    TextTable table({keys + 3, keys + 4});
    std::vector<std::string> heading = plan.keys;
    heading.insert(heading.end(), {"smallest " + plan.search->key, "runs", "cost", "bottleneck", ""});
    table.add(heading);
    for (const PointRecord& point : exploration.points) {
        std::vector<std::string> cells;
        for (const Setting& setting : point.settings) cells.push_back(setting.value);
        cells.push_back(point.smallest ? text::number(*point.smallest) : to_string(point.status));
        cells.push_back(std::to_string(point.runs));
        cells.push_back(point.smallest ? figure_text(point, "cost", 0) : "");
        cells.push_back(bottleneck(point));
        cells.push_back(remark(point));
        table.add(std::move(cells));
    }
    std::cout << table.text();
}

void print_idle_buses(const Exploration& exploration) {
    const std::size_t points = exploration.outcomes.with_idle_bus_bits();
    if (points == 0) return;
    std::cout << "  buses of " << text::counted(static_cast<std::int64_t>(points), "point")
              << " are wider than their memory fills, 64 x memory.words_per_cycle bits; narrower ones do the "
                 "same\n";
}

void print_outcomes(const Exploration& exploration) {
    const exploration::Outcomes& outcomes = exploration.outcomes;
    for (const auto& [status, count] : outcomes.counts()) {
        std::cout << "  " << to_string(status) << std::string(10 - std::string(to_string(status)).size(), ' ')
                  << count << '\n';
    }
    if (outcomes.not_monotonic() > 0) {
        std::cout << "  of " << outcomes.not_monotonic()
                  << " points the goal is not monotonic: see column note\n";
    }
    if (outcomes.with_figures() > 0) {
        std::cout << "  whole pictures: " << outcomes.whole() << " of "
                  << text::counted(static_cast<std::int64_t>(outcomes.with_figures()), "run") << '\n';
    }
    print_bottlenecks(exploration);
    print_idle_buses(exploration);
    for (const auto& [number, point] : outcomes.failures()) {
        std::cout << to_string(point.status) << ": " << described(point.settings) << ": "
                  << shortened(point.reason) << '\n';
    }
    if (outcomes.failed() > outcomes.failures().size()) {
        std::cout << "... and " << outcomes.failed() - outcomes.failures().size() << " more in the results\n";
    }
}

Failure verdict(const Exploration& exploration) {
    if (exploration.stopped) {
        return {kExitStopped, "stopped; with the results in a file the same command goes on from here"};
    }
    if (!exploration.outcomes.all_invalid()) return {kExitDone, ""};
    const auto& failures = exploration.outcomes.failures();
    if (failures.empty()) return {kExitDone, ""};  // a shard without points
    return {kExitBadInput, text::message(failures.begin()->second.reason)};
}

ExitStatus judge(const Exploration& exploration, bool strict) {
    const Failure failure = verdict(exploration);
    if (failure.status != kExitDone) {
        std::cerr << failure.message << '\n';
        return failure.status;
    }
    std::size_t points = 0;
    std::size_t without_result = 0;
    std::vector<std::string> kinds;
    for (const auto& [status, count] : exploration.outcomes.counts()) {
        points += count;
        // That no value meets a search's goal is a result.
        if (status == exploration::RunStatus::kDone || status == exploration::RunStatus::kUnmet) continue;
        without_result += count;
        kinds.push_back(std::to_string(count) + " " + to_string(status));
    }
    if (without_result == 0) return kExitDone;
    std::cerr << without_result << " of " << text::counted(static_cast<std::int64_t>(points), "point")
              << " without a result: " << text::listed(kinds) << "; the column reason says why\n";
    return strict ? kExitStrict : kExitDone;
}

}  // namespace metabuffer
