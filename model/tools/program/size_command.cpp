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
#include "tools/exploration/figures.h"
#include "tools/program/number_option.h"
#include "tools/program/option_ranges.h"

namespace metabuffer {
namespace {

using exploration::Axis;
using exploration::SearchDescription;

/// Once a front has more corners than these, no more are searched for between them.
constexpr std::size_t kMostCorners = 24;

std::string size_footer() {
    return "The value is doubled until the goal is met, then the gap below is halved. --checks further "
           "values on both\n"
           "sides show whether the goal is monotonic; the answer says so where it is not. For buffers "
           "without a range\n"
           "only those sizes are tried that metabuffer analyze leaves open, and the size that stalling "
           "columns need is\n"
           "reported too. Then each time and each clock of an answer's machine is moved alone,\n"
           "by " +
           exploration::margin_steps_text() +
           ". The goal is an SQL expression\n"
           "over figures of a run (metabuffer export --help lists them) and the keys that vary.\n"
           "Examples:\n"
           "  metabuffer size scenarios/case-4.yaml --minimize composer.buffer_pixels --over "
           "bus.width_bits=64,128\n"
           "  metabuffer size scenarios/case-4.yaml --minimize composer.buffer_pixels --margin 2\n"
           "  metabuffer size scenarios/case-4.yaml --minimize bus.width_bits --minimize "
           "composer.buffer_pixels\n"
           "  metabuffer size scenarios/paper-figure.yaml --minimize bus.burst_pixels=1..256 \\\n"
           "      --over bus.arbitration=irsa,round-robin,edf --over memory.page_miss_cycles=0..12+3\n"
           "Exit status: 0 every search has ended; 2 bad input, or no point makes a scenario; 130 stopped by "
           "Ctrl-C.";
}

/// The values of the first of two keys that are tried at first: all candidates, or the range in doubling steps, with
/// both ends. The exact corners of the front are found afterwards.
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

/// A machine that meets the goal, or settings for which none does.
struct Corner {
    std::vector<std::string> overs;  ///< values of --over
    std::string first;               ///< of the keys to be minimized
    std::string second;              ///< empty: none meets the goal
    exploration::PointRecord record;
};

/// The corners that no other one with the same values of --over undercuts: less in one key, and not more in the other.
/// In the order of these values, then by rising first key.
std::vector<Corner> front_of(const std::vector<Corner>& corners) {
    std::vector<std::vector<std::string>> order;
    std::vector<Corner> front;
    for (const Corner& corner : corners) {
        if (std::find(order.begin(), order.end(), corner.overs) == order.end()) order.push_back(corner.overs);
        if (corner.second.empty()) continue;
        const double first = std::stod(corner.first);
        const double second = std::stod(corner.second);
        const bool undercut = std::any_of(corners.begin(), corners.end(), [&](const Corner& other) {
            if (other.second.empty() || other.overs != corner.overs) return false;
            const double other_first = std::stod(other.first);
            const double other_second = std::stod(other.second);
            return other_first <= first && other_second <= second &&
                   (other_first < first || other_second < second);
        });
        const bool known = std::any_of(front.begin(), front.end(), [&corner](const Corner& other) {
            return other.overs == corner.overs && other.first == corner.first &&
                   other.second == corner.second;
        });
        if (!undercut && !known) front.push_back(corner);
    }
    // Values of --over with which no machine meets the goal have a line as well.
    for (const std::vector<std::string>& overs : order) {
        const auto is_of = [&overs](const Corner& corner) { return corner.overs == overs; };
        if (std::none_of(front.begin(), front.end(), is_of)) {
            // The line shows the last corner, that of the largest value of the first key.
            front.push_back(*std::find_if(corners.rbegin(), corners.rend(), is_of));
        }
    }
    const auto place_of = [&order](const Corner& corner) {
        return std::find(order.begin(), order.end(), corner.overs) - order.begin();
    };
    std::stable_sort(front.begin(), front.end(), [&place_of](const Corner& a, const Corner& b) {
        const auto first = [](const Corner& corner) {
            return corner.second.empty() ? 0.0 : std::stod(corner.first);
        };
        return std::pair(place_of(a), first(a)) < std::pair(place_of(b), first(b));
    });
    return front;
}

/// The largest value below `value` that a search may try; empty if there is none.
std::string value_below(const SearchDescription& search, double value) {
    std::optional<std::int64_t> below;
    const auto is_below = [&](std::int64_t candidate) { return search.number_of(candidate) < value; };
    for (const std::int64_t candidate : search.candidates) {
        if (is_below(candidate)) below = candidate;
    }
    if (search.candidates.empty()) {
        const double steps = search.step > 0.0 ? std::round(value / search.step) : value;
        const auto candidate = static_cast<std::int64_t>(steps) - 1;
        if (candidate >= search.from && is_below(candidate)) below = candidate;
    }
    return below ? search.text_of(*below) : std::string();
}

/// For each corner of the front and the next one, the values of --over, and a value of the second key between the two.
std::set<std::vector<std::string>> gaps_of(const std::vector<Corner>& corners,
                                           const SearchDescription& second) {
    std::set<std::vector<std::string>> gaps;
    const std::vector<Corner> front = front_of(corners);
    for (std::size_t n = 0; n + 1 < front.size(); ++n) {
        const bool both = !front[n].second.empty() && !front[n + 1].second.empty();
        if (!both || front[n].overs != front[n + 1].overs) continue;
        const std::string below = value_below(second, std::stod(front[n].second));
        if (below.empty() || std::stod(below) <= std::stod(front[n + 1].second)) continue;
        std::vector<std::string> values = front[n].overs;
        values.push_back(below);
        gaps.insert(std::move(values));
    }
    return gaps;
}

/// The goal of the rate that was asked for, or else of the answer's own.
std::string same_rate(const exploration::PointRecord& answer, std::optional<double> asked_hz) {
    const std::string own = figure_text(answer, "frames_per_second", 6);
    if (!asked_hz && own.empty()) {
        return "frame_cycles <= " + text::number(1.0 + kRateTolerance) + " * " +
               figure_text(answer, "frame_cycles", 3);
    }
    return "frames_per_second >= " + text::number(1.0 - kRateTolerance) + " * " +
           (asked_hz ? text::number(*asked_hz) : own);
}

void print_front(const std::vector<std::string>& over_keys, const std::string& first,
                 const std::string& second, const std::vector<Corner>& corners) {
    TextTable table({over_keys.size() + 5});
    std::vector<std::string> heading = over_keys;
    heading.insert(heading.end(), {first, second, "frames/s", "cost", "bottleneck", ""});
    table.add(heading);
    for (const Corner& corner : front_of(corners)) {
        std::vector<std::string> cells = corner.overs;
        const bool met = !corner.second.empty();
        cells.push_back(met ? corner.first : "");
        cells.push_back(met ? corner.second : to_string(corner.record.status));
        cells.push_back(figure_text(corner.record, "frames_per_second"));
        cells.push_back(figure_text(corner.record, "cost", 0));
        cells.push_back(figure_text(corner.record, "bottleneck"));
        cells.push_back(met ? corner.record.note : corner.record.reason);
        table.add(std::move(cells));
    }
    std::cout << table.text();
}

}  // namespace

SizeCommand::SizeCommand(CLI::App& program)
    : Command(program, "size", "Find the smallest value of a key at which nothing starves"),
      scenario_(command()) {
    command()
        .add_option(
            "--minimize", request_.minimize,
            "KEY, KEY=FROM..TO, KEY=FROM..TO+STEP or KEY=A,B,C: a key that takes numbers, and where to look; "
            "given for two keys, the front of both")
        ->required()
        ->take_all()
        ->allow_extra_args(false);
    command()
        .add_option(
            "--over", request_.over,
            "KEY=VALUES: do so for each of these values, as 32,64,128 or 64..512*2 or 0..12+3; may be given "
            "several times")
        ->take_all()
        ->allow_extra_args(false);
    command().add_option("--goal", request_.goal,
                         "When a value is good (default: " + exploration::default_goal() + ")");
    command()
        .add_option(
            "--frame-rate-hz", request_.frame_rate_hz,
            "The machine also composites and shows that many frames a second, at no longer interval; needs "
            "3 frames or more, see --frames")
        ->check(number_within(kFrameRatesHz));
    command()
        .add_option("--checks", request_.checks,
                    "Further values to try, to see whether the goal is monotonic")
        ->check(CLI::Range(kChecks.low, kChecks.high))
        ->capture_default_str();
    command()
        .add_option(
            "--margin", margin_steps_,
            "Raise each answer until any time or clock of the machine may move so many steps: 1, 2 or 3; "
            "and name the cheapest machine")
        ->check(CLI::Range(1, exploration::kMarginSteps));
    command().add_option(
        "-o,--out", results_file_,
        "Keep the results in this SQLite file, as sweep does; of two keys those of the front");
    add_options(command(), processes_);
    command().add_flag("--quiet", quiet_, "Print the table alone");
    command().footer(size_footer());
}

exploration::Exploration SizeCommand::run(const exploration::SweepPlan& plan, const SizeRequest& request,
                                          const std::optional<std::filesystem::path>& results) const {
    return run_exploration(plan, results, processes_, quiet_, true, [&](const Scenario& scenario) {
        return known_answer(request, scenario, *plan.search);
    });
}

/// With columns that may stall, a smaller buffer shows the whole picture as well, but later. Prints the smallest buffer
/// that reaches the same rate. Returns true if it was stopped.
bool SizeCommand::print_stalling(const exploration::SweepDescription& asked,
                                 const exploration::Exploration& exploration,
                                 std::size_t& simulations) const {
    constexpr std::size_t kMostPoints = 16;
    if (asked.search->key != kBufferKey || !request_.goal.empty()) return false;
    TextTable table({asked.axes.size() + 5});
    std::vector<std::string> heading;
    for (const Axis& axis : asked.axes) heading.push_back(axis.keys.front());
    heading.insert(heading.end(),
                   {"smallest " + asked.search->key, "runs", "cost", "frames/s", "stalled clocks", ""});
    table.add(heading);
    std::size_t lines = 0;
    std::size_t left_out = 0;
    bool stopped = false;
    for (const exploration::PointRecord& point : exploration.points) {
        if (!point.smallest) continue;
        if (lines == kMostPoints) {
            ++left_out;
            continue;
        }
        exploration::SweepDescription stalling = asked;
        stalling.axes.clear();
        // The first answer does not stall, so it meets this goal, too.
        SearchDescription& search = *stalling.search;
        const auto most = static_cast<std::int64_t>(*point.smallest);
        search.to = std::min(search.to, most);
        search.candidates.erase(std::upper_bound(search.candidates.begin(), search.candidates.end(), most),
                                search.candidates.end());
        for (const exploration::Setting& setting : point.settings)
            stalling.fixed.push_back({setting.key, setting.value});
        stalling.fixed.push_back({"composer.on_starvation", "stall"});
        search.goal = std::string(exploration::kWhole) + " and " + same_rate(point, request_.frame_rate_hz);
        const exploration::SweepPlan plan = make_plan(stalling);
        const exploration::Exploration found = run(plan, request_, std::nullopt);
        simulations += found.progress.runs;
        if (found.stopped || found.points.empty()) {
            stopped = true;
            break;
        }
        const exploration::PointRecord& answer = found.points.front();
        std::vector<std::string> cells;
        for (const exploration::Setting& setting : point.settings) cells.push_back(setting.value);
        cells.push_back(answer.smallest ? text::number(*answer.smallest) : to_string(answer.status));
        cells.push_back(std::to_string(answer.runs));
        cells.push_back(figure_text(answer, "cost", 0));
        cells.push_back(figure_text(answer, "frames_per_second"));
        cells.push_back(figure_text(answer, "stalled_cycles"));
        cells.emplace_back(answer.smallest ? answer.note : answer.reason);
        table.add(std::move(cells));
        ++lines;
    }
    if (lines == 0) return stopped;
    std::cout << "with on_starvation: stall, whole pictures " << (request_.frame_rate_hz ? "" : "and ")
              << "at the same rate:\n"
              << table.text();
    if (left_out > 0) std::cout << "  ... and " << left_out << " points more, not tried\n";
    return stopped;
}

/// Prints the margins of answers. Returns false if it was stopped.
bool SizeCommand::try_margins(const std::vector<SizedMachine>& machines) const {
    const bool is_fast = processes_.level == TimedLevel::kTlm;
    if ((quiet_ || !is_fast) && margin_steps_ == 0) return true;
    MarginRequest margins;
    margins.steps = margin_steps_;
    const auto request_at = [this](int step) {
        SizeRequest slower = request_;
        if (slower.frame_rate_hz) *slower.frame_rate_hz *= 1.0 - exploration::clock_share(step);
        return slower;
    };
    margins.judge.goal = [request_at](int step) { return describe_size(request_at(step)).search->goal; };
    margins.judge.run = [this, request_at](const exploration::SweepPlan& plan, int step) {
        return run(plan, request_at(step), std::nullopt);
    };
    const bool stopped = print_margins(machines, margins);
    if (stopped) std::cerr << "stopped while margins were tried\n";
    return !stopped;
}

ExitStatus SizeCommand::size_one() {
    const exploration::SweepDescription asked = describe_size(request_);
    const exploration::SweepPlan plan = make_plan(asked);
    check_frames(request_, plan);
    const exploration::Exploration exploration =
        run(plan, request_,
            results_file_.empty() ? std::nullopt : std::optional<std::filesystem::path>(results_file_));
    if (!quiet_) std::cout << "goal: " << plan.search->goal << '\n';
    print_smallest(plan, exploration);
    if (!quiet_) {
        print_idle_buses(exploration);
        std::size_t stalling_runs = 0;
        const bool stopped = !exploration.stopped && print_stalling(asked, exploration, stalling_runs);
        if (stopped) {
            std::cerr << "stopped in the comparison with stalling columns\n";
            return kExitStopped;
        }
        print_pace(exploration);
        if (stalling_runs > 0) std::cout << "and " << stalling_runs << " with on_starvation: stall\n";
        if (!results_file_.empty()) std::cout << "results in " << results_file_ << '\n';
    }
    std::vector<SizedMachine> machines;
    for (const exploration::PointRecord& point : exploration.points) {
        if (point.smallest) machines.emplace_back(asked, point.settings, *point.smallest);
    }
    if (!exploration.stopped && !try_margins(machines)) return kExitStopped;
    return judge(exploration);
}

/// Minimizes the second key at coarse values of the first, then the first key at each answer, then the second key at
/// each of these answers, and so on, until there are no new answers. Then it searches between the corners of the front.
ExitStatus SizeCommand::size_front() {
    if (!results_file_.empty() && std::filesystem::exists(results_file_)) {
        throw InputError(
            "-o " + results_file_ +
            ": is there already, and a front is kept once it is whole; name another file, or remove it");
    }
    if (!results_file_.empty()) make_folder_of(results_file_, "--out");
    const SearchDescription first = minimized(request_.minimize.front());
    const exploration::SweepDescription asked = describe_size(request_);
    const SearchDescription& second = *asked.search;
    if (first.key == second.key) {
        throw InputError("--minimize: " + first.key + " is given twice; use two keys, or one");
    }
    std::vector<std::string> over_keys;
    for (const Axis& over : asked.axes) over_keys.push_back(over.keys.front());

    exploration::SweepDescription coarse = asked;
    coarse.axes.push_back(Axis{{first.key}, {coarse_values(first)}, {first.where}});
    exploration::SweepPlan plan = make_plan(coarse);
    check_frames(request_, plan);
    if (!quiet_) std::cout << "goal: " << plan.search->goal << '\n';
    std::vector<Corner> corners;
    using Values = std::vector<std::string>;
    std::set<Values> searched_firsts;
    std::set<Values> searched_seconds;
    exploration::Exploration all;
    std::size_t points = 0;
    bool of_second = true;
    for (;;) {
        const exploration::Exploration found = run(plan, request_, std::nullopt);
        all.progress.runs += found.progress.runs;
        all.progress.seconds += found.progress.seconds;
        for (const exploration::PointRecord& point : found.points) all.outcomes.add(points++, point);
        std::set<Values> next;
        for (const exploration::PointRecord& point : found.points) {
            Corner corner;
            for (std::size_t n = 0; n + 1 < point.settings.size(); ++n)
                corner.overs.push_back(point.settings[n].value);
            const std::string answer = point.smallest ? text::number(*point.smallest) : std::string();
            corner.first = of_second ? point.settings.back().value : answer;
            corner.second = of_second || answer.empty() ? answer : point.settings.back().value;
            corner.record = point;
            Values looked_at = corner.overs;
            looked_at.push_back(point.settings.back().value);
            (of_second ? searched_firsts : searched_seconds).insert(looked_at);
            if (of_second || !answer.empty()) corners.push_back(corner);
            if (answer.empty()) continue;
            looked_at.back() = answer;
            if ((of_second ? searched_seconds : searched_firsts).count(looked_at) == 0)
                next.insert(looked_at);
        }
        if (found.stopped) {
            print_front(over_keys, first.key, second.key, corners);
            std::cerr << "stopped: the front is not whole\n";
            return kExitStopped;
        }
        if (next.empty()) {
            // There may be more corners between two: with a second key a little smaller than that of the first of them.
            next = gaps_of(corners, second);
            for (const Values& values : searched_seconds) next.erase(values);
            if (next.empty() || front_of(corners).size() > kMostCorners) break;
            of_second = true;  // the first key is minimized next
        }
        exploration::SweepDescription more = asked;
        Axis looked_at;
        looked_at.keys = over_keys;
        looked_at.keys.push_back(of_second ? second.key : first.key);
        looked_at.values.resize(looked_at.keys.size());
        looked_at.where.resize(looked_at.keys.size());
        for (const Values& values : next) {
            for (std::size_t n = 0; n < values.size(); ++n) looked_at.values[n].push_back(values[n]);
        }
        more.axes = {std::move(looked_at)};
        if (of_second) {
            more.search = first;
            more.search->goal = second.goal;
            more.search->checks = request_.checks;
        }
        plan = make_plan(more);
        of_second = !of_second;
    }
    print_front(over_keys, first.key, second.key, corners);
    if (!quiet_) print_idle_buses(all);
    if (!quiet_)
        std::cout << all.progress.runs << " simulations in " << text::decimal(all.progress.seconds, 1)
                  << " s\n";
    Axis rows;  // of the front: the values of --over, then of both keys
    rows.keys = over_keys;
    rows.keys.insert(rows.keys.end(), {first.key, second.key});
    rows.values.resize(rows.keys.size());
    rows.where.resize(rows.keys.size());
    std::vector<SizedMachine> machines;
    for (const Corner& corner : front_of(corners)) {
        if (corner.second.empty()) continue;
        std::vector<std::string> values = corner.overs;
        values.insert(values.end(), {corner.first, corner.second});
        std::vector<exploration::Setting> settings;
        for (std::size_t n = 0; n < values.size(); ++n) {
            rows.values[n].push_back(values[n]);
            settings.push_back({rows.keys[n], values[n]});
        }
        settings.pop_back();
        machines.emplace_back(asked, std::move(settings), std::stod(corner.second));
    }
    if (!results_file_.empty() && !machines.empty()) {
        exploration::SweepDescription front = asked;
        front.search.reset();
        front.axes = {rows};
        const exploration::Exploration kept =
            run_exploration(make_plan(front), results_file_, processes_, quiet_, true);
        if (kept.stopped) return judge(kept);
        if (!quiet_) std::cout << "results in " << results_file_ << '\n';
    }
    if (!try_margins(machines)) return kExitStopped;
    return judge(all);
}

ExitStatus SizeCommand::execute() {
    if (request_.minimize.size() > 2) {
        throw InputError("--minimize: " + std::to_string(request_.minimize.size()) +
                         " keys; use one, or two for the front of both");
    }
    request_.file = scenario_.file();
    request_.overrides = scenario_.overrides();
    return request_.minimize.size() == 1 ? size_one() : size_front();
}

}  // namespace metabuffer
