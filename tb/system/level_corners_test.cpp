#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "machine_run.h"
#include "random_scenario.h"
#include "scenario/derived_timing.h"
#include "support/images.h"
#include "support/rows.h"
#include "support/scenarios.h"
#include "tlm_run.h"

// Coincidences of clocks that random machines hardly ever meet.
namespace metabuffer::test::level_corners_test {
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
    REQUIRE(run_to_end(runs));
    for (const LevelRuns& run : runs) check_levels(run);
}

/// The last frame is shown without most of its pixels, since pages are opened so slowly.
Scenario slow_pages(int page_miss_cycles) {
    Scenario scenario = small_scenario(24, 16);
    const PixelImage image(24, 16, Pixel(10, 20, 30, 255, 5));
    scenario.renderers.push_back(renderer_of({image}, {segment_row({24, 16})}));
    scenario.memory.page_words = 4;
    scenario.memory.page_miss_cycles = page_miss_cycles;
    scenario.composer.buffer_pixels = 32;
    scenario.composer.ready_space_pixels = 8;
    scenario.bus.burst_pixels = 8;
    scenario.bus.width_bits = 16;
    return scenario;
}

TEST_CASE("levels agree where the last frame has been shown while the bus still does something", "[system]") {
    // The run ends within a page miss or between two.
    std::vector<LevelRuns> runs;
    for (int page_miss_cycles = 50; page_miss_cycles < 80; ++page_miss_cycles) {
        runs.emplace_back("machine_" + std::to_string(page_miss_cycles), slow_pages(page_miss_cycles));
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        CHECK(run.rtl->report().renderers.front().bus.pixels_sent < 24 * 16);
    }
}

