#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenario/scenario_template.h"
#include "tools/exploration/explorer.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer::exploration {

/// How many steps a time or a clock of a machine may move.
constexpr int kMarginSteps = 3;
/// "1, 2 or 4 clocks, or 0.1, 1 or 5 %".
std::string margin_steps_text();

/// A time or a clock that a bought part or a board may not keep to, and one direction in which it may move. A tenth of a
/// per cent of a clock moves its phase against the others.
struct MovedKey {
    std::string key;    ///< "memory.page_miss_cycles"
    std::string value;  ///< the machine's own
    /// By step: the value moved to, and how far that is: "+2", "-1 %".
    std::vector<std::string> moved;
    std::vector<std::string> distances;
};

/// Those of the machine that the scenario makes with these overrides: the times of a memory that has pages or refresh,
/// slower; the three clocks, both ways; without the key that is searched. Throws InputError for overrides that make no
/// scenario.
std::vector<MovedKey> moved_keys(const ScenarioTemplate& scenario,
                                 const std::vector<ScenarioOverride>& overrides,
                                 const std::string& searched_key);

/// How far one of them may move, alone, while the machine meets its goal.
struct Reach {
    MovedKey key;
    int steps = 0;       ///< 0 to kMarginSteps
    std::string missed;  ///< what the goal misses one step further; empty: as many steps as were tried
};

/// The margin of a machine.
struct Margin {
    PointRecord machine;         ///< its own run
    std::vector<Reach> reaches;  ///< empty if the machine itself misses the goal
    bool stopped = false;        ///< by Ctrl-C; the rest has no meaning
    std::size_t simulations = 0;
    /// Steps that every key may move.
    int steps() const;
};

/// A key, and the steps that it moves; 0: none.
struct Move {
    const MovedKey* key = nullptr;
    int step = 0;
};
/// An axis with an entry for each move, in which all other keys have the machine's values. None for a machine without keys
/// that may move.
std::vector<Axis> axes_of(const std::vector<Reach>& reaches, const std::vector<Move>& moves);

/// How a machine is judged after so many steps; 0: as it is. A rate that is asked for is less on slower clocks.
struct MarginJudge {
    std::function<std::string(int step)> goal;
    std::function<Exploration(const SweepPlan& plan, int step)> run;
};

/// Tries the moves of a machine, each alone, up to so many steps. `machine` describes a search without axes; its key has
/// the value of that candidate. Throws InputError.
Margin margin_of(const SweepDescription& machine, std::int64_t candidate, int steps,
                 const MarginJudge& judge);

/// The share of its frequency by which a clock moves in so many steps.
double clock_share(int step);

}  // namespace metabuffer::exploration
