#pragma once

#include <cstdint>
#include <string>

#include "scenario/scenario.h"

namespace metabuffer::test {

/// A small scenario that is anything a scenario may be: grid, sizes, supersampling, images with ties in
/// depth, viewports partly outside, tables with rows of every defect, several frames, all policies, clocks,
/// buffers from the smallest legal one on, corrected colours, and faults of the link. The same seed gives the same scenario
/// everywhere.
Scenario random_scenario(std::uint64_t seed);

/// Another such scenario with more frames, in which tables come back, go away and stay empty for a while, with pages of
/// a few words and deeper columns. In it the memory of earlier frames matters.
Scenario random_long_scenario(std::uint64_t seed);

/// What the levels are compared on: of every three seeds, the third makes a long scenario.
Scenario random_level_scenario(std::uint64_t seed);

/// A random scenario in which several rows of composers have every handshake held back at random; for level rtl.
Scenario random_stalled_scenario(std::uint64_t seed);

/// Its main parameters on one line, to go with a failure.
std::string describe(const Scenario& scenario);

}  // namespace metabuffer::test
