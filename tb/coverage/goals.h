#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace metabuffer::coverage {

/// Things of one kind that must each have happened in a test before the testbench is trusted.
struct GoalGroup {
    std::string name;     ///< "bus/burst"
    std::string meaning;  ///< one line for the report
    std::vector<std::string> bins;
};

/// Every group, in the order of the report. All bins are known beforehand, so that what is missing has a name.
const std::vector<GoalGroup>& goal_groups();

std::size_t goal_count();

/// The goal's place among all goals, from 0. Throws std::logic_error for a name that is no goal.
std::size_t goal_index(std::string_view group, std::string_view bin);

/// Whether there is such a goal.
bool is_goal(std::string_view group, std::string_view bin);

}  // namespace metabuffer::coverage
