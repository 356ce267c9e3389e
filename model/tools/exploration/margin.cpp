#include "tools/exploration/margin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer::exploration {
namespace {

constexpr double kPercent = 100.0;

/// By step, from the first.
constexpr std::array<int, kMarginSteps> kMovedCycles{1, 2, 4};
constexpr std::array<double, kMarginSteps> kMovedShares{0.001, 0.01, 0.05};

enum class Unit { kCycles, kShareOfCycles, kShareOfClock };

struct MoveKind {
    const char* key;
    const char* instead;  ///< the key to move where a scenario has this one; null: there is none
    Unit unit;
    std::vector<int> signs;
    const char* needs;  ///< only if this key is above 0
};

const std::vector<MoveKind>& move_kinds() {
    static const std::vector<MoveKind> kinds{
        {"memory.page_miss_cycles", "memory.activate_cycles", Unit::kCycles, {1}, "memory.page_miss_cycles"},
        {"memory.refresh_cycles", nullptr, Unit::kCycles, {1}, "memory.refresh_interval_cycles"},
        {"memory.refresh_interval_cycles",
         nullptr,
         Unit::kShareOfCycles,
         {-1},
         "memory.refresh_interval_cycles"},
        {"clocks.core_mhz", nullptr, Unit::kShareOfClock, {-1, 1}, nullptr},
        {"clocks.dvi_in_mhz", "clocks.dvi_in_refresh_hz", Unit::kShareOfClock, {-1, 1}, nullptr},
        {"clocks.dvi_out_mhz", "clocks.dvi_out_refresh_hz", Unit::kShareOfClock, {-1, 1}, nullptr},
    };
    return kinds;
}

std::string signed_text(int sign, const std::string& amount) { return (sign > 0 ? "+" : "-") + amount; }

MovedKey moved_key(const MoveKind& kind, int sign, const std::string& key, const std::string& value) {
    MovedKey moved{key, value, {}, {}};
    const double number = text::decimal_number(value).value();
    for (std::size_t step = 0; step < kMovedCycles.size(); ++step) {
        if (kind.unit == Unit::kCycles) {
            moved.moved.push_back(text::number(number + sign * kMovedCycles[step]));
            moved.distances.push_back(signed_text(sign, std::to_string(kMovedCycles[step])));
            continue;
        }
        constexpr double kDigits = 1e8;  // so that 60.06 is not 60.059999999999995
        const double there = std::round(number * (1.0 + sign * kMovedShares[step]) * kDigits) / kDigits;
        // Whole cycles: at least one less with each step.
        const double whole = std::min(std::floor(there), number - static_cast<double>(step) - 1.0);
        moved.moved.push_back(text::number(kind.unit == Unit::kShareOfCycles ? whole : there));
        moved.distances.push_back(signed_text(sign, text::number(kPercent * kMovedShares[step]) + " %"));
    }
    return moved;
}

/// Whether the scenario may have the key with that value.
bool takes(const ScenarioTemplate& scenario, std::vector<ScenarioOverride> overrides, const std::string& key,
           const std::string& value) {
    overrides.push_back({key, value});
    try {
        scenario.settings(overrides);
    } catch (const InputError&) {
        return false;
    }
    return true;
}

}  // namespace

std::string margin_steps_text() {
    std::vector<std::string> cycles;
    std::vector<std::string> shares;
    cycles.reserve(kMovedCycles.size());
    shares.reserve(kMovedShares.size());
    for (const int moved : kMovedCycles) cycles.push_back(std::to_string(moved));
    for (const double share : kMovedShares) shares.push_back(text::number(kPercent * share));
    return text::joined(cycles, "or") + " clocks, or " + text::joined(shares, "or") + " %";
}

double clock_share(int step) { return step == 0 ? 0.0 : kMovedShares.at(static_cast<std::size_t>(step) - 1); }