TEST_CASE("levels agree where the last frame has been shown sooner than it has been composited", "[system]") {
    Scenario scenario = slow_pages(80);
    scenario.displays.supersample = 4;
    scenario.clocks.dvi_out_mhz = 400;
    std::vector<LevelRuns> runs;
    runs.emplace_back("machine", scenario);
    compare_levels(runs);
    const RunReport& report = runs.front().rtl->report();
    const FrameRecord& frame = report.frames.at(0);
    CHECK(report.core_cycles - frame.end_cycle < frame.end_cycle - frame.start_cycle);
    CHECK(report.renderers.front().bus.pixels_sent < 24 * 16);
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

TEST_CASE("levels agree where a block of the link's words is longer than the blanking before a frame",
          "[system]") {
    // The whole image is one block. The bus is still slow with one pair while the link writes the next.
    constexpr Size kImage{40, 22};
    Scenario scenario = small_scenario(kImage.width, kImage.height);
    add_renderer(scenario, renderer_of({noise_image(1, kImage.width, kImage.height),
                                        noise_image(2, kImage.width, kImage.height)},
                                       {segment_row(kImage)}));
    scenario.frames = 2;
    scenario.clocks.dvi_in_mhz = 50;
    scenario.composer.on_starvation = StarvationMode::kStall;
    scenario.bus.burst_pixels = 2;
    scenario.bus.grant_cycles = 30;
    scenario.memory.ports = MemoryPorts::kShared;
    scenario.memory.words_per_cycle = 8;
    scenario.memory.write_block_words = scenario.memory.page_words = kImage.width * kImage.height;
    scenario.memory.page_miss_cycles = 4;
    const DviTiming timing = scenario.renderers.front().timing();
    REQUIRE(scenario.memory.write_block_words > (DviTiming::kVerticalBackLines + 1) * timing.line_clocks());
    check_scenario(scenario);
    std::vector<LevelRuns> runs;
    runs.emplace_back("machine", scenario);
    compare_levels(runs);
    CHECK(runs.front().rtl->report().renderers.front().bus.write_cycles > 0);
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

TEST_CASE("levels agree where the watchdog ends a run while slots are lost", "[system]") {
    // The buffer has room again when the first frame is swapped, which the slow output does after the second check.
    std::vector<LevelRuns> runs;
    for (const int interval : {6'000, 6'050, 7'000}) {
        Scenario scenario = small_scenario(24, 4);
        const PixelImage image(24, 4, Pixel(10, 20, 30, 255, 5));
        add_renderer(scenario, renderer_of({image}, {segment_row({24, 4})}));
        scenario.pacing = Pacing::kFreeRunning;
        scenario.frames = 2;
        scenario.bus.arbitration = Arbitration::kSlotAllocation;
        scenario.bus.burst_pixels = 4;
        scenario.composer.buffer_pixels = 32;
        scenario.composer.ready_space_pixels = 4;
        scenario.clocks.dvi_out_mhz = 5;
        scenario.watchdog_cycles = interval;
        runs.emplace_back("machine_" + std::to_string(interval), scenario);
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        const RunReport& report = run.rtl->report();
        CHECK(report.core_cycles == 2 * run.rtl->scenario().watchdog_cycles + 1);
        CHECK_FALSE(report.watchdog.empty());
        CHECK(report.total_bus().lost_cycles > 1'000);
    }
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

TEST_CASE("levels agree where the watchdog ends a run in which a bus polls", "[system]") {
    // The other renderer's second pair does not come. A buffer of one frame takes no pixel of the third one, and a
    // larger one takes it whole, but then no fourth table.
    constexpr int kOneFrame = 12;
    std::vector<LevelRuns> runs;
    for (const int buffer_pixels : {kOneFrame, 64}) {
        Scenario scenario = one_line(2);
        scenario.frames = 4;
        for (Renderer& renderer : scenario.renderers) renderer.frames.resize(4, renderer.frames.front());
        scenario.composer.buffer_pixels = buffer_pixels;
        scenario.composer.ready_space_pixels = 4;
        scenario.link_timeout_pairs = 1'000;
        scenario.watchdog_cycles = 2'500;  // longer than a blanking
        Fault silence;
        silence.kind = FaultKind::kDelay;
        silence.renderer = 1;
        silence.pair = 1;
        silence.delay_pairs = 100;
        runs.emplace_back("machine_" + std::to_string(buffer_pixels), with_fault(scenario, silence));
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        const RunReport& report = run.rtl->report();
        REQUIRE_FALSE(report.watchdog.empty());
        const std::string wire =
            run.rtl->scenario().composer.buffer_pixels == kOneFrame ? "BUSREADY" : "TABLEREADY";
        CHECK(std::any_of(report.watchdog.begin(), report.watchdog.end(), [&wire](const std::string& line) {
            return line.find("input_framebuffer_1") != std::string::npos &&
                   line.find(wire) != std::string::npos;
        }));
        CHECK(report.renderers.front().bus.poll_cycles > run.rtl->scenario().watchdog_cycles / 2);
    }
}

TEST_CASE("levels agree where the watchdog checks in the clock of a frame-start beat", "[system]") {
    // The second pair does not come, so the first one's table goes out again at the timeout of the link, after silence.
    constexpr std::int64_t kFrameStart = 10'026;
    constexpr int kTableCycles = 1 + 128 / 16;
    const auto frame_ends = [](std::int64_t interval) { return 2 * interval > kFrameStart; };
    std::vector<LevelRuns> runs;
    for (std::int64_t interval = kFrameStart / 2 - 1; interval <= kFrameStart / 2 + 1; ++interval) {
        Scenario scenario = one_line(1);
        scenario.frames = 2;
        scenario.renderers.front().frames.resize(2, scenario.renderers.front().frames.front());
        scenario.bus.width_bits = 16;
        scenario.clocks.dvi_in_mhz =
            101;  // else the beat's clock would be odd, and never that of a second check
        scenario.watchdog_cycles = interval;
        Fault silence;
        silence.kind = FaultKind::kDelay;
        silence.pair = 1;
        silence.delay_pairs = 100;
        runs.emplace_back("machine_" + std::to_string(interval), with_fault(scenario, silence));
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        const std::int64_t interval = run.rtl->scenario().watchdog_cycles;
        INFO("checks every " << interval);
        const RunReport& report = run.rtl->report();
        CHECK(report.watchdog.empty() == frame_ends(interval));
        const std::int64_t of_second =
            frame_ends(interval) ? kTableCycles : std::max<std::int64_t>(0, 2 * interval + 1 - kFrameStart);
        CHECK(report.total_bus().table_cycles == kTableCycles + of_second);
    }
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

TEST_CASE("levels agree that the watchdog does not set what is sent off against what is taken", "[system]") {
    // All that happens before the first check: a table of three clocks and its pixels are sent, and a raster is taken.
    constexpr int kTableCycles = 3;
    constexpr int kRasterPixels = 12;
    constexpr std::int64_t kInterval = 4'500;  // between the raster and its swap
    const auto with_segment = [](int pixels) {
        Scenario scenario = one_line(0);
        scenario.pacing = Pacing::kFreeRunning;
        scenario.clocks = {100, 100, 25};
        scenario.watchdog_cycles = kInterval;
        add_renderer(scenario, renderer_of({PixelImage(kRasterPixels, 1)}, {segment_row({pixels, 1})}));
        return scenario;
    };
    // No raster yet: it waits for the second renderer, whose image is larger.
    Scenario no_raster = with_segment(kTableCycles);
    add_renderer(no_raster, renderer_of({PixelImage(kRasterPixels, 18)}, {segment_row({kRasterPixels, 1})}));
    const Scenario raster = with_segment(kRasterPixels - kTableCycles);
    // Link pixels count, too: two for each pixel of the image.
    Scenario link = raster;
    link.pacing = Pacing::kLockstep;
    std::vector<LevelRuns> runs;
    for (const Scenario& scenario : {no_raster, raster, link}) {
        runs.emplace_back("machine_" + std::to_string(runs.size()), scenario);
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        const RunReport& report = run.rtl->report();
        REQUIRE(report.watchdog.empty());
        CHECK(report.core_cycles > kInterval);
        CHECK(report.renderers.front().bus.table_cycles == kTableCycles);
    }
    CHECK(runs[0].rtl->report().frames.front().start_cycle > kInterval);
    for (const LevelRuns* run : {&runs[1], &runs[2]}) {
        CHECK(run->rtl->report().frames.front().end_cycle < kInterval);
        CHECK(run->rtl->report().frames.front().swap_cycle > kInterval);
    }
}

TEST_CASE("levels agree where the watchdog checks in the very clock of a raster's last pixel", "[system]") {
    // The slower output swaps after all these checks. The other one swaps behind the first check, with nothing else
    // but the raster's last pixels, and has not shown the frame by the third one.
    constexpr double kSlowMhz = 5.0;
    constexpr std::int64_t kLastPixel = 3'592;  // is read by the output framebuffer
    std::vector<LevelRuns> runs;
    for (const double dvi_out_mhz : {kSlowMhz, 12.5}) {
        for (std::int64_t interval = kLastPixel - 1; interval <= kLastPixel + 1; ++interval) {
            Scenario scenario = small_scenario(12, 1, 2);
            add_renderer(scenario, across_two_displays({12, 1}));
            scenario.clocks.dvi_out_mhz = dvi_out_mhz;
            scenario.watchdog_cycles = interval;
            runs.emplace_back("machine_" + std::to_string(runs.size()), scenario);
        }
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) {
        const Scenario& scenario = run.rtl->scenario();
        INFO("output of " << scenario.clocks.dvi_out_mhz << " MHz, checks every "
                          << scenario.watchdog_cycles);
        // A check sees what has happened before its clock.
        const bool moved = scenario.clocks.dvi_out_mhz > kSlowMhz || scenario.watchdog_cycles <= kLastPixel;
        CHECK(run.rtl->report().core_cycles == (moved ? 3 : 2) * scenario.watchdog_cycles + 1);
        CHECK_FALSE(run.rtl->report().watchdog.empty());
    }
}

TEST_CASE("levels agree on a raster so wide that a block's rows are more than what is composited at a time",
          "[system]") {
    Scenario scenario = small_scenario(1'100, 2);
    scenario.displays.supersample = 4;
    add_renderer(scenario, renderer_of({noise_image(1, 24, 2)}, {segment_row({24, 2}, {4'000, 1}, 3)}));
    std::vector<LevelRuns> runs;
    runs.emplace_back("machine", scenario);
    compare_levels(runs);
}

TEST_CASE("levels agree where as many pixels move on a link as elsewhere between two checks of the watchdog",
          "[system]") {
    // Bus, pipeline and display have the first frame while the link has the second pair. At one of these intervals, the
    // sums are the same.
    std::vector<LevelRuns> runs;
    for (int interval = 2'861; interval <= 2'867; ++interval) {
        Scenario scenario = small_scenario(24, 2);
        const PixelImage image(24, 4, Pixel(10, 20, 30, 255, 5));
        add_renderer(scenario, renderer_of({image}, {segment_row({24, 2})}));
        scenario.pacing = Pacing::kLockstep;
        scenario.frames = 2;
        scenario.watchdog_cycles = interval;
        runs.emplace_back("machine_" + std::to_string(interval), scenario);
    }
    compare_levels(runs);
    for (const LevelRuns& run : runs) CHECK(run.rtl->report().watchdog.empty());
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
    // Their clocks have stopped, the one that drifts too.
    const sc_core::sc_time chunk(100.0, sc_core::SC_US);
    sc_core::sc_start(chunk);  // what was left of their last edges
    const sc_dt::uint64 deltas = sc_core::sc_delta_count();
    sc_core::sc_start(chunk);
    CHECK(sc_core::sc_delta_count() == deltas);
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
}  // namespace metabuffer::test::level_corners_test
