#include "tools/program/size_margin.h"

#include <algorithm>
#include <iostream>
#include <optional>
#include <utility>

#include "host/text.h"
#include "report/text_table.h"
#include "tools/program/exploration_run.h"

namespace metabuffer {
namespace {

using exploration::Margin;
using exploration::Reach;
using exploration::SearchDescription;
using exploration::SweepDescription;

constexpr std::size_t kMostMachines = 16;

std::string without_map(const std::string& key) { return key.substr(key.find('.') + 1); }

/// A machine whose answer has been raised as far as the margin needs.
struct Trial {
    const SizedMachine* machine = nullptr;
    std::int64_t answer = 0;
    Margin margin;
    std::string unmet;  ///< why no value has the margin
    double cost() const { return text::decimal_number(figure_text(margin.machine, "cost", 6)).value_or(0.0); }
    std::string text() const {
        std::string text;
        for (const exploration::Setting& setting : machine->settings)
            text += setting.key + "=" + setting.value + " ";
        return text + machine->search.search->setting_text(answer) + ", cost " +
               figure_text(margin.machine, "cost", 0);
    }
};

class MarginTrials {
  public:
    explicit MarginTrials(const MarginRequest& request) : request_(request) {}

    /// Nothing if it was stopped.
    std::optional<Trial> try_machine(const SizedMachine& machine) {
        Trial trial;
        trial.machine = &machine;
        trial.answer = machine.answer;
        for (;;) {
            trial.margin = exploration::margin_of(machine.search, trial.answer, exploration::kMarginSteps,
                                                  request_.judge);
            simulations_ += trial.margin.simulations;
            if (trial.margin.stopped) return std::nullopt;
            if (trial.margin.machine.smallest && trial.margin.steps() >= request_.steps) return trial;
            if (!raise(trial)) return std::nullopt;
            if (!trial.unmet.empty()) return trial;
        }
    }
    std::size_t simulations() const { return simulations_; }

  private:
    /// Searches above the answer for the smallest value at which each move that fails is met. Returns false if it was
    /// stopped.
    bool raise(Trial& trial) {
        SweepDescription more = trial.machine->search;
        SearchDescription& search = more.search.value();
        search.goal = request_.judge.goal(request_.steps);
        search.from = std::max(search.from, trial.answer + 1);
        search.candidates.erase(
            search.candidates.begin(),
            std::upper_bound(search.candidates.begin(), search.candidates.end(), trial.answer));
        const bool has_list = !trial.machine->search.search->candidates.empty();
        if (has_list ? search.candidates.empty() : search.from > search.to) {
            trial.unmet = "no larger value may be tried";
            return true;
        }
        if (!has_list) search.candidates.clear();
        std::vector<exploration::Move> failing;
        for (const Reach& reach : trial.margin.reaches) {
            if (reach.steps < request_.steps) failing.push_back({&reach.key, request_.steps});
        }
        // Without moves the machine itself misses its goal at this value.
        if (!failing.empty()) more.axes = exploration::axes_of(trial.margin.reaches, failing);
        const exploration::SweepPlan plan = exploration::make_plan(more);
        const exploration::Exploration found = request_.judge.run(plan, request_.steps);
        simulations_ += found.progress.runs;
        if (found.stopped) return false;
        std::int64_t answer = trial.answer;
        for (const exploration::PointRecord& point : found.points) {
            if (!point.smallest) {
                trial.unmet = point.reason;
                return true;
            }
            answer = std::max(answer, search.candidate_of(*point.smallest));
        }
        trial.answer = answer;
        return true;
    }

