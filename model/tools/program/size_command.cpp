#include "tools/program/size_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <set>
#include <utility>

#include "host/text.h"
#include "report/report.h"
#include "report/text_table.h"
#include "scenario/rate_limits.h"
#include "scenario/scenario_template.h"
#include "tools/analysis/analysis_report.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/exploration/value.h"
#include "tools/program/number_option.h"

namespace metabuffer {
namespace {

using exploration::Axis;
using exploration::SearchDescription;

/// Further values looked at on both sides of the one that was found.
constexpr int kDefaultChecks = 16;
constexpr const char* kBufferKey = "composer.buffer_pixels";

constexpr const char* kSizeFooter =
    "The value is doubled until the goal is met, then the gap below is halved; --checks further values on "
    "both sides\n"
    "tell whether the goal is monotonic, and the answer says so where it is not. Of buffers without a range, "
    "only sizes are\n"
    "looked at that arithmetic leaves open (metabuffer analyze), and what stalling columns would do with is "
    "told too. The\n"
    "goal is an SQL expression over figures of a run (metabuffer export --help lists them) and the keys at "
    "hand.\n"
    "Examples:\n"
    "  metabuffer size scenarios/case-4.yaml --minimize composer.buffer_pixels --over bus.width_bits=64,128\n"
    "  metabuffer size scenarios/case-4.yaml --minimize bus.width_bits --minimize composer.buffer_pixels\n"
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

double number_in(const std::string& text, const std::string& where) {
    const exploration::Value value = exploration::value_of(text);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    if (const auto* number = std::get_if<double>(&value)) return *number;
    throw InputError(where + ": " + text::quoted(text) +
                     " is not a number; use FROM..TO, like 16..4096, or FROM..TO+STEP, like 60..100+0.5");
}

/// --minimize's KEY, KEY=FROM..TO, KEY=FROM..TO+STEP or KEY=A,B,C.
struct Minimized {
    SearchDescription search;
    bool has_range = false;  ///< the user's
};

Minimized minimized(const std::string& minimize) {
    const std::string where = "--minimize " + minimize;
    const auto [key, range] = split_assignment(minimize);
    if (range.empty()) return {exploration::describe_search(key, std::nullopt, std::nullopt, where)};
    const std::size_t dots = range.find("..");
    if (dots != std::string::npos) {
        const std::string rest = range.substr(dots + 2);
        const std::size_t plus = rest.find('+', 1);
        std::optional<double> step;
        if (plus != std::string::npos) step = number_in(rest.substr(plus + 1), where);
        return {exploration::describe_search(key, number_in(range.substr(0, dots), where),
                                             number_in(rest.substr(0, plus), where), where, step),
                true};
    }
    SearchDescription search = exploration::describe_search(key, std::nullopt, std::nullopt, where);
    if (search.step > 0.0) throw InputError(where + ": takes fractions; use FROM..TO+STEP, like 60..100+0.5");
    std::vector<std::int64_t>& candidates = search.candidates;
    candidates.clear();
    for (const std::string& value : exploration::parse_values(range, where)) {
        const double number = number_in(value, where);
        if (number != std::floor(number))
            throw InputError(where + ": " + text::quoted(value) + " is not a whole number");
        candidates.push_back(static_cast<std::int64_t>(number));
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    return {std::move(search), true};
}

/// The values that are tried of the first of two keys: all candidates, or the range in doubling steps, both ends among
/// them. The exact corners of the front are found afterwards.
std::vector<std::string> coarse_values(const SearchDescription& search) {
    std::vector<std::string> values;
    for (const std::int64_t candidate : search.candidates) values.push_back(search.text_of(candidate));
    if (!values.empty()) return values;
    for (std::int64_t value = search.from; value < search.to; value = std::max<std::int64_t>(value, 1) * 2) {
        values.push_back(search.text_of(value));
    }
    values.push_back(search.text_of(search.to));
    return values;
}

/// Whether what a key changes leaves raster, displays and links as they are.
bool leaves_limits(const std::string& key) {
    const auto begins = [&key](const char* map) { return key.rfind(map, 0) == 0; };
    return begins("composer.") || begins("bus.") || begins("memory.");
}

/// The points of a search that no other one with the same settings of --over undercuts: with less of the key that was
/// looked for first, the last setting, and no more of the other.
void print_front(const exploration::SweepPlan& plan, const exploration::Exploration& exploration) {
    using exploration::PointRecord;
    const auto overs_of = [](const PointRecord& point) {
        return std::vector<exploration::Setting>(point.settings.begin(), point.settings.end() - 1);
    };
    const auto second_of = [](const PointRecord& point) { return std::stod(point.settings.back().value); };
    TextTable table({plan.keys.size() + 2});
    std::vector<std::string> heading(plan.keys.begin(), plan.keys.end() - 1);
    heading.insert(heading.end(),
                   {plan.search->key, plan.keys.back(), "frames/s", "buffer bits", "bus wires"});
    table.add(heading);
    std::vector<PointRecord> points = exploration.points;
    std::stable_sort(points.begin(), points.end(), [&overs_of](const PointRecord& a, const PointRecord& b) {
        return std::pair(exploration::canonical_text(overs_of(a)), a.smallest) <
               std::pair(exploration::canonical_text(overs_of(b)), b.smallest);
    });
    for (const PointRecord& point : points) {
        if (!point.smallest) continue;
        const bool undercut =
            std::any_of(exploration.points.begin(), exploration.points.end(), [&](const PointRecord& other) {
                return other.smallest && overs_of(other) == overs_of(point) &&
                       *other.smallest <= *point.smallest && second_of(other) < second_of(point);
            });
        if (undercut) continue;
        std::vector<std::string> cells;
        for (const exploration::Setting& setting : overs_of(point)) cells.push_back(setting.value);
        cells.push_back(text::number(*point.smallest));
        cells.push_back(point.settings.back().value);
        for (const char* figure : {"frames_per_second", "buffer_bits", "bus_wires"}) {
            cells.push_back(figure_text(point, figure));
        }
        table.add(std::move(cells));
    }
    std::cout << "the front: less of one takes more of the other\n" << table.text();
}

}  // namespace

SizeCommand::SizeCommand(CLI::App& program)
    : Command(program, "size", "Find the smallest value of a key at which nothing starves"),
      scenario_(command()),
      checks_(kDefaultChecks) {
    command()
        .add_option(
            "--minimize", minimize_,
            "KEY, KEY=FROM..TO, KEY=FROM..TO+STEP or KEY=A,B,C: a key that takes numbers, and where to look; "
            "given for two keys, the front of both")
        ->required()
        ->take_all()
        ->allow_extra_args(false);
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
    description.search = minimized(minimize_.back()).search;
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

/// What arithmetic knows of a search. A range that the user gives is looked at as it is, as long as there is hope.
exploration::KnownAnswer SizeCommand::known_of(const Scenario& scenario,
                                               const SearchDescription& search) const {
    exploration::KnownAnswer known;
    const bool of_buffers = search.key == kBufferKey;
    if (!leaves_limits(search.key)) return known;
    if (frame_rate_hz_) {
        const analysis::Analysis analysis = analysis::analyze(scenario, {std::nullopt, *frame_rate_hz_});
        const double asked = *frame_rate_hz_ * (1.0 - kRateTolerance);
        const std::string too_slow = analysis::too_slow_for(analysis, asked, of_buffers);
        if (!too_slow.empty()) {
            known.hopeless = "no " + search.key + " brings " + text::number(*frame_rate_hz_) +
                             " frames/s: too slow for it: " + too_slow;
            return known;
        }
    }
    const bool has_range =
        std::any_of(minimize_.begin(), minimize_.end(),
                    [&search](const std::string& text) { return text.rfind(search.key + "=", 0) == 0; });
    if (!of_buffers || has_range || !goal_.empty()) return known;
    const analysis::Analysis analysis = analysis::analyze(scenario);
    known.least = analysis.least_buffer_pixels;
    const std::int64_t whole = analysis.whole_buffer_pixels;
    if (frame_rate_hz_) {
        known.enough = 2 * whole;  // of both frames that a buffer can hold
    } else {
        const bool has_bound = analysis.safe_buffer_is_legal.value_or(false);
        known.enough = has_bound ? std::min(whole, *analysis.safe_buffer_pixels) : whole;
    }
    return known;
}

exploration::Exploration SizeCommand::run(const exploration::SweepPlan& plan,
                                          const std::optional<std::filesystem::path>& results) const {
    return run_exploration(plan, results, processes_, quiet_, [this, &plan](const Scenario& scenario) {
        return known_of(scenario, *plan.search);
    });
}

/// With columns that may stall, a smaller buffer shows the whole picture, too, later. What it takes for the same rate.
void SizeCommand::print_stalling(const exploration::SweepDescription& asked,
                                 const exploration::Exploration& exploration) const {
    constexpr std::size_t kMostPoints = 16;
    if (asked.search->key != kBufferKey || !goal_.empty()) return;
    TextTable table({asked.axes.size() + 4});
    std::vector<std::string> heading;
    for (const Axis& axis : asked.axes) heading.push_back(axis.keys.front());
    heading.insert(heading.end(),
                   {"smallest " + asked.search->key, "runs", "frames/s", "stalled clocks", ""});
    table.add(heading);
    std::size_t lines = 0;
    for (const exploration::PointRecord& point : exploration.points) {
        if (!point.smallest || lines == kMostPoints) continue;
        exploration::SweepDescription stalling = asked;
        stalling.axes.clear();
        for (const exploration::Setting& setting : point.settings)
            stalling.fixed.push_back({setting.key, setting.value});
        stalling.fixed.push_back({"composer.on_starvation", "stall"});
        const std::string rate = figure_text(point, "frames_per_second", 6);
        const std::string cycles = figure_text(point, "frame_cycles", 3);
        stalling.search->goal =
            "starved_pixels = 0 and rejected_rows = 0 and rejected_frames = 0 and rejected_slot_tables = 0 "
            "and " +
            (rate.empty() ? "frame_cycles <= " + text::number(1.0 + kRateTolerance) + " * " + cycles
                          : "frames_per_second >= " + text::number(1.0 - kRateTolerance) + " * " + rate);
        const exploration::SweepPlan plan = make_plan(stalling);
        const exploration::Exploration found = run(plan, std::nullopt);
        if (found.stopped || found.points.empty()) return;
        const exploration::PointRecord& answer = found.points.front();
        std::vector<std::string> cells;
        for (const exploration::Setting& setting : point.settings) cells.push_back(setting.value);
        cells.push_back(answer.smallest ? text::number(*answer.smallest) : to_string(answer.status));
        cells.push_back(std::to_string(answer.runs));
        cells.push_back(figure_text(answer, "frames_per_second"));
        cells.push_back(figure_text(answer, "stalled_cycles"));
        cells.emplace_back(answer.smallest ? answer.note : answer.reason);
        table.add(std::move(cells));
        ++lines;
    }
    if (lines == 0) return;
    std::cout << "with on_starvation: stall, whole pictures " << (frame_rate_hz_ ? "" : "and ")
              << "at the same rate:\n"
              << table.text();
}

ExitStatus SizeCommand::size_one() {
    const exploration::SweepDescription asked = description();
    const exploration::SweepPlan plan = make_plan(asked);
    check_frames(plan);
    const exploration::Exploration exploration =
        run(plan, results_file_.empty() ? std::nullopt : std::optional<std::filesystem::path>(results_file_));
    if (!quiet_) std::cout << "goal: " << plan.search->goal << '\n';
    print_smallest(plan, exploration);
    if (!quiet_) {
        if (!exploration.stopped) print_stalling(asked, exploration);
        print_pace(exploration);
        if (!results_file_.empty()) std::cout << "results in " << results_file_ << '\n';
    }
    return judge(exploration);
}

/// For each coarse value of the first key the smallest of the second; then, for each of these, the smallest of the first.
/// What then costs more of one key and no less of the other is not on the front.
ExitStatus SizeCommand::size_front() {
    if (!results_file_.empty()) {
        throw InputError(
            "-o: the front of two keys takes searches of both, and a file holds one; leave it out");
    }
    const SearchDescription first = minimized(minimize_.front()).search;
    exploration::SweepDescription forth = description();
    if (first.key == forth.search->key) {
        throw InputError("--minimize: " + first.key + " is given twice; use two keys, or one");
    }
    const std::vector<Axis> overs = forth.axes;
    forth.axes.push_back(Axis{{first.key}, {coarse_values(first)}, {first.where}});
    const exploration::SweepPlan plan = make_plan(forth);
    check_frames(plan);
    const exploration::Exploration seconds = run(plan, std::nullopt);
    if (seconds.stopped) return judge(seconds);

    // Each answer once: the settings of --over, and the second key's value.
    std::set<std::vector<std::string>> answers;
    for (const exploration::PointRecord& point : seconds.points) {
        if (!point.smallest) continue;
        std::vector<std::string> answer;
        for (std::size_t n = 0; n + 1 < point.settings.size(); ++n) answer.push_back(point.settings[n].value);
        answer.push_back(text::number(*point.smallest));
        answers.insert(std::move(answer));
    }
    if (!quiet_) std::cout << "goal: " << plan.search->goal << '\n';
    if (answers.empty()) {
        print_smallest(plan, seconds);
        return judge(seconds);
    }
    exploration::SweepDescription back = forth;
    back.axes.clear();
    Axis corners;
    for (const Axis& over : overs) corners.keys.push_back(over.keys.front());
    corners.keys.push_back(forth.search->key);
    corners.values.resize(corners.keys.size());
    corners.where.resize(corners.keys.size());
    for (const std::vector<std::string>& answer : answers) {
        for (std::size_t n = 0; n < answer.size(); ++n) corners.values[n].push_back(answer[n]);
    }
    back.axes.push_back(std::move(corners));
    const std::string goal = forth.search->goal;
    back.search = first;
    back.search->goal = goal;
    back.search->checks = checks_;
    const exploration::SweepPlan back_plan = make_plan(back);
    const exploration::Exploration firsts = run(back_plan, std::nullopt);
    print_front(back_plan, firsts);
    if (!quiet_) {
        print_pace(seconds);
        print_pace(firsts);
    }
    return judge(firsts);
}

ExitStatus SizeCommand::execute() {
    if (minimize_.size() > 2) {
        throw InputError("--minimize: " + std::to_string(minimize_.size()) +
                         " keys; use one, or two for the front of both");
    }
    return minimize_.size() == 1 ? size_one() : size_front();
}

}  // namespace metabuffer
