#include "report/machine_report.h"

#include <catch2/catch.hpp>

#include "support/scenarios.h"

namespace metabuffer {
namespace {

/// Two renderers, three displays of 8 x 4 raster pixels, a core clock of 10 ns.
Scenario two_renderers() {
    Scenario scenario = test::small_scenario(4, 2, 3);
    scenario.name = "small";
    scenario.displays.supersample = 2;
    scenario.clocks.core_mhz = 100;
    scenario.composer.buffer_pixels = 77;
    scenario.memory.words_per_cycle = 3;
    scenario.bus.width_bits = 48;
    scenario.displays.correction.resize(1);
    scenario.displays.correction.front().display = 2;
    scenario.frames = 5;
    scenario.renderers.resize(2);
    scenario.renderers[0].name = "ball";
    scenario.renderers[1].name = "cube";
    return scenario;
}

TEST_CASE(
    "machine report: pixels of a run, and a frame is shown when the last display shows it, and then once") {
    CHECK(raster_pixels_of_run(two_renderers()) == 8 * 4 * 3 * 5);
    ShownFrames shown(3);
    CHECK(shown.on_all_displays() == 0);
    CHECK(shown.last(1) == -1);
    CHECK_FALSE(shown.add(0, 0));
    CHECK_FALSE(shown.add(2, 0));
    CHECK_FALSE(shown.add(2, 1));
    CHECK(shown.add(1, 0));
    CHECK(shown.on_all_displays() == 1);
    CHECK_FALSE(shown.add(1, 1));
    CHECK(shown.add(0, 1));
    CHECK(shown.on_all_displays() == 2);
    CHECK(shown.last(2) == 1);
}

TEST_CASE("machine report: what the blocks have counted, by renderer, composer, display and frame") {
    const Scenario scenario = two_renderers();
    ShownFrames shown(3);
    for (std::size_t display = 0; display < 3; ++display) {
        for (int frame = 0; frame < 2; ++frame) shown.add(display, frame);
    }
    shown.add(1, 2);
    MachineReport made(scenario, "rtl", shown, 1'000);
    // Frame 0 of two fresh pairs, frame 1 of none, a third one under way.
    const std::vector<FrameSource> sources[2] = {{{0, true, 45'999}, {0, false, 55'999}, {1, true, 500'000}},
                                                 {{0, true, 30'000}, {-1, false, 0}}};
    for (int r = 0; r < 2; ++r) {
        RendererCounters counters;
        counters.repeated_frames = 10 + r;
        made.add_renderer(counters, sources[r]);
        for (int d = 0; d < 3; ++d) {
            ComposerCounters composer;
            composer.late_pixels = 10 * r + d;
            if (d == 1) composer.add_starved_run({1, 0, 0, r});
            composer.add_starved_run({2, 3, 0, 6});
            made.add_composer(composer);
        }
    }
    for (int d = 0; d < 3; ++d) {
        DisplayCounters display;
        display.stalled_cycles = d;
        made.add_display(display);
        made.add_composition(0, 20 - d, 60 + d);
        made.add_composition(1, 100 + d, 160 - d);
    }
    made.add_swap(0, {75'123, false});
    made.add_swap(1, {180'000, true});
    const RunReport report = made.finish({"composer_1_1 waits"});
    CHECK(report.scenario == "small");
    CHECK(report.level == "rtl");
    CHECK(report.core_mhz == 100);
    CHECK(report.core_cycles == 1'000);
    CHECK(report.buffer_pixels == 77);
    CHECK(report.raster_pixels == 8 * 4);
    CHECK(report.memory_words_per_cycle == 3);
    CHECK(report.bus_width_bits == 48);
    CHECK(report.corrected_displays == std::vector<int>{2});
    CHECK_FALSE(report.is_reset);
    REQUIRE(report.cost.has_value());
    CHECK(report.cost->bus_wires == machine_cost(scenario).bus_wires);
    CHECK(report.watchdog == std::vector<std::string>{"composer_1_1 waits"});
    REQUIRE(report.frames.size() == 2);
    CHECK(report.frames[0].index == 0);
    CHECK(report.frames[0].start_cycle == 18);
    CHECK(report.frames[0].end_cycle == 62);
    CHECK(report.frames[0].swap_cycle == 7);  // the core clock that has begun
    CHECK_FALSE(report.frames[0].kept);
    CHECK(report.frames[1].swap_cycle == 18);
    CHECK(report.frames[1].kept);
    CHECK(report.frames[0].starved_pixels == std::vector<std::int64_t>{0, 0, 0});
    CHECK(report.frames[0].wrong_pixels == std::vector<std::int64_t>{0, 0, 0});
    CHECK(report.frames[1].starved_pixels == std::vector<std::int64_t>{0, 3, 0});
    CHECK_FALSE(report.frames[1].wrong_pixels);  // only pictures show them
    REQUIRE(report.rate_limits.has_value());
    CHECK(report.rate_limits->raster_hz == Approx(100e6 / 32));
    CHECK(report.frames[0].latency_cycles == 62 - 4);
    CHECK(report.frames[0].pairs == std::vector<int>{0, 0});
    CHECK(report.frames[1].index == 1);
    CHECK(report.frames[1].start_cycle == 100);
    CHECK(report.frames[1].end_cycle == 160);
    CHECK_FALSE(report.frames[1].latency_cycles);
    CHECK(report.frames[1].pairs == std::vector<int>{0, -1});
    REQUIRE(report.renderers.size() == 2);
    CHECK(report.renderers[0].name == "ball");
    CHECK(report.renderers[1].name == "cube");
    CHECK(report.renderers[1].repeated_frames == 11);
    REQUIRE(report.composers.size() == 6);
    for (int i = 0; i < 6; ++i) {
        const ComposerCounters& composer = report.composers[static_cast<std::size_t>(i)];
        CHECK(composer.renderer == i / 3 + 1);
        CHECK(composer.display == i % 3 + 1);
        CHECK(composer.late_pixels == 10 * (i / 3) + i % 3);
    }
    REQUIRE(report.displays.size() == 3);
    CHECK(report.displays[0].frames_shown == 2);
    CHECK(report.displays[1].frames_shown == 3);
    CHECK(report.displays[2].stalled_cycles == 2);
}

TEST_CASE("machine report: a single pixel that starved is enough for only pictures to show what is wrong") {
    ShownFrames shown(3);
    for (std::size_t display = 0; display < 3; ++display) shown.add(display, 0);
    const Scenario scenario = two_renderers();
    MachineReport made(scenario, "rtl", shown, 1'000);
    made.add_renderer({}, {FrameSource{}});
    ComposerCounters composer;
    composer.add_starved_run({0, 0, 5, 5});
    made.add_composer(composer);
    const RunReport report = made.finish({});
    CHECK(report.frames.at(0).starved_pixels == std::vector<std::int64_t>{1, 0, 0});
    CHECK_FALSE(report.frames.at(0).wrong_pixels);
}

TEST_CASE("machine report: only a run with a fault of kind reset counts as reset") {
    const ShownFrames shown(3);
    Scenario scenario = two_renderers();
    const auto is_reset = [&] { return MachineReport(scenario, "rtl", shown, 1).finish({}).is_reset; };
    CHECK_FALSE(is_reset());
    scenario.faults.resize(1);
    scenario.faults.front().kind = FaultKind::kBusreadyLow;
    CHECK_FALSE(is_reset());
    scenario.faults.front().kind = FaultKind::kReset;
    CHECK(is_reset());
}

}  // namespace
}  // namespace metabuffer
