#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer::test {

/// A scenario made a little smaller, and how.
struct Reduction {
    std::string what;  ///< "without renderer 2"
    Scenario scenario;
};

/// Every legal scenario that is one step smaller, those first that take most away: fewer frames, renderers, displays,
/// faults and table rows, smaller images and rasters, settings at their defaults, segments without offsets and
/// replication. No chain of such steps goes on for ever. The same scenario gives the same steps.
std::vector<Reduction> reductions(const Scenario& scenario);

/// Whether a scenario still fails as the one to shrink does.
using StillFails = std::function<bool(const Scenario&)>;

struct Shrunk {
    Scenario scenario;
    std::vector<std::string> steps;  ///< what was taken away, in order
    int runs = 0;                    ///< scenarios that were tried
    bool at_its_smallest = false;    ///< no further step keeps the failure; else `most_runs` ended it
};

/// Takes every step that keeps the failure until none does, trying at most `most_runs` scenarios. Greedy and
/// deterministic, as far as still_fails is.
Shrunk shrink(const Scenario& scenario, const StillFails& still_fails, int most_runs);

}  // namespace metabuffer::test
