#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "machine_run.h"
#include "random_scenario.h"
#include "report/report.h"

namespace metabuffer::test::clock_gating_test {

namespace {

constexpr std::uint64_t kSeedsPerCase = 9;

/// Each machine twice, side by side, with and without gating: the same clocks, counters and pictures.
void compare_gated_machines(std::uint64_t first_seed) {
    MachineRuns runs;
    for (std::uint64_t seed = first_seed; seed < first_seed + kSeedsPerCase; ++seed) {
        const std::string number = std::to_string(seed);
        runs.push_back(
            std::make_unique<MachineRun>("gated_" + number, random_scenario(seed), rtl::ClockGating::kOn));
        runs.push_back(
            std::make_unique<MachineRun>("ungated_" + number, random_scenario(seed), rtl::ClockGating::kOff));
    }
    REQUIRE(run_to_end(runs));
    for (std::size_t i = 0; i < runs.size(); i += 2) {
        const MachineRun& gated = *runs[i];
        const MachineRun& ungated = *runs[i + 1];
        INFO("seed " << first_seed + i / 2 << ": " << describe(gated.scenario()));
        CHECK(report_json(gated.report()) == report_json(ungated.report()));
        for (int frame = 0; frame < gated.scenario().frames; ++frame) {
            for (int display = 1; display <= gated.scenario().displays.count(); ++display) {
                const ColourImage* one = gated.picture(frame, display);
                const ColourImage* other = ungated.picture(frame, display);
                REQUIRE((one != nullptr && other != nullptr));
                CHECK(*one == *other);
            }
        }
    }
}

}  // namespace

TEST_CASE("clock gating changes neither clocks nor counters nor pictures (seeds 1001 on)", "[system][slow]") {
    compare_gated_machines(1001);
}

// With seed 178 a stalled column holds a STARTFRAME, which a gated composer once missed in its sleep.
TEST_CASE("clock gating changes neither clocks nor counters nor pictures (seeds 170 on)",
          "[system][repeat]") {
    compare_gated_machines(170);
}

TEST_CASE("clock gating changes neither clocks nor counters nor pictures (seeds 2001 on)", "[system][slow]") {
    compare_gated_machines(2001);
}

TEST_CASE("clock gating changes neither clocks nor counters nor pictures (seeds 3001 on)", "[system][slow]") {
    compare_gated_machines(3001);
}

}  // namespace metabuffer::test::clock_gating_test
