#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "machine_checks.h"
#include "machine_run.h"
#include "scenario/scenario_loader.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

// Machines made for one goal of the functional coverage each, which random machines hardly ever reach. They pass the
// same checks as any other.

namespace metabuffer::test::coverage_holes_test {

namespace {

constexpr int kImageWidth = 24;
constexpr int kImageHeight = 10;

/// One renderer and one display, with that table for every pair.
Scenario one_renderer(const std::string& name, int frames, const ViewportTable& table) {
    Random random(5);
    Scenario scenario = with_renderer(
        small_scenario(20, 12), renderer_of({noise_image(random, kImageWidth, kImageHeight, 0xFF)}, table));
    scenario.name = name;
    scenario.frames = frames;
    check_scenario(scenario);
    return scenario;
}

const ViewportRow kWholeImage{1, 0, 0, 20, 10, 0, 0, 1};

MachineRuns run(std::vector<Scenario> scenarios) {
    MachineRuns runs;
    for (Scenario& scenario : scenarios) {
        std::string name = scenario.name;
        runs.push_back(std::make_unique<MachineRun>(name, std::move(scenario)));
    }
    REQUIRE(run_to_end(runs));
    return runs;
}

}  // namespace

TEST_CASE("coverage: the largest Dmultiple fills a raster from one source pixel", "[system][coverage]") {
    const MachineRuns runs = run({one_renderer("largest_multiple", 2, {{1, 3, 4, 1, 1, -100, -240, 255}})});
    check_run(*runs[0]);
    const ColourImage* picture = runs[0]->picture(1, 1);
    REQUIRE(picture != nullptr);
    const std::uint32_t first = picture->values.front();
    CHECK(std::all_of(picture->values.begin(), picture->values.end(),
                      [first](std::uint32_t value) { return value == first; }));
    CHECK(first == runs[0]->scenario().renderers[0].images[0]->pixels().at(3, 4).rgb());
}

TEST_CASE("coverage: rows that leave the raster at the top and at the bottom are dropped",
          "[system][coverage]") {
    const MachineRuns runs = run({
        one_renderer("above", 1, {{1, 0, 0, 4, 4, 0, -2, 2}}),     // its first source row ends at line 0
        one_renderer("below", 1, {{1, 0, 0, 4, 4, 0, 6, 2}}),      // its last source row begins at line 12
        one_renderer("last_line", 1, {{1, 0, 0, 4, 4, 0, 5, 2}}),  // its last source row begins at line 11
    });
    for (const auto& machine : runs) check_run(*machine);
    const auto destination = static_cast<std::size_t>(RowDefect::kDestination);
    CHECK(runs[0]->report().renderers[0].rejected_rows[destination] == 1);
    CHECK(runs[1]->report().renderers[0].rejected_rows[destination] == 1);
    CHECK(runs[2]->report().total_rejected_rows() == 0);
}

TEST_CASE(
    "coverage: a row whose end does not fit 16 bits is dropped and not taken for one that ends in the image",
    "[system][coverage]") {
    // Cut to 16 bits, each end would lie in the image or on the raster; a valid row of the same display follows it.
    const MachineRuns runs = run({
        one_renderer("source_x", 1, {{1, 65535, 0, 5, 4, 0, 0, 1}, kWholeImage}),
        one_renderer("source_y", 1, {{1, 0, 65535, 4, 5, 0, 0, 1}, kWholeImage}),
        one_renderer("destination_x", 1, {{1, 0, 0, 10, 4, 32767, 0, 1}, kWholeImage}),
        one_renderer("destination_y", 1, {{1, 0, 0, 4, 10, 0, 32767, 1}, kWholeImage}),
    });
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO(runs[i]->scenario().name);
        check_run(*runs[i]);
        const auto defect = static_cast<std::size_t>(i < 2 ? RowDefect::kSource : RowDefect::kDestination);
        CHECK(runs[i]->report().renderers[0].rejected_rows[defect] == 1);
    }
}

