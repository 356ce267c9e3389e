#include <catch2/catch.hpp>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "machine_coverage.h"
#include "machine_run.h"
#include "random_scenario.h"
#include "report/report.h"
#include "scenario/names.h"

using namespace metabuffer;
using namespace metabuffer::test;

namespace {

std::int64_t sum(const coverage::Coverage& counts, const char* group,
                 std::initializer_list<const char*> bins) {
    std::int64_t result = 0;
    for (const char* bin : bins) result += counts.count(group, bin);
    return result;
}

/// What is counted at the wires is what the machine's own counters say.
void check_counts(const coverage::Coverage& counts, const Scenario& scenario, const RunReport& report) {
    const ComposerCounters composers = report.total_composer();
    const BusCounters bus = report.total_bus();
    std::int64_t pixels = 0;
    for (int count = 1; count <= 8; ++count) {
        pixels += count * counts.count("bus/beat", std::to_string(count) + " at a time");
    }
    CHECK(pixels == bus.pixels_sent);
    CHECK(counts.count("bus/burst", "cut by BUSREADY") == composers.busready_drops);
    CHECK(sum(counts, "bus/burst", {"of one beat", "of several beats"}) +
              counts.count("bus/burst", "cut by BUSREADY") ==
          bus.bursts);
    CHECK(sum(counts, "bus/burst", {"page miss before it"}) <= bus.page_misses);
    CHECK(counts.count("bus/busready-drop", to_string(scenario.bus.arbitration)) == composers.busready_drops);
    CHECK(sum(counts, "starvation/place", {"in the first frame", "in a later frame"}) ==
          composers.starved_pixels);
    CHECK(sum(counts, "composer/late",
              {"behind their last use", "of a frame that is over",
               "behind a replicated pixel's last repetition"}) == composers.late_pixels);
    CHECK(counts.count("composer/replication", "source row read again") == composers.replayed_pixels);
    CHECK((counts.count("composer/buffer", "full") > 0) ==
          (composers.buffer_high_water == scenario.composer.buffer_pixels));
    CHECK(sum(counts, "bus/table", {"empty", "of one row", "of several rows"}) ==
          static_cast<std::int64_t>(scenario.renderers.size()) * scenario.frames);
}

}  // namespace

TEST_CASE("coverage: what is counted at the wires is what the blocks count themselves (seeds 1 to 10)",
          "[system][coverage]") {
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
        check_counts(samplers[i]->counts(), runs[i]->scenario(), runs[i]->drained_report());
    }
}
