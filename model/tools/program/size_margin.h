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
    std::vector<std::string> settings;     ///< texts of the keys that vary, without the one that was searched
    exploration::SweepDescription search;  ///< for that key, without axes
    std::int64_t answer = 0;               ///< of the key, in the search's steps
};

/// What the margins of metabuffer size need.
struct MarginRequest {
    std::vector<std::string> keys;  ///< of SizedMachine::settings
    int steps = 0;  ///< 0: the answers stand; else each is raised until every key may move so far
    exploration::MarginJudge judge;
};

/// Prints for each machine how far each time and clock may move, its cost, and with steps the cheapest machine that has
/// the margin. Returns true if it was stopped.
bool print_margins(const std::vector<SizedMachine>& machines, const MarginRequest& request);

}  // namespace metabuffer