std::vector<MovedKey> moved_keys(const ScenarioTemplate& scenario,
                                 const std::vector<ScenarioOverride>& overrides,
                                 const std::string& searched_key) {
    const std::map<std::string, std::string> settings = scenario.settings(overrides);
    const auto number_of = [&settings](const char* key) {
        const auto found = settings.find(key);
        return found == settings.end() ? std::nullopt : text::decimal_number(found->second);
    };
    std::vector<MovedKey> keys;
    for (const MoveKind& kind : move_kinds()) {
        if (kind.needs != nullptr && number_of(kind.needs).value_or(0.0) <= 0.0) continue;
        // The key that the scenario gives: the other one follows from it and cannot move.
        const char* moving = kind.key;
        for (const char* const key : {kind.key, kind.instead}) {
            if (key == nullptr || !number_of(key)) continue;
            const auto may_move = [&](int sign) {
                return takes(scenario, overrides, key,
                             moved_key(kind, sign, key, settings.at(key)).moved.front());
            };
            if (std::any_of(kind.signs.begin(), kind.signs.end(), may_move)) {
                moving = key;
                break;
            }
        }
        if (moving == searched_key || !number_of(moving)) continue;
        for (const int sign : kind.signs) keys.push_back(moved_key(kind, sign, moving, settings.at(moving)));
    }
    return keys;
}

int Margin::steps() const {
    int least = reaches.empty() ? 0 : kMarginSteps;
    for (const Reach& reach : reaches) least = std::min(least, reach.steps);
    return least;
}

std::vector<Axis> axes_of(const std::vector<Reach>& reaches, const std::vector<Move>& moves) {
    Axis axis;
    for (const Reach& reach : reaches) {
        const std::string& key = reach.key.key;
        if (std::find(axis.keys.begin(), axis.keys.end(), key) != axis.keys.end()) continue;
        axis.keys.push_back(key);
        axis.where.emplace_back();
        std::vector<std::string>& values = axis.values.emplace_back();
        for (const auto& [moved, step] : moves) {
            values.push_back(step > 0 && moved->key == key ? moved->moved[static_cast<std::size_t>(step) - 1]
                                                           : reach.key.value);
        }
    }
    if (axis.keys.empty()) return {};
    return {std::move(axis)};
}

Margin margin_of(const SweepDescription& machine, std::int64_t candidate, int steps,
                 const MarginJudge& judge) {
    SweepDescription one = machine;
    SearchDescription& search = one.search.value();
    search.from = search.to = candidate;
    search.candidates.clear();
    search.checks = 0;
    std::vector<ScenarioOverride> overrides = machine.fixed;
    overrides.push_back({search.key, search.text_of(candidate)});
    Margin margin;
    for (MovedKey& key : moved_keys(ScenarioTemplate(machine.scenario), overrides, search.key))
        margin.reaches.push_back({std::move(key), 0, ""});

    for (int step = 0; step <= steps; ++step) {
        std::vector<Reach*> tried;
        std::vector<Move> moves;
        for (Reach& reach : margin.reaches) {
            if (step > 0 && !reach.missed.empty()) continue;
            if (step == 0 && !moves.empty()) break;
            tried.push_back(&reach);
            moves.push_back({&reach.key, step});
        }
        if (step > 0 && tried.empty()) break;
        one.axes = axes_of(margin.reaches, moves);
        search.goal = judge.goal(step);
        const SweepPlan plan = make_plan(one);
        const Exploration found = judge.run(plan, step);
        margin.simulations += found.progress.runs;
        if (found.stopped) {
            margin.stopped = true;
            return margin;
        }
        if (step == 0) {
            margin.machine = found.points.front();
            if (!margin.machine.smallest) {
                margin.reaches.clear();
                return margin;
            }
            continue;
        }
        for (std::size_t n = 0; n < tried.size(); ++n) {
            if (found.points[n].smallest) {
                tried[n]->steps = step;
            } else {
                const std::string& reason = found.points[n].reason;
                const std::string begin = search.setting_text(candidate) + ": ";
                tried[n]->missed = reason.rfind(begin, 0) == 0 ? reason.substr(begin.size()) : reason;
            }
        }
    }
    return margin;
}

}  // namespace metabuffer::exploration
