#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer::test {

/// A small scenario whose buses have to carry about what they can, from a third of it to twice as much. It has one to
/// three renderers, one to nine displays, every multiple, offset, policy, bus, burst, ready space and page, and one to
/// three frames whose viewports move. Two of three have some of machine_kinds(). Some pairs are late or missing. composer.buffer_pixels is the largest legal one;
/// the test chooses its own. The same seed gives the same scenario everywhere.
Scenario random_load_scenario(std::uint64_t seed);

/// What a machine's memory, bus and arbiter have besides the simplest ones: "banks", "refresh", "shared" (ports), "delays"
/// (read latency, registers), "arbiter" (that takes time).
std::vector<std::string> machine_kinds(const Scenario& scenario);

}  // namespace metabuffer::test
