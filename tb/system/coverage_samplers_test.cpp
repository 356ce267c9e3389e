#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "machine_coverage.h"
#include "machine_run.h"
#include "random_scenario.h"
#include "report/report.h"

namespace metabuffer::test::coverage_samplers_test {

namespace {

/// The counts at the wires must be those of the machine's own counters.
void check_counts(const coverage::MachineGoals& goals, const Scenario& scenario, const RunReport& report) {
    const ComposerCounters composers = report.total_composer();
    const BusCounters bus = report.total_bus();
    std::int64_t pixels = 0;
    for (int count = 1; count <= 8; ++count) pixels += count * goals.bus.beat.pixels(count).count();
    CHECK(pixels == bus.pixels_sent);
    const coverage::BurstGoals& burst = goals.bus.burst;
    CHECK(burst.cut.count() == composers.busready_drops);
    CHECK(burst.of_one_beat.count() + burst.of_several_beats.count() + burst.cut.count() == bus.bursts);
    CHECK(burst.miss_before.count() <= bus.page_misses);
    CHECK(goals.composer.busready_drop.policy(scenario.bus.arbitration).count() == composers.busready_drops);
    const coverage::StarvedPixelGoals& starved = goals.composer.starved;
    CHECK(starved.first_frame.count() + starved.later_frame.count() == composers.starved_pixels);
    const coverage::LatePixelGoals& late = goals.composer.late;
    CHECK(late.behind_last_use.count() + late.frame_is_over.count() + late.behind_last_repetition.count() ==
          composers.late_pixels);
    CHECK(goals.composer.repeated.row_again.count() == composers.replayed_pixels);
    CHECK((goals.composer.buffer.full.count() > 0) ==
          (composers.buffer_high_water == scenario.composer.buffer_pixels));
    const coverage::Ranges& rows = goals.bus.table.rows;
    CHECK(rows(0).count() + rows(1).count() + rows(2).count() ==
          static_cast<std::int64_t>(scenario.renderers.size()) * scenario.frames);
}

}  // namespace

TEST_CASE("coverage: what is counted at the wires is what the blocks count themselves (seeds 1 to 10)",
          "[system][coverage][repeat]") {
    MachineRuns runs;
    std::vector<std::unique_ptr<coverage::MachineCoverage>> samplers;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const std::string name = "machine_" + std::to_string(seed);
        runs.push_back(std::make_unique<MachineRun>(name, random_scenario(seed)));
        samplers.push_back(std::make_unique<coverage::MachineCoverage>(
            (name + "_sampler").c_str(), runs.back()->machine(), runs.back()->scenario()));
    }
    REQUIRE(run_to_end(runs));
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO("METABUFFER_SEED=" << i + 1);
        INFO(describe(runs[i]->scenario()));
        check_counts(samplers[i]->goals(), runs[i]->scenario(), runs[i]->drained_report());
    }
}

TEST_CASE("coverage: each goal has its own name, which a file can hold", "[coverage]") {
    coverage::Coverage counts;
    const coverage::MachineGoals goals(counts);
    std::size_t sum = 0;
    for (const auto& [name, group] : counts.groups()) {
        INFO(name);
        CHECK_FALSE(group.meaning.empty());
        CHECK_FALSE(group.goals.empty());
        CHECK(name.find(coverage::kBehindGroup) == std::string::npos);
        for (const coverage::Goal& goal : group.goals) {
            INFO(goal.name);
            CHECK(goal.count == 0);
            CHECK(goal.name.find('\n') == std::string::npos);
            CHECK(counts.has_goal(coverage::full_name(name, goal.name)));
            ++sum;
        }
    }
    CHECK(sum == counts.goal_count());
    CHECK(sum >= 250);
}

TEST_CASE("coverage: clock ratios are distinguished", "[coverage]") {
    using coverage::ClockRatio;
    // Periods of the core clock and of DVI out.
    CHECK(coverage::clock_ratio(100, 300) == ClockRatio::kSlowerByWholeFactor);
    CHECK(coverage::clock_ratio(100, 250) == ClockRatio::kSlower);
    CHECK(coverage::clock_ratio(100, 100) == ClockRatio::kEqual);
    CHECK(coverage::clock_ratio(250, 100) == ClockRatio::kFaster);
    CHECK(coverage::clock_ratio(300, 100) == ClockRatio::kFasterByWholeFactor);
}

}  // namespace metabuffer::test::coverage_samplers_test
