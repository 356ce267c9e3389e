#include "shrink.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "random_scenario.h"
#include "report/report.h"
#include "scenario/scenario_loader.h"
#include "support/random_seed.h"

namespace metabuffer::test::shrink_test {

namespace {

constexpr int kManyRuns = 5000;

std::size_t table_rows(const Scenario& scenario) {
    std::size_t rows = 0;
    for (const Renderer& renderer : scenario.renderers) {
        for (const RendererFrame& frame : renderer.frames) rows += frame.table.size();
    }
    return rows;
}

/// Some row of that Dmultiple or more.
bool has_multiple(const Scenario& scenario, int multiple) {
    for (const Renderer& renderer : scenario.renderers) {
        for (const RendererFrame& frame : renderer.frames) {
            for (const ViewportRow& row : validate_table(frame.table, scenario.limits(renderer)).rows) {
                if (row.dmultiple >= multiple) return true;
            }
        }
    }
    return false;
}

/// The first seed from `seed` on whose machine meets the condition.
template <typename Condition>
Scenario random_scenario_with(std::uint64_t seed, Condition condition) {
    while (true) {
        Scenario scenario = random_level_scenario(seed++);
        if (condition(scenario)) return scenario;
    }
}

}  // namespace

TEST_CASE("shrink: every step is legal and another scenario", "[shrink]") {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        INFO("seed " << seed);
        const Scenario scenario = random_level_scenario(seed);
        const std::vector<Reduction> steps = reductions(scenario);
        CHECK_FALSE(steps.empty());
        for (const Reduction& step : steps) {
            INFO(step.what);
            CHECK_NOTHROW(check_scenario(step.scenario));
        }
    }
}

TEST_CASE("shrink: what always fails becomes one pixel of one renderer with all settings at their defaults",
          "[shrink]") {
    for (const std::uint64_t seed : {3U, 4U, 5U}) {
        INFO("seed " << seed);
        const Shrunk shrunk = shrink(
            random_level_scenario(seed), [](const Scenario&) { return true; }, kManyRuns);
        const Scenario& scenario = shrunk.scenario;
        CHECK(shrunk.at_its_smallest);
        CHECK(scenario.frames == 1);
        CHECK(scenario.renderers.size() == 1);
        CHECK(scenario.renderers[0].images.size() == 1);
        CHECK(scenario.renderers[0].image_height_pixels == 1);
        CHECK(scenario.displays.count() == 1);
        CHECK(scenario.displays.raster_width_pixels() == 1);
        CHECK(scenario.displays.raster_height_pixels() == 1);
        CHECK(table_rows(scenario) == 0);
        CHECK(scenario.faults.empty());
        const Scenario defaults;
        CHECK(scenario.clocks.core_mhz == defaults.clocks.core_mhz);
        CHECK(scenario.bus.width_bits == defaults.bus.width_bits);
        CHECK(scenario.bus.burst_pixels == defaults.bus.burst_pixels);
        CHECK(scenario.composer.buffer_pixels == defaults.composer.buffer_pixels);
        CHECK(scenario.composer.ready_space_pixels == defaults.composer.ready_space_pixels);
        CHECK(scenario.composition == defaults.composition);
        CHECK(scenario.depth_format == defaults.depth_format);
    }
}

TEST_CASE("shrink: what the failure needs stays and the rest goes", "[shrink]") {
    const auto fails = [](const Scenario& scenario) {
        return has_multiple(scenario, 3) && scenario.frames >= 2 && scenario.bus.width_bits == 16;
    };
    const Scenario scenario = random_scenario_with(1, fails);
    INFO(describe(scenario));
    const Shrunk shrunk = shrink(scenario, fails, kManyRuns);
    INFO(describe(shrunk.scenario));
    CHECK(fails(shrunk.scenario));
    CHECK(shrunk.scenario.frames == 2);
    CHECK(table_rows(shrunk.scenario) == 1);
    CHECK(shrunk.scenario.renderers.size() == 1);
    CHECK(shrunk.scenario.displays.count() == 1);
    CHECK(shrunk.scenario.renderers[0].frames.back().table[0].dmultiple == 3);
    CHECK(shrunk.scenario.bus.width_bits == 16);
    CHECK(shrunk.scenario.memory.words_per_cycle == Scenario{}.memory.words_per_cycle);
    CHECK(shrunk.steps.size() > 5);
}

TEST_CASE("shrink: faults keep to their renderer and display while others go", "[shrink]") {
    Scenario scenario = random_scenario_with(1, [](const Scenario& s) {
        return s.renderers.size() == 3 && s.displays.columns == 3 && s.displays.rows == 2 && s.faults.empty();
    });
    Fault fault;
    fault.kind = FaultKind::kBusreadyLow;
    fault.renderer = 1;
    fault.display = 5;  // in the middle of the lower row
    scenario.faults.push_back(fault);
    const std::string name = scenario.renderers[1].name;
    const auto fails = [&](const Scenario& s) {
        return !s.faults.empty() && s.renderers[static_cast<std::size_t>(s.faults[0].renderer)].name == name;
    };
    const Shrunk shrunk = shrink(scenario, fails, kManyRuns);
    REQUIRE(shrunk.scenario.faults.size() == 1);
    CHECK(shrunk.scenario.renderers.size() == 1);
    CHECK(shrunk.scenario.renderers[0].name == name);
    CHECK(shrunk.scenario.faults[0].renderer == 0);
    CHECK(shrunk.scenario.faults[0].display == 1);
}

TEST_CASE("shrink: it ends with its budget and does the same each time", "[shrink]") {
    const Scenario scenario = random_level_scenario(6);
    int tried = 0;
    const Shrunk cut = shrink(
        scenario, [&tried](const Scenario&) { return ++tried % 3 == 0; }, 20);
    CHECK(tried == 20);
    CHECK(cut.runs == 20);
    CHECK_FALSE(cut.at_its_smallest);
    const auto fails = [](const Scenario& s) { return s.displays.raster_width_pixels() > 2; };
    const Shrunk first = shrink(scenario, fails, kManyRuns);
    const Shrunk second = shrink(scenario, fails, kManyRuns);
    CHECK(first.steps == second.steps);
    CHECK(describe(first.scenario) == describe(second.scenario));
    const Shrunk nothing = shrink(
        scenario, [](const Scenario&) { return false; }, kManyRuns);
    CHECK(nothing.steps.empty());
    CHECK(nothing.at_its_smallest);
}

}  // namespace metabuffer::test::shrink_test
