#pragma once

#include <cstdint>
#include <string>

#include "scenario/scenario.h"

namespace metabuffer::test {

/// A small scenario that is anything a scenario may be: grid, sizes, supersampling, images with ties in
/// depth, viewports partly outside, tables with rows of every defect, several frames, all policies, clocks,
/// buffers from the smallest legal one on, and faults of the link. The same seed gives the same scenario
/// everywhere.
Scenario random_scenario(std::uint64_t seed);

/// Its main parameters on one line, to go with a failure.
std::string describe(const Scenario& scenario);

}  // namespace metabuffer::test
