#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <systemc>
#include <vector>

#include "load_scenario.h"
#include "scenario/names.h"
#include "scenario/scenario_loader.h"
#include "starvation_run.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/analysis/buffer_bound.h"

// How close the bound of `metabuffer analyze` comes to what the simulation needs, for scripts/benchmark bound.

using namespace metabuffer;
using namespace metabuffer::test;

namespace {

constexpr int kUsage = 2;
constexpr const char* kHelp =
    "usage: bound_ratio FIRST_SEED COUNT          random machines\n"
    "       bound_ratio SCENARIO [PATH=VALUE...]  a scenario file\n"
    "Prints for each machine: name, policy, load of its busiest bus, whether bursts are whole, smallest "
    "legal buffer,\n"
    "bound, smallest buffer without a starved pixel in the simulation, whether the machine of the bound "
    "starves,\n"
    "how its composers magnify, what its memory and bus have besides: banks, refresh, shared ports, delays,\n"
    "an arbiter that takes time.\n";

/// The smallest buffer with which nothing starves. A larger buffer may starve where a smaller one does not, since
/// columns then start at other times. So some sizes below the one that is found are tried, too.
std::int64_t simulated_minimum(const Scenario& scenario, std::int64_t least, std::int64_t bound) {
    constexpr std::int64_t kNeighbours = 6;
    const auto starves = [&](std::int64_t pixels) {
        return !run_with_buffer(scenario, static_cast<int>(pixels)).none();
    };
    if (!starves(least)) return least;
    std::int64_t too_few = least;
    std::int64_t enough = bound;
    for (std::int64_t stride = 1; too_few + stride < bound; stride *= 2) {
        if (!starves(too_few + stride)) {
            enough = too_few + stride;
            break;
        }
        too_few += stride;
    }
    while (enough - too_few > 1) {
        const std::int64_t middle = too_few + (enough - too_few) / 2;
        (starves(middle) ? too_few : enough) = middle;
    }
    for (std::int64_t less = 2; less <= kNeighbours; ++less) {
        if (enough - less <= least || starves(enough - less)) continue;
        enough -= less;
        less = 1;
    }
    return enough;
}

void measure(const Scenario& scenario) {
    std::string kinds;
    for (const std::string& kind : machine_kinds(scenario)) kinds += (kinds.empty() ? "" : "+") + kind;
    if (kinds.empty()) kinds = "plain";
    const analysis::Analysis analysis = analysis::analyze(scenario);
    double load = 0.0;
    bool whole_bursts = true;
    for (const analysis::TableAnalysis& table : analysis.tables) {
        load = std::max(load, table.load);
        whole_bursts = whole_bursts && table.supply.whole_bursts;
    }
    const std::int64_t bound = analysis.safe_buffer_pixels.value_or(analysis.whole_buffer_pixels);
    const bool starves = !run_with_buffer(scenario, static_cast<int>(bound)).none();
    std::cout << scenario.name << ' ' << to_string(scenario.bus.arbitration) << ' ' << load << ' '
              << (whole_bursts ? "whole" : "cut") << ' ' << analysis.least_buffer_pixels << ' ' << bound
              << ' ' << simulated_minimum(scenario, analysis.least_buffer_pixels, bound) << ' '
              << (starves ? "starves" : "safe") << ' '
              << row_of(kSmoothingTable, scenario.composer.smoothing).name << ' ' << kinds << std::endl;
}

std::optional<std::uint64_t> whole_number(std::string_view text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

int run(const std::vector<std::string>& words) {
    if (words.empty()) {
        std::cerr << kHelp;
        return kUsage;
    }
    const auto first = whole_number(words[0]);
    const auto count = words.size() == 2 ? whole_number(words[1]) : std::nullopt;
    if (first && count) {
        for (std::uint64_t seed = *first; seed < *first + *count; ++seed) measure(random_load_scenario(seed));
        return EXIT_SUCCESS;
    }
    std::vector<ScenarioOverride> overrides;
    for (std::size_t i = 1; i < words.size(); ++i) overrides.push_back(parse_override(words[i]));
    measure(load_scenario(words[0], overrides));
    return EXIT_SUCCESS;
}

}  // namespace

int sc_main(int argc, char** argv) {
    try {
        return run({argv + 1, argv + argc});
    } catch (const std::exception& error) {
        std::cerr << "bound_ratio: " << error.what() << '\n';
        return EXIT_FAILURE;
    }
}

int main(int argc, char** argv) {
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
