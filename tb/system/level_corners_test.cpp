#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "machine_run.h"
#include "random_scenario.h"
#include "scenario/derived_timing.h"
#include "support/rows.h"
#include "support/scenarios.h"
#include "tlm_run.h"

// Coincidences of clocks that random machines hardly ever meet.
namespace metabuffer::test {
namespace {

/// One display, and renderers that each send one pair of one line.
Scenario one_line(int renderers) {
    constexpr int kWidth = 12;  // room for a table of one row
    Scenario scenario = small_scenario(kWidth, 1);
    const PixelImage image(kWidth, 1, Pixel(10, 20, 30, 255, 5));
    for (int r = 0; r < renderers; ++r) {
        add_renderer(scenario, renderer_of({image}, {segment_row({kWidth, 1})}));
    }
    return scenario;
}

/// A renderer whose image, all of one depth, covers two displays of that size, one beside the other.
Renderer across_two_displays(Size display, std::uint32_t z = 5) {
    const PixelImage image(2 * display.width, display.height, Pixel(10, 20, 30, 255, z));
    return renderer_of(
        {image}, {table_row(1, {0, 0}, display, {0, 0}), table_row(2, {display.width, 0}, display, {0, 0})});
}

/// Runs both levels to their ends and compares them.
void compare_levels(const std::vector<LevelRuns>& runs) {
    REQUIRE(simulate_until([&runs] {
        return std::all_of(runs.begin(), runs.end(), [](const auto& run) { return run.finished(); });
    }));
    for (const LevelRuns& run : runs) {
        INFO(describe(run.rtl->scenario()));
        const std::vector<std::string> differences = level_differences(run);
        INFO(first_lines(differences));
        CHECK(differences.empty());
    }
}

TEST_CASE("levels agree where the last frame has been shown while the bus still does something", "[system]") {
    // Page misses are so long that the last frame is shown without most of its pixels. The run ends within a page miss
    // or between two.
    std::vector<LevelRuns> runs;
    for (int page_miss_cycles = 50; page_miss_cycles < 80; ++page_miss_cycles) {
        Scenario scenario = small_scenario(24, 16);
        const PixelImage image(24, 16, Pixel(10, 20, 30, 255, 5));
        scenario.renderers.push_back(renderer_of({image}, {segment_row({24, 16})}));
        scenario.memory.page_words = 4;
        scenario.memory.page_miss_cycles = page_miss_cycles;
        scenario.composer.buffer_pixels = 32;
        scenario.composer.ready_space_pixels = 8;
        scenario.bus.burst_pixels = 8;
        scenario.bus.width_bits = 16;
        runs.emplace_back("machine_" + std::to_string(page_miss_cycles), scenario);
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        CHECK(run.rtl->report().renderers.front().bus.pixels_sent < 24 * 16);
    }
}

TEST_CASE("levels agree where the last frame has been shown while the arbiter still decides", "[system]") {
    // The arbiter takes far longer than a burst of one beat, and a page is opened in no time. A raster that is wider by
    // a pixel makes a run longer by a pixel in each of 31 lines, blank ones included, or by a multiple of that. 31 has
    // no divisor in common with the clocks from burst to burst, so at each clock between two bursts one of the runs
    // ends.
    constexpr int kGrantCycles = 65;
    constexpr int kCyclesBetweenBursts =
        kGrantCycles + 3;  // the beat, and two until its composer may be asked again
    constexpr int kHeight = 16;
    std::vector<LevelRuns> runs;
    for (int wider = 0; wider < kCyclesBetweenBursts + 12; ++wider) {
        Scenario scenario = small_scenario(24 + wider, kHeight);
        const PixelImage image(24, kHeight, Pixel(10, 20, 30, 255, 5));
        scenario.renderers.push_back(renderer_of({image}, {segment_row({24, kHeight})}));
        scenario.memory.page_miss_cycles = 0;
        scenario.memory.page_words = 8;
        scenario.composer.buffer_pixels = 32;
        scenario.composer.ready_space_pixels = 8;
        scenario.bus.burst_pixels = 2;
        scenario.bus.grant_cycles = kGrantCycles;
        runs.emplace_back("machine_" + std::to_string(wider), scenario);
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        CHECK(run.rtl->report().renderers.front().bus.pixels_sent < 24 * kHeight);
    }
}

TEST_CASE("levels agree where beats are on their way while it is not known when their column moves on",
          "[system]") {
    // Read latency and registers on the way: several beats go out before the first one's BUSREADY is back, while the
    // column waits for another renderer's bus. The buffers are full, so each beat depends on a pixel that is still to
    // be used.
    std::vector<LevelRuns> runs;
    for (const StarvationMode mode : {StarvationMode::kStall, StarvationMode::kGlitch}) {
        for (int i = 0; i < 24; ++i) {
            Scenario scenario = small_scenario(24, 16, 2);
            for (int r = 0; r < 3; ++r) {
                add_renderer(scenario, across_two_displays({24, 16}, 5 + static_cast<std::uint32_t>(r)));
            }
            scenario.composer.on_starvation = mode;
            scenario.memory.read_latency_cycles = 1 + i % 4;
            scenario.memory.words_per_cycle = i % 3 == 0 ? 1 : 2;
            scenario.memory.page_words = 32;
            scenario.memory.page_miss_cycles = i % 5;
            scenario.bus.width_bits = 64 * scenario.memory.words_per_cycle;
            scenario.bus.register_stages = i % 3;
            scenario.bus.burst_pixels = 64;
            const int ready_space = in_flight_pixels(scenario.bus, scenario.memory) + i % 7;
            scenario.composer.ready_space_pixels = ready_space;
            scenario.composer.buffer_pixels = ready_space + 10 + i;
            runs.emplace_back("machine_" + std::to_string(runs.size()), scenario);
        }
    }
    compare_levels(runs);
    std::int64_t drops = 0;
    for (const LevelRuns& run : runs) {
        for (const ComposerCounters& composer : run.rtl->report().composers) drops += composer.busready_drops;
    }
    CHECK(drops > 0);
}

TEST_CASE("levels agree on slot tables of the host's, and each row has a slot where one is missing or wrong",
          "[system]") {
    const std::vector<std::vector<int>> slot_tables{{1, 2}, {1, 1, 1, 2}, {2, 2, 1}, {}, {1, 1}};
    std::vector<LevelRuns> runs;
    for (std::size_t i = 0; i < slot_tables.size(); ++i) {
        Scenario scenario = small_scenario(24, 16, 2);
        Renderer renderer = across_two_displays({24, 16});
        renderer.frames.front().slots = slot_tables[i];
        add_renderer(scenario, std::move(renderer));
        scenario.composer.buffer_pixels = 24;
        scenario.composer.ready_space_pixels = 8;
        scenario.bus.burst_pixels = 8;
        runs.emplace_back("machine_" + std::to_string(i), scenario);
    }
    compare_levels(runs);
    const auto report = [&runs](std::size_t i) { return runs[i].rtl->report(); };
    for (std::size_t i = 0; i < slot_tables.size(); ++i) {
        INFO("slot table " << i);
        CHECK(report(i).renderers.front().rejected_slot_tables == (i >= 3 ? 1 : 0));
    }
    // One slot for each row is the first table; the second one is another order of bursts.
    CHECK(report(3).renderers.front().bus.recovered_slots == report(0).renderers.front().bus.recovered_slots);
    CHECK(report(3).core_cycles == report(0).core_cycles);
    CHECK(report(4).core_cycles == report(0).core_cycles);
    CHECK(report(1).renderers.front().bus.recovered_slots != report(0).renderers.front().bus.recovered_slots);
}

TEST_CASE("levels agree where the watchdog checks in the very clock of a link's last pixel", "[system]") {
    // The colour frame's last pixel comes after a vertical sync and 7 lines of blanking, and the depth frame's first
    // one a frame later. So only the pixel at the first check decides whether the second check finds that nothing
    // moved.
    constexpr std::int64_t kFirstLook = 1'380;
    constexpr int kLooks = 36;
    std::vector<LevelRuns> runs;
    for (int i = 0; i < kLooks; ++i) {
        Scenario scenario = one_line(1);
        scenario.watchdog_cycles = kFirstLook + i;
        runs.emplace_back("machine_" + std::to_string(scenario.watchdog_cycles), scenario);
    }
    compare_levels(runs);
    int tripped_at_the_second_look = 0;
    int went_on = 0;
    for (const LevelRuns& run : runs) {
        const bool at_second = run.rtl->report().core_cycles < 3 * run.rtl->scenario().watchdog_cycles &&
                               !run.rtl->report().watchdog.empty();
        (at_second ? tripped_at_the_second_look : went_on) += 1;
    }
    // Otherwise no check would be at the pixel's clock.
    CHECK(tripped_at_the_second_look > 0);
    CHECK(went_on > 0);
}

/// One frame of a renderer, on two displays. The watchdog ends the run first if the bus stands still for 6000 clocks.
Scenario watched_frame() {
    Scenario scenario = small_scenario(24, 16, 2);
    add_renderer(scenario, across_two_displays({24, 16}));
    scenario.composer.buffer_pixels = 64;
    scenario.composer.ready_space_pixels = 32;
    scenario.bus.burst_pixels = 32;
    scenario.bus.width_bits = 512;
    scenario.memory.words_per_cycle = 8;
    scenario.watchdog_cycles = 2'500;  // longer than a blanking
    return scenario;
}

TEST_CASE("levels agree where the watchdog ends a run before a frame, or in a stall whose pixel has not come",
          "[system]") {
    // A refresh stops the bus when the frame is about to begin, or somewhere in it.
    constexpr int kAboutToBegin = 8'190;
    constexpr int kBegun = 8'230;
    std::vector<LevelRuns> runs;
    for (int interval = kAboutToBegin; interval < 8'500; interval += interval < kBegun ? 1 : 30) {
        Scenario scenario = watched_frame();
        scenario.composer.on_starvation = StarvationMode::kStall;
        scenario.memory.refresh_interval_cycles = interval;
        scenario.memory.refresh_cycles = 6'000;
        runs.emplace_back("machine_" + std::to_string(interval), scenario);
    }
    compare_levels(runs);
    int without_frame = 0;
    int stalled = 0;
    for (const LevelRuns& run : runs) {
        CHECK_FALSE(run.rtl->report().watchdog.empty());
        const WindowEvents& events = run.rtl->window_events();
        without_frame += events.at("startframe:0") == "never" ? 1 : 0;
        stalled += events.at("first-starved-pixel") != "never" ? 1 : 0;
    }
    CHECK(without_frame > 0);
    CHECK(stalled > 0);
}

TEST_CASE("levels agree where nothing but a swap happens between two checks of the watchdog", "[system]") {
    // The outputs are slow: they swap long after the last pixel of a raster, and long before the picture has been shown.
    std::vector<LevelRuns> runs;
    for (int i = 0; i < 48; ++i) {
        Scenario scenario = small_scenario(12, 1, 2);
        add_renderer(scenario, across_two_displays({12, 1}));
        scenario.clocks.core_mhz = 100;
        scenario.clocks.dvi_in_mhz = 100;
        scenario.clocks.dvi_out_mhz = 25;
        scenario.watchdog_cycles = 2'000 + 200 * i;
        runs.emplace_back("machine_" + std::to_string(scenario.watchdog_cycles), scenario);
    }
    compare_levels(runs);
    int tripped = 0;
    for (const LevelRuns& run : runs) tripped += run.rtl->report().watchdog.empty() ? 0 : 1;
    // Otherwise every interval would be too short, or long enough without the swap.
    CHECK(tripped > 0);
    CHECK(tripped < static_cast<int>(runs.size()));
}

TEST_CASE("a fault lets one link's clock drift and no other's", "[system][faults]") {
    constexpr int kSlowPpm = -100'000;
    MachineRuns runs;
    for (const int drifting : {-1, 0, 1}) {
        Scenario scenario = one_line(2);
        scenario.pacing = Pacing::kLockstep;
        if (drifting >= 0) {
            Fault drift;
            drift.kind = FaultKind::kDrift;
            drift.renderer = drifting;
            drift.ppm = kSlowPpm;
            scenario.faults.push_back(drift);
        }
        runs.push_back(std::make_unique<MachineRun>("run_" + std::to_string(runs.size()), scenario));
    }
    REQUIRE(run_to_end(runs));
    const auto end_cycle = [&](std::size_t run) { return runs[run]->report().frames.at(0).end_cycle; };
    for (const std::size_t run : {1U, 2U}) {
        INFO("renderer " << run << " drifts");
        // Its pair takes a tenth longer to come, so the frame is composited later.
        CHECK(end_cycle(run) > end_cycle(0) + end_cycle(0) / 20);
        CHECK(runs[run]->report().renderers[run - 1].injected_faults == 1);
        CHECK(runs[run]->report().renderers[2 - run].injected_faults == 0);
    }
}

}  // namespace
}  // namespace metabuffer::test
