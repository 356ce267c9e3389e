#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "random_batches.h"
#include "random_scenario.h"
#include "report/report.h"
#include "support/trace_switch.h"
#include "tlm_run.h"

namespace metabuffer::test::levels_test {

namespace {

/// The clocked machine and the transaction-level one of each seed, in one elaboration.
void compare_levels(const std::vector<std::uint64_t>& seeds) {
    std::vector<LevelRuns> runs;
    TraceSwitch trace;
    for (const std::uint64_t seed : seeds) {
        runs.emplace_back("machine_" + std::to_string(seed), random_level_scenario(seed));
        trace.add(runs.back().rtl->machine());
    }
    run_to_end(runs);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        INFO("METABUFFER_SEED=" << seeds[i] << " replays this machine alone");
        check_levels(runs[i]);
    }
}

const bool kRegistered = register_random_batches("levels rtl and tlm agree on machines", compare_levels);

/// What happens in the machines of the batches, summed up.
struct Happenings {
    std::int64_t starved_pixels = 0;
    std::int64_t stalled_cycles = 0;
    std::int64_t late_pixels = 0;
    std::int64_t replayed_pixels = 0;
    std::int64_t busready_drops = 0;
    std::int64_t full_buffers = 0;  ///< composers that held as much as they can
    std::int64_t repeated_frames = 0;
    std::int64_t dropped_frames = 0;
    BusCounters bus;
    std::array<std::int64_t, kRejectCauseCount> rejected_frames{};
    std::array<std::int64_t, kRowDefectCount> rejected_rows{};
    std::int64_t changed_tables = 0;  ///< renderers whose frames lie at different positions

    void add(const Scenario& scenario, const RunReport& report) {
        for (const ComposerCounters& composer : report.composers) {
            starved_pixels += composer.starved_pixels;
            stalled_cycles += composer.stalled_cycles;
            late_pixels += composer.late_pixels;
            replayed_pixels += composer.replayed_pixels;
            busready_drops += composer.busready_drops;
            full_buffers += composer.buffer_high_water == scenario.composer.buffer_pixels ? 1 : 0;
        }
        for (const RendererCounters& renderer : report.renderers) {
            repeated_frames += renderer.repeated_frames;
            dropped_frames += renderer.dropped_frames;
            for (std::size_t n = 0; n < rejected_frames.size(); ++n) {
                rejected_frames[n] += renderer.rejected_frames[n];
            }
            for (std::size_t n = 0; n < rejected_rows.size(); ++n) {
                rejected_rows[n] += renderer.rejected_rows[n];
            }
        }
        const BusCounters total = report.total_bus();
        bus.page_misses += total.page_misses;
        bus.poll_cycles += total.poll_cycles;
        bus.lost_cycles += total.lost_cycles;
        bus.recovered_slots += total.recovered_slots;
        for (const Renderer& renderer : scenario.renderers) {
            changed_tables += std::any_of(renderer.frames.begin(), renderer.frames.end(),
                                          [&renderer](const RendererFrame& frame) {
                                              return frame.table != renderer.frames.front().table;
                                          })
                                  ? 1
                                  : 0;
        }
    }
};

}  // namespace

TEST_CASE("the random machines do all that a machine can do", "[system][random]") {
    REQUIRE(kRegistered);
    TlmRuns runs;
    for (int seed = 1; seed <= kBatches * kMachinesPerBatch; ++seed) {
        runs.push_back(std::make_unique<TlmRun>("machine_" + std::to_string(seed),
                                                random_scenario(static_cast<std::uint64_t>(seed)), false));
    }
    REQUIRE(run_to_end(runs));
    Happenings sum;
    for (const auto& run : runs) sum.add(run->scenario(), run->report());
    CHECK(sum.starved_pixels > 0);
    CHECK(sum.stalled_cycles > 0);
    CHECK(sum.late_pixels > 0);
    CHECK(sum.replayed_pixels > 0);
    CHECK(sum.busready_drops > 0);
    CHECK(sum.full_buffers > 0);
    CHECK(sum.repeated_frames > 0);
    CHECK(sum.dropped_frames > 0);
    CHECK(sum.bus.page_misses > 0);
    CHECK(sum.bus.poll_cycles > 0);
    CHECK(sum.bus.lost_cycles > 0);
    CHECK(sum.bus.recovered_slots > 0);
    CHECK(sum.changed_tables > 0);
    for (int cause = 0; cause < kRejectCauseCount; ++cause) {
        INFO(reject_cause_key(static_cast<RejectCause>(cause)));
        CHECK(sum.rejected_frames[static_cast<std::size_t>(cause)] > 0);
    }
    for (int defect = static_cast<int>(RowDefect::kNone) + 1; defect < kRowDefectCount; ++defect) {
        INFO(row_defect_key(static_cast<RowDefect>(defect)));
        CHECK(sum.rejected_rows[static_cast<std::size_t>(defect)] > 0);
    }
}

}  // namespace metabuffer::test::levels_test