    const MarginRequest& request_;
    std::size_t simulations_ = 0;
};

/// How far each key may move, by key: "-5 % +0.1 %".
std::vector<std::pair<std::string, std::string>> reaches_by_key(const Margin& margin) {
    std::vector<std::pair<std::string, std::string>> cells;
    for (const Reach& reach : margin.reaches) {
        if (cells.empty() || cells.back().first != reach.key.key) cells.emplace_back(reach.key.key, "");
        const std::string none(1, reach.key.distances.front().front());
        std::string& cell = cells.back().second;
        cell +=
            (cell.empty() ? "" : " ") +
            (reach.steps == 0 ? none + "0" : reach.key.distances[static_cast<std::size_t>(reach.steps) - 1]);
    }
    return cells;
}

/// What the move misses that may go the least far.
std::string first_miss(const Margin& margin) {
    const auto first = std::min_element(margin.reaches.begin(), margin.reaches.end(),
                                        [](const Reach& a, const Reach& b) { return a.steps < b.steps; });
    if (first == margin.reaches.end() || first->missed.empty()) return "";
    return without_map(first->key.key) + " " + first->key.value + " to " +
           first->key.moved[static_cast<std::size_t>(first->steps)] + ": " + text::message(first->missed);
}

void print_table(const std::vector<Trial>& trials, const MarginRequest& request) {
    std::vector<std::string> moved_keys;
    for (const Trial& trial : trials) {
        for (const auto& [key, cell] : reaches_by_key(trial.margin)) {
            if (std::find(moved_keys.begin(), moved_keys.end(), key) == moved_keys.end())
                moved_keys.push_back(key);
        }
    }
    const std::string& searched = trials.front().machine->search.search->key;
    std::vector<std::string> heading;
    for (const exploration::Setting& setting : trials.front().machine->settings)
        heading.push_back(setting.key);
    heading.insert(heading.end(), {searched, "cost", "margin"});
    for (const std::string& key : moved_keys) heading.push_back(without_map(key));
    TextTable table({heading.size()});
    heading.emplace_back("first miss");
    table.add(heading);
    for (const Trial& trial : trials) {
        std::vector<std::string> cells;
        for (const exploration::Setting& setting : trial.machine->settings) cells.push_back(setting.value);
        cells.push_back(trial.machine->search.search->text_of(trial.answer));
        cells.push_back(figure_text(trial.margin.machine, "cost", 0));
        cells.push_back(std::to_string(trial.margin.steps()));
        const auto reaches = reaches_by_key(trial.margin);
        for (const std::string& key : moved_keys) {
            const auto reach = std::find_if(reaches.begin(), reaches.end(),
                                            [&key](const auto& cell) { return cell.first == key; });
            cells.push_back(reach == reaches.end() ? "" : reach->second);
        }
        cells.push_back(trial.unmet.empty() ? first_miss(trial.margin)
                                            : "margin " + std::to_string(request.steps) +
                                                  " not kept: " + text::message(trial.unmet));
        table.add(std::move(cells));
    }
    std::cout << table.text();
}

const Trial* cheapest(const std::vector<Trial>& trials, int steps) {
    const Trial* least = nullptr;
    for (const Trial& trial : trials) {
        if (trial.margin.steps() >= steps && (least == nullptr || trial.cost() < least->cost()))
            least = &trial;
    }
    return least;
}

}  // namespace

SizedMachine::SizedMachine(const exploration::SweepDescription& asked,
                           std::vector<exploration::Setting> settings_in, double answer_in)
    : settings(std::move(settings_in)), search(asked), answer(asked.search->candidate_of(answer_in)) {
    search.axes.clear();
    for (const exploration::Setting& setting : settings) search.fixed.push_back({setting.key, setting.value});
}

bool print_margins(const std::vector<SizedMachine>& machines, const MarginRequest& request) {
    MarginTrials margins(request);
    std::vector<Trial> trials;
    bool stopped = false;
    for (const SizedMachine& machine : machines) {
        if (trials.size() == kMostMachines) break;
        std::optional<Trial> trial = margins.try_machine(machine);
        if (!trial) {
            stopped = true;
            break;
        }
        trials.push_back(std::move(*trial));
    }
    if (trials.empty()) return stopped;
    std::cout << "margin, in " << margins.simulations()
              << " simulations: how far one time or clock may move alone, of "
              << exploration::margin_steps_text() << '\n';
    print_table(trials, request);
    if (machines.size() > trials.size() && !stopped)
        std::cout << "  ... and " << machines.size() - trials.size() << " machines more, not tried\n";
    if (request.steps > 0) {
        const Trial* const best = cheapest(trials, request.steps);
        std::cout << "cheapest with margin " << request.steps << ": "
                  << (best == nullptr ? "none" : best->text()) << '\n';
    }
    return stopped;
}

}  // namespace metabuffer