TEST_CASE("coverage: an image too narrow for the slot table that the policy has is sent a shorter one",
          "[system][coverage]") {
    constexpr int kNarrowest = 17;  // for a table of two rows
    Scenario scenario = small_scenario(160, 16, 2);
    // 17/7 to 16/9 makes 153 to 112 slots, and a bit for each does not fit 29 bytes.
    const ViewportTable table{{1, 0, 0, 17, 2, 0, 0, 7}, {2, 0, 0, 16, 2, 0, 0, 9}};
    scenario.renderers.push_back(renderer_of({noise_image(3, kNarrowest, 4)}, table));
    scenario.name = "narrow";
    check_scenario(scenario);
    const MachineRuns runs = run({std::move(scenario)});
    check_run(*runs[0]);
    CHECK(runs[0]->report().renderers[0].rejected_slot_tables == 0);
    CHECK(runs[0]->report().total_rejected_rows() == 0);
}

TEST_CASE("coverage: a link faster than its bus has the next pair ready before it is asked for",
          "[system][coverage]") {
    Scenario scenario = one_renderer("fast_link", 3, {kWholeImage});
    scenario.clocks.core_mhz = 10.0;
    scenario.bus.width_bits = 16;
    const MachineRuns runs = run({std::move(scenario)});
    check_run(*runs[0]);
    CHECK(runs[0]->report().total_renderer().repeated_frames == 0);
}

TEST_CASE("coverage: a frame is shown again when its pair is lost and a later one is whole",
          "[system][coverage]") {
    Scenario scenario = one_renderer("later_pair", 3, {kWholeImage});
    scenario.clocks.core_mhz = 4.0;  // two pairs come while the bus sends one
    scenario.bus.width_bits = 16;
    Fault fault;
    fault.kind = FaultKind::kMagic;
    fault.pair = 1;
    scenario.faults.push_back(fault);
    check_scenario(scenario);
    const MachineRuns runs = run({std::move(scenario)});
    check_run(*runs[0]);
    const std::vector<FrameRecord>& frames = runs[0]->report().frames;
    REQUIRE(frames.size() == 3);
    CHECK(frames[0].pairs == std::vector<int>{0});
    CHECK(frames[1].pairs == std::vector<int>{0});
    CHECK(frames[2].pairs == std::vector<int>{2});
}

TEST_CASE("coverage: pixels that come when their frame is over are dropped and counted",
          "[system][coverage]") {
    Scenario scenario = one_renderer("late_pixels", 2, {kWholeImage});
    scenario.bus.width_bits = 16;          // four clocks a pixel, and the pipeline takes one
    scenario.composer.buffer_pixels = 40;  // so the frame starts with a few pixels
    check_scenario(scenario);
    const MachineRuns runs = run({std::move(scenario)});
    check_run(*runs[0]);
    const RunReport& report = runs[0]->drained_report();
    CHECK(report.total_starved_pixels() > 0);
    CHECK(report.total_composer().late_pixels > 100);
    CHECK(report.total_bus().pixels_sent == 2 * 200);
}

TEST_CASE("coverage: the watchdog ends a machine that waits and names who waits", "[system][coverage]") {
    Scenario at_once = one_renderer("at_once", 2, {kWholeImage});
    at_once.watchdog_cycles = 20;  // a link's blanking is longer
    Scenario later = one_renderer("later", 3, {kWholeImage});
    later.watchdog_cycles = 4000;
    later.link_timeout_pairs = 1000;
    Fault silence;
    silence.kind = FaultKind::kDelay;
    silence.pair = 1;
    silence.delay_pairs = 100;
    later.faults.push_back(silence);
    check_scenario(later);
    const MachineRuns runs = run({std::move(at_once), std::move(later)});
    CHECK(runs[0]->report().frames_shown() == 0);
    CHECK(runs[1]->report().frames_shown() == 1);
    for (const auto& machine : runs) {
        const std::vector<std::string>& lines = machine->report().watchdog;
        for (const std::string block : {"input_framebuffer_1", "composer_1_1", "output_framebuffer_1"}) {
            INFO(block);
            CHECK(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
                return line.find(block) != std::string::npos;
            }));
        }
    }
}

}  // namespace metabuffer::test::coverage_holes_test
