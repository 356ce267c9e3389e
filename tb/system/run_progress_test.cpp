#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/stored_image.h"
#include "host/errors.h"
#include "rtl/composer.h"
#include "rtl/metabuffer.h"
#include "rtl/run.h"
#include "support/scenarios.h"
#include "tlm/metabuffer.h"
#include "tlm/run.h"

// What a machine reports of a run that is under way.
namespace metabuffer::test::run_progress_test {
namespace {

constexpr int kFrames = 3;

/// Two displays of which only the second has a segment: its column starts and ends later than the other.
Scenario uneven_columns() {
    Scenario scenario = small_scenario(24, 8, 2);
    scenario.frames = kFrames;
    const PixelImage image(24, 8, Pixel(10, 20, 30, 255, 5));
    scenario.renderers.push_back(renderer_of({image}, {segment_row({24, 8}, {}, 1, 2)}));
    return scenario;
}

/// The same, with pages that take longer to open than the buffer holds out.
Scenario starving_columns() {
    Scenario scenario = uneven_columns();
    scenario.memory.page_miss_cycles = 9;
    scenario.memory.page_words = 8;
    scenario.composer.buffer_pixels = 16;
    scenario.composer.ready_space_pixels = 8;
    scenario.bus.burst_pixels = 8;
    return scenario;
}

TEST_CASE("run progress: a frame has ended when every column has ended it and started when the first has",
          "[system]") {
    const Scenario scenario = uneven_columns();
    rtl::Metabuffer machine("machine", scenario);
    machine.on_finished([] { sc_core::sc_pause(); });
    const sc_core::sc_time clock(static_cast<double>(clock_period_picoseconds(scenario.clocks.core_mhz)),
                                 sc_core::SC_PS);
    std::vector<std::vector<std::int64_t>> starts(kFrames);
    std::vector<std::vector<std::int64_t>> ends(kFrames);
    std::int64_t taken = 0;
    CHECK(machine.raster_pixels_to_take() == 24 * 8 * 2 * kFrames);
    sc_core::sc_start(clock / 2);  // checks lie between the clocks
    while (!machine.finished()) {
        for (int frame = 0; frame < kFrames; ++frame) {
            const auto f = static_cast<std::size_t>(frame);
            starts[f].push_back(machine.startframe(frame).cycle);
            ends[f].push_back(machine.frame_end_cycle(frame));
        }
        REQUIRE(machine.raster_pixels_taken() >= taken);
        taken = machine.raster_pixels_taken();
        sc_core::sc_start(clock);
    }
    CHECK(taken == machine.raster_pixels_to_take());

    const RunReport report = machine.report();
    REQUIRE(report.frames.size() == kFrames);
    for (std::size_t f = 0; f < kFrames; ++f) {
        INFO("frame " << f);
        // Not known at first. Then it is what the report has, known in the clock in which it happens.
        const auto known_start = std::count(starts[f].begin(), starts[f].end(), rtl::Composer::kNever);
        CHECK(starts[f].back() == known_start);
        CHECK(starts[f].back() < report.frames[f].start_cycle);
        CHECK(std::all_of(starts[f].begin() + known_start, starts[f].end(),
                          [&](std::int64_t cycle) { return cycle == starts[f].back(); }));
        const auto known_end = std::count(ends[f].begin(), ends[f].end(), rtl::Composer::kNever);
        CHECK(ends[f].back() == known_end);
        CHECK(ends[f].back() == report.frames[f].end_cycle);
        CHECK(std::all_of(ends[f].begin() + known_end, ends[f].end(),
                          [&](std::int64_t cycle) { return cycle == ends[f].back(); }));
    }
}

TEST_CASE("run progress: at every clock both levels have taken as many raster pixels", "[system]") {
    Scenario stalling = starving_columns();
    stalling.composer.on_starvation = StarvationMode::kStall;
    const std::vector<Scenario> scenarios{uneven_columns(), starving_columns(), stalling};
    std::vector<std::unique_ptr<rtl::Metabuffer>> clocked;
    std::vector<std::unique_ptr<tlm::Metabuffer>> transacted;
    for (const Scenario& scenario : scenarios) {
        const std::string number = std::to_string(clocked.size());
        clocked.push_back(std::make_unique<rtl::Metabuffer>(("rtl_" + number).c_str(), scenario));
        transacted.push_back(std::make_unique<tlm::Metabuffer>(("tlm_" + number).c_str(), scenario,
                                                               tlm::Metabuffer::Options{}));
    }
    const sc_core::sc_time clock(
        static_cast<double>(clock_period_picoseconds(scenarios.front().clocks.core_mhz)), sc_core::SC_PS);
    const auto all_finished = [](const auto& machines) {
        return std::all_of(machines.begin(), machines.end(),
                           [](const auto& machine) { return machine->finished(); });
    };
    sc_core::sc_start(clock / 2);  // checks lie between the clocks
    while (!all_finished(clocked) || !all_finished(transacted)) {
        for (std::size_t i = 0; i < scenarios.size(); ++i) {
            INFO("machine " << i << ", clock " << clocked[i]->core_cycle());
            REQUIRE(transacted[i]->raster_pixels_taken() == clocked[i]->raster_pixels_taken());
        }
        sc_core::sc_start(clock);
    }
    for (const auto& machine : transacted) {
        CHECK(machine->raster_pixels_taken() == machine->raster_pixels_to_take());
    }
}

/// What a run at that level says of its progress: shares never fall, and the last one is the whole, at the run's end.
template <typename Options, typename Run>
void check_progress(const Run& run) {
    std::vector<double> shares;
    std::int64_t core_cycle = -1;
    Options options;
    options.on_progress = [&](std::int64_t cycle, double share) {
        core_cycle = cycle;
        shares.push_back(share);
    };
    const RunReport report = run(uneven_columns(), options).report;
    REQUIRE_FALSE(shares.empty());
    CHECK(std::is_sorted(shares.begin(), shares.end()));
    CHECK(shares.front() >= 0.0);
    CHECK(shares.back() == 1.0);
    CHECK(core_cycle == report.core_cycles - 1);
}

TEST_CASE("run progress: level rtl reports the share of the raster pixels that are done", "[system]") {
    check_progress<rtl::RunOptions>(rtl::run);
}

TEST_CASE("run progress: level tlm reports the share of the raster pixels that are done", "[system]") {
    check_progress<tlm::RunOptions>(tlm::run);
}

/// What a level says with each frame that is shown is what its report has of it in the end.
template <typename Options, typename Run>
void check_shown_frames(const Run& run) {
    Scenario scenario = starving_columns();
    scenario.renderers.push_back(scenario.renderers.front());
    struct Said {
        std::vector<int> pairs;
        std::int64_t starved_pixels;
        bool kept;
    };
    std::map<std::pair<std::size_t, std::size_t>, Said> shown;  // by frame and display, from 0
    Options options;
    options.on_frame_shown = [&shown](const DisplayedFrame& of) {
        shown[{static_cast<std::size_t>(of.frame), static_cast<std::size_t>(of.display) - 1}] =
            Said{of.pairs, of.starved_pixels, of.kept};
    };
    const RunReport report = run(scenario, options).report;
    CHECK(shown.size() == kFrames * 2);
    for (const auto& [picture, said] : shown) {
        const auto& [frame, display] = picture;
        INFO("frame " << frame << ", display " << display);
        CHECK(said.pairs == report.frames.at(frame).pairs);
        CHECK(said.starved_pixels == report.frames.at(frame).starved_pixels.at(display));
        CHECK((said.starved_pixels > 0) == (display == 1));
        CHECK_FALSE(said.kept);
    }
}

TEST_CASE("run progress: level rtl says with each frame that is shown which pairs it has and what starved",
          "[system]") {
    check_shown_frames<rtl::RunOptions>(rtl::run);
}

TEST_CASE("run progress: level tlm says with each frame that is shown which pairs it has and what starved",
          "[system]") {
    check_shown_frames<tlm::RunOptions>(tlm::run);
}

TEST_CASE("run progress: without images level tlm runs to its end, reads none and shows none", "[system]") {
    Scenario scenario = uneven_columns();
    for (Renderer& renderer : scenario.renderers) {
        for (auto& image : renderer.images) {
            image = std::make_shared<const StoredImage>(
                ImageSize{image->width_pixels(), image->height_pixels()},
                []() -> PixelImage { throw InputError("it cannot be read"); });
        }
    }
    int shown = 0;
    tlm::RunOptions options;
    options.images = false;
    options.on_frame_shown = [&shown](const DisplayedFrame&) { ++shown; };
    const RunReport report = tlm::run(scenario, options).report;
    CHECK(report.frames.size() == static_cast<std::size_t>(scenario.frames));
    CHECK(shown == 0);
}

}  // namespace
}  // namespace metabuffer::test::run_progress_test
