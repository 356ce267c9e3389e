#include "tools/program/size_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <utility>

#include "host/text.h"
#include "report/report.h"
#include "scenario/rate_limits.h"
#include "scenario/scenario_template.h"
#include "tools/program/number_option.h"

namespace metabuffer {
namespace {

using exploration::Axis;
using exploration::SearchDescription;

/// Further values looked at on both sides of the one that was found.
constexpr int kDefaultChecks = 16;

constexpr const char* kSizeFooter =
    "The value is doubled until the goal is met, then the gap below is halved; --checks further values on "
    "both sides\n"
    "tell whether the goal is monotonic, and the answer says so where it is not. The goal is an SQL "
    "expression over\n"
    "figures of a run (metabuffer export --help lists them) and the keys at hand.\n"
    "Examples:\n"
    "  metabuffer size scenarios/case-4.yaml --minimize composer.buffer_pixels --over bus.width_bits=64,128\n"
    "  metabuffer size scenarios/paper-figure.yaml --minimize bus.burst_pixels=1..256 \\\n"
    "      --over bus.arbitration=irsa,round-robin,edf --over memory.page_miss_cycles=0..12+3\n"
    "Exit status: 0 every search has ended; 2 bad input, or no point makes a scenario; 130 stopped by "
    "Ctrl-C.";

/// "KEY=REST" in two; REST is empty without a '='.
std::pair<std::string, std::string> split_assignment(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) return {text, ""};
    return {text.substr(0, equals), text.substr(equals + 1)};
}

std::int64_t whole_number(const std::string& text, const std::string& where) {
    const exploration::Value value = exploration::value_of(text);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole;
    throw InputError(where + ": " + text::quoted(text) +
                     " is not a whole number; use FROM..TO, like 16..4096");
}

SearchDescription search_of(const std::string& minimize) {
    const std::string where = "--minimize " + minimize;
    const auto [key, range] = split_assignment(minimize);
    const std::size_t dots = range.find("..");
    if (dots != std::string::npos) {
        return exploration::describe_search(key, whole_number(range.substr(0, dots), where),
                                            whole_number(range.substr(dots + 2), where), where);
    }
    SearchDescription search = exploration::describe_search(key, std::nullopt, std::nullopt, where);
    if (range.empty()) return search;
    std::vector<std::int64_t>& candidates = search.candidates;
    candidates.clear();
    for (const std::string& value : exploration::parse_values(range, where)) {
        candidates.push_back(whole_number(value, where));
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    return search;
}

}  // namespace

SizeCommand::SizeCommand(CLI::App& program)
    : Command(program, "size", "Find the smallest value of a key at which nothing starves"),
      scenario_(command()),
      checks_(kDefaultChecks) {
    command()
        .add_option("--minimize", minimize_,
                    "KEY, KEY=FROM..TO or KEY=A,B,C: a key that takes whole numbers, and where to look")
        ->required();
    command()
        .add_option(
            "--over", over_,
            "KEY=VALUES: do so for each of these values, as 32,64,128 or 64..512*2 or 0..12+3; may be given "
            "several times")
        ->take_all()
        ->allow_extra_args(false);
    command().add_option("--goal", goal_,
                         "When a value is good (default: " + exploration::default_goal() + ")");
    command()
        .add_option(
            "--frame-rate-hz", frame_rate_hz_,
            "And the machine composites and shows that many frames a second, none of them later; asks for "
            "3 frames or more, see --frames")
        ->check(number_within(kFrameRatesHz));
    command()
        .add_option("--checks", checks_, "Further values looked at to see whether the goal is monotonic")
        ->check(CLI::Range(0, 1'000'000))
        ->capture_default_str();
    command().add_option("-o,--out", results_file_, "Keep the results in this SQLite file, as sweep does");
    add_options(command(), processes_);
    command().add_flag("--quiet", quiet_, "Print the table alone");
    command().footer(kSizeFooter);
}

exploration::SweepDescription SizeCommand::description() const {
    exploration::SweepDescription description;
    description.scenario = scenario_.file();
    description.name = std::filesystem::path(scenario_.file()).stem().string();
    description.fixed = scenario_.overrides();
    for (const std::string& over : over_) {
        const auto [key, values] = split_assignment(over);
        const std::string where = "--over " + over;
        if (values.empty())
            throw InputError(where + ": has no values; use KEY=VALUES, like bus.width_bits=32,64");
        description.axes.push_back(Axis{{key}, {exploration::parse_values(values, where)}, {where}});
    }
    description.search = search_of(minimize_);
    description.search->checks = checks_;
    if (!goal_.empty()) {
        description.search->goal = goal_;
        description.search->where = "--goal " + goal_;
    }
    if (frame_rate_hz_) {
        // A rate that the clocks' rounding alone keeps from the one asked for is that rate.
        description.search->goal = "(" + description.search->goal +
                                   ") and frames_per_second >= " + text::number(1.0 - kRateTolerance) +
                                   " * " + text::number(*frame_rate_hz_);
    }
    return description;
}

/// A rate is between frames, and the first swap tells nothing: with fewer no machine meets the goal.
void SizeCommand::check_frames(const exploration::SweepPlan& plan) const {
    if (!frame_rate_hz_) return;
    const ScenarioTemplate scenario(scenario_.file());
    for (const exploration::Point& point : plan.points) {
        int frames = kFramesForRates;
        try {
            frames = std::stoi(scenario.settings(plan.overrides_of(point.settings)).at("frames"));
        } catch (const InputError&) {
            continue;  // running the point tells what is wrong with it
        }
        if (frames < kFramesForRates) {
            throw InputError("--frame-rate-hz: a run of " + text::counted(frames, "frame") +
                             " tells no rate; use --frames " + std::to_string(kFramesForRates) + " or more");
        }
        if (exploration::find_setting(point.settings, "frames") == nullptr) return;  // the same for all
    }
}

ExitStatus SizeCommand::execute() {
    const exploration::SweepPlan plan = make_plan(description());
    check_frames(plan);
    const exploration::Exploration exploration = run_exploration(
        plan, results_file_.empty() ? std::nullopt : std::optional<std::filesystem::path>(results_file_),
        processes_, quiet_);
    if (!quiet_) std::cout << "goal: " << plan.search->goal << '\n';
    print_smallest(plan, exploration);
    if (!quiet_) {
        print_pace(exploration);
        if (!results_file_.empty()) std::cout << "results in " << results_file_ << '\n';
    }
    return judge(exploration);
}

}  // namespace metabuffer
