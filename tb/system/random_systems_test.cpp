#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <string>

#include "datapath/arbitration/arbitration_table.h"
#include "machine_checks.h"
#include "machine_run.h"
#include "random_batches.h"
#include "random_scenario.h"
#include "scenario/fault_kinds.h"
#include "scenario/names.h"
#include "support/trace_switch.h"

namespace metabuffer::test::random_systems_test {

namespace {

void run_and_check(const std::vector<std::uint64_t>& seeds) {
    MachineRuns runs;
    TraceSwitch trace;
    for (const std::uint64_t seed : seeds) {
        runs.push_back(
            std::make_unique<MachineRun>("machine_" + std::to_string(seed), random_scenario(seed)));
        trace.add(runs.back()->machine());
    }
    const bool ended = run_to_end(runs);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        INFO("METABUFFER_SEED=" << seeds[i] << " replays this machine alone");
        INFO(describe(runs[i]->scenario()));
        std::string waiting;
        for (const std::string& finding : runs[i]->report().watchdog) waiting += finding + "\n";
        INFO(waiting);
        CHECK((ended || runs[i]->finished()));
        check_run(*runs[i]);
    }
}

const bool kRegistered = register_random_batches("random systems", run_and_check, " --plain");

}  // namespace

TEST_CASE("random systems that once failed", "[system][random]") {
    run_and_check({
        // An output framebuffer went to sleep with the answer to its swap between two registers.
        40304,
        60672,
    });
}

TEST_CASE("a machine does the same each time and beside others", "[system]") {
    REQUIRE(kRegistered);
    MachineRuns runs;
    for (const std::uint64_t seed : {7U, 7U, 11U, 11U, 11U}) {
        runs.push_back(
            std::make_unique<MachineRun>("machine_" + std::to_string(runs.size()), random_scenario(seed)));
    }
    REQUIRE(run_to_end(runs));
    CHECK(report_json(runs[0]->report()) == report_json(runs[1]->report()));
    CHECK(report_json(runs[2]->report()) == report_json(runs[3]->report()));
    CHECK(report_json(runs[2]->report()) == report_json(runs[4]->report()));
    CHECK(report_json(runs[0]->report()) != report_json(runs[2]->report()));
}

TEST_CASE("random scenarios cover what a scenario may be", "[system]") {
    // Each kind of row defect, fault and policy occurs among the seeds that the batches run.
    std::array<int, kRowDefectCount> defects{};
    std::map<FaultKind, int> faults;
    for (const FaultTraits& traits : kFaultKinds) {
        if (traits.location == FaultLocation::kFrame) faults[traits.value] = 0;
    }
    std::array<int, kArbitrationTable.size()> arbitrations{};
    for (std::uint64_t seed = 1; seed <= kBatches * kMachinesPerBatch; ++seed) {
        const Scenario scenario = random_scenario(seed);
        ++arbitrations[static_cast<std::size_t>(scenario.bus.arbitration)];
        for (const Fault& fault : scenario.faults) ++faults.at(fault.kind);
        for (const Renderer& renderer : scenario.renderers) {
            for (const RendererFrame& frame : renderer.frames) {
                const ValidatedTable table = validate_table(frame.table, scenario.limits(renderer));
                defects[0] += static_cast<int>(table.rows.size());
                for (const RejectedRow& row : table.rejected) ++defects[static_cast<std::size_t>(row.defect)];
            }
        }
    }
    CHECK(*std::min_element(defects.begin(), defects.end()) > 0);
    for (const auto& [kind, count] : faults) {
        INFO(to_string(kind));
        CHECK(count > 0);
    }
    CHECK(*std::min_element(arbitrations.begin(), arbitrations.end()) > 0);
}

}  // namespace metabuffer::test::random_systems_test
