#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/exploration/margin.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer {

/// An answer of metabuffer size.
struct SizedMachine {
    /// settings: of the keys that vary, without the one that `asked` searches.
    SizedMachine(const exploration::SweepDescription& asked, std::vector<exploration::Setting> settings,
                 double answer);

    std::vector<exploration::Setting> settings;
    exploration::SweepDescription search;  ///< without axes
    std::int64_t answer;                   ///< of the searched key, in the search's steps
};

/// What the margins of metabuffer size need.
struct MarginRequest {
    int steps = 0;  ///< 0: the answers stand; else each is raised until every key may move so far
    exploration::MarginJudge judge;
};

/// Prints for each machine how far each time and clock may move, its cost, and with steps the cheapest machine that has
/// the margin. Returns true if it was stopped.
bool print_margins(const std::vector<SizedMachine>& machines, const MarginRequest& request);

}  // namespace metabuffer
