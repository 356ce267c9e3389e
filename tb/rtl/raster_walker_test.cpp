#include "rtl/raster_walker.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "composer_scenario.h"
#include "painted_raster.h"
#include "support/random_seed.h"
#include "support/traced_values.h"

namespace metabuffer::test::raster_walker_test {
namespace {

using rtl::HeadSegment;
using rtl::PixelUse;
using rtl::RasterWalker;
using Clocks = std::vector<int>;
using Pixels = std::vector<std::int64_t>;

constexpr Size kRaster{kWidth, kHeight};

Scenario walker_scenario(StarvationMode mode, Smoothing smoothing = Smoothing::kReplicate) {
    Scenario scenario = composer_scenario({}, mode);
    scenario.composer.smoothing = smoothing;
    return scenario;
}

/// A walk over the raster, of segments that the test shows to it.
struct WalkerBench {
    Scenario scenario;
    ClockDomain& core;
    Record record;
    sc_core::sc_signal<bool> column_stall, start, running, uses;
    sc_core::sc_signal<HeadSegment> segment;
    sc_core::sc_signal<RasterStep> ahead;
    sc_core::sc_signal<PixelUse> use;
    RasterWalker dut;
    const Recording<bool>& runs;
    const Recording<RasterStep>& steps;          ///< what stands after each edge
    const Recording<RasterStep>& steps_sampled;  ///< what each edge samples
    const Recording<bool>& using_pixels;
    const Recording<PixelUse>& last_uses;

    explicit WalkerBench(ClockedTestbench& bench, Scenario with = walker_scenario(StarvationMode::kGlitch),
                         const std::string& name = "raster_walker")
        : scenario(std::move(with)),
          core(bench.core),
          dut(name.c_str(), scenario, record),
          runs(core.record(running)),
          steps(core.record(ahead)),
          steps_sampled(core.record_sampled(ahead)),
          using_pixels(core.record(uses)),
          last_uses(core.record(use)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.column_stall_i(column_stall);
        dut.start_i(start);
        dut.segment_i(segment);
        dut.running_o(running);
        dut.ahead_o(ahead);
        dut.uses_o(uses);
        dut.use_o(use);
        bench.trace(dut);
    }

    PaintedRaster painted(const std::optional<ViewportRow>& row) const {
        return {row, kRaster, scenario.composer.smoothing};
    }
    /// Edge `clock` is the first that samples the segment.
    void show(int clock, const std::optional<ViewportRow>& row) {
        core.drive(segment, clock,
                   row ? HeadSegment{true, Segment(*row, kWidth, kHeight, scenario.composer.smoothing)}
                       : HeadSegment{});
    }
    /// The edge that composites a frame's position, given the one that sees its start.
    static int edge_of(int start_clock, int position, const std::set<int>& stalled) {
        int clock = start_clock;
        for (int steps_left = position + 1; steps_left > 0; --steps_left) {
            do ++clock;
            while (stalled.count(clock) != 0);
        }
        return clock;
    }
    /// Every output from the edge that sees a frame's start to the one that composites its last position.
    void check_frame(int start_clock, const PaintedRaster& due, const std::set<int>& stalled = {}) const {
        std::int64_t released = due.skipped;
        for (int position = 0; position < kPixels; ++position) {
            const auto n = static_cast<std::size_t>(position);
            const RasterStep next = position + 1 < kPixels ? due.steps[n + 1] : RasterStep{};
            const int last = edge_of(start_clock, position, stalled);
            for (int clock = edge_of(start_clock, position - 1, stalled); clock < last; ++clock) {
                INFO("clock " << clock << ", before position " << position);
                REQUIRE(runs.at(clock));
                REQUIRE(steps.at(clock) == next);
                const PixelUse about = using_pixels.at(clock) ? last_uses.at(clock) : PixelUse{};
                REQUIRE(about.ends_frame == (position + 1 == kPixels));
                const bool smooths = scenario.composer.smoothing == Smoothing::kBilinear;
                // A smoothed column says once more what its last raster columns release.
                if (!smooths) {
                    const std::int64_t now = due.released[n];
                    REQUIRE(about.last_use == (now > released ? now - 1 : Segment::kNoPixel));
                }
                const std::int64_t so_far = std::max(released, about.last_use + 1);
                REQUIRE(so_far == due.released[n]);
            }
            released = due.released[n];
        }
        const int end = edge_of(start_clock, kPixels - 1, stalled);
        CHECK_FALSE(runs.at(end));
        CHECK_FALSE(using_pixels.at(end));
    }
    /// The pixels that are shown in a raster row of a frame.
    Pixels shown_in_row(int start_clock, int y) const {
        Pixels pixels;
        for (int x = 0; x < kWidth; ++x) {
            const int position = y * kWidth + x;
            // Position 0 has been ahead before the start.
            const RasterStep& step = steps.at(start_clock + position - 1);
            pixels.push_back(step.covered ? step.pixel : -1);
        }
        return pixels;
    }
    /// Those of which a frame says the last use, by its position.
    std::vector<std::pair<int, std::int64_t>> last_uses_in_frame(int start_clock) const {
        std::vector<std::pair<int, std::int64_t>> found;
        for (int position = 0; position < kPixels; ++position) {
            const int clock = start_clock + position;
            if (using_pixels.at(clock) && last_uses.at(clock).last_use != Segment::kNoPixel)
                found.emplace_back(position, last_uses.at(clock).last_use);
        }
        return found;
    }
};

TEST_CASE(
    "raster walker: before a frame the first position is ahead, of the segment that is there in the same "
    "clock") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    dut.show(5, segment_row({2, 2}));
    dut.show(30, segment_row({2, 2}, {1, 0}));  // after a pause that the block sleeps through
    dut.show(31, segment_row({2, 1}, {-3, 0}, 3));
    dut.show(32, std::nullopt);
    bench.run_through(40);
    const RasterStep first{0, 0, 0, 0, 0, false, true, false};
    RasterStep cut = first;
    cut.pixel = 1;
    CHECK(dut.steps_sampled.at(4) == RasterStep{});
    for (int clock = 5; clock < 30; ++clock) CHECK(dut.steps_sampled.at(clock) == first);
    CHECK(dut.steps_sampled.at(30) == RasterStep{});  // it does not reach so far to the left
    CHECK(dut.steps_sampled.at(31) == cut);
    CHECK(dut.steps_sampled.at(32) == RasterStep{});
    CHECK(dut.runs.high().empty());
    CHECK(dut.using_pixels.high().empty());
}

TEST_CASE("raster walker: a frame runs from the edge that sees its start to that of its last position") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    dut.show(2, whole_raster());
    bench.core.pulse(dut.start, 20);
    bench.core.pulse(dut.start, 30);  // not in a frame
    bench.core.pulse(dut.start, 20 + kPixels + 1);
    bench.run_through(20 + 3 * kPixels);
    Clocks due = clock_range(20, 20 + kPixels);
    for (const int clock : clock_range(21 + kPixels, 21 + 2 * kPixels)) due.push_back(clock);
    CHECK(dut.runs.high() == due);
    dut.check_frame(20, dut.painted(whole_raster()));
    dut.check_frame(21 + kPixels, dut.painted(whole_raster()));
    REQUIRE(dut.record.frame_spans().size() == 2);
    const int resets = bench.core.reset_clocks();
    CHECK(dut.record.frame_spans()[0].startframe_cycle == 20 + resets);
    CHECK(dut.record.frame_spans()[1].startframe_cycle == 21 + kPixels + resets);
    const std::string bits = std::to_string(1 + rtl::bits_for(dut.scenario.frames));
    CHECK(shows(dut.dut, "frame[" + bits + "]=1"));
}

TEST_CASE("raster walker: a replicated column shows its pixel again until its last repetition") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    dut.show(2, segment_row({3, 1}, {-1, 1}, 3));
    bench.core.pulse(dut.start, 10);
    bench.run_through(50);
    CHECK(dut.shown_in_row(10, 0) == Pixels(kWidth, -1));
    CHECK(dut.shown_in_row(10, 1) == Pixels{0, 0, 1, 1, 1, 2});
    CHECK(dut.shown_in_row(10, 3) == dut.shown_in_row(10, 1));
    // In its last row each pixel is used for the last time in its last column.
    CHECK(dut.last_uses_in_frame(10) == std::vector<std::pair<int, std::int64_t>>{
                                            {3 * kWidth + 1, 0}, {3 * kWidth + 4, 1}, {3 * kWidth + 5, 2}});
}

TEST_CASE("raster walker: a replicated row begins again with its first pixel, which the raster may cut") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    dut.show(2, segment_row({2, 3}, {1, -1}, 2));
    bench.core.pulse(dut.start, 10);
    bench.run_through(50);
    CHECK(dut.shown_in_row(10, 0) == Pixels{-1, 0, 0, 1, 1, -1});
    CHECK(dut.shown_in_row(10, 1) == Pixels{-1, 2, 2, 3, 3, -1});
    CHECK(dut.shown_in_row(10, 2) == dut.shown_in_row(10, 1));
    CHECK(dut.shown_in_row(10, 3) == Pixels{-1, 4, 4, 5, 5, -1});
    Clocks replayed;
    for (int position = 1; position < kPixels; ++position) {
        if (dut.steps.at(10 + position - 1).replayed) replayed.push_back(position);
    }
    CHECK(replayed == clock_range(2 * kWidth + 1, 2 * kWidth + 5));  // only row 2 repeats what was shown
    dut.check_frame(10, dut.painted(segment_row({2, 3}, {1, -1}, 2)));
}

TEST_CASE("raster walker: without a segment nothing is covered, and the last position ends the frame") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    bench.core.pulse(dut.start, 10);
    bench.run_through(50);
    dut.check_frame(10, dut.painted(std::nullopt));
    CHECK(dut.using_pixels.high() == Clocks{10 + kPixels - 1});
    CHECK(dut.last_uses.at(10 + kPixels - 1) == PixelUse{true, Segment::kNoPixel});
    CHECK(dut.steps.at(10 + kPixels - 2).last);
    CHECK_FALSE(dut.steps.at(10 + kPixels - 1).last);
}

TEST_CASE("raster walker: a segment that comes in a frame is not shown before the frame is over") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    const ViewportRow next = segment_row({3, 2}, {}, 2);
    dut.show(2, whole_raster());
    bench.core.pulse(dut.start, 10);
    dut.show(14, next);
    bench.core.pulse(dut.start, 60);
    bench.run_through(100);
    dut.check_frame(10, dut.painted(whole_raster()));
    CHECK(dut.steps.at(10 + kPixels) == dut.painted(next).steps[0]);
    dut.check_frame(60, dut.painted(next));
}

TEST_CASE("raster walker: smoothed, each position names the pixels that are mixed there, and their weights") {
    ClockedTestbench bench;
    WalkerBench dut(bench, walker_scenario(StarvationMode::kGlitch, Smoothing::kBilinear));
    dut.show(2, segment_row({2, 2}, {0, 0}, 2));
    bench.core.pulse(dut.start, 10);
    bench.run_through(50);
    dut.check_frame(10, dut.painted(segment_row({2, 2}, {0, 0}, 2)));
    // In the centre of the four pixels each raster pixel has a quarter of its neighbours.
    const RasterStep centre{0, 2, 1, 64, 64, false, true, true};
    CHECK(dut.steps.at(10 + kWidth) == centre);
    const RasterStep corner{3, 0, 0, 0, 0, false, true, true};
    CHECK(dut.steps.at(10 + 3 * kWidth + 2) == corner);
}

TEST_CASE("raster walker: while COLUMNSTALL is high nothing moves, and a start waits") {
    ClockedTestbench bench;
    WalkerBench stall(bench, walker_scenario(StarvationMode::kStall), "stall");
    WalkerBench glitch(bench, walker_scenario(StarvationMode::kGlitch), "glitch");
    std::set<int> stalled{26, 32, 33, 34, 47, 51};
    for (const int clock : clock_range(10, 24)) stalled.insert(clock);  // an idle walker would sleep
    const ViewportRow row = segment_row({3, 2}, {}, 2);
    for (WalkerBench* dut : {&stall, &glitch}) {
        for (const int clock : stalled) bench.core.pulse(dut->column_stall, clock);
        dut->show(2, whole_raster());
        dut->show(11, row);
    }
    bench.core.drive(stall.start, 10, true);
    bench.core.drive(stall.start, 25, false);
    bench.core.pulse(glitch.start, 12);
    bench.run_through(70);
    CHECK(stall.steps_sampled.at(11) == stall.painted(row).steps[0]);
    CHECK(stall.runs.rises() == Clocks{24});
    stall.check_frame(24, stall.painted(row), stalled);
    CHECK(stall.runs.falls() == Clocks{24 + kPixels + 6});
    glitch.check_frame(12, glitch.painted(row));  // nothing ever raises it there, so it is not read
}

TEST_CASE("raster walker: reset in a frame leaves what power-up leaves") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    dut.show(2, segment_row({3, 2}, {}, 2));
    bench.core.pulse(dut.start, 10);
    bench.core.drive(bench.reset, 18, true);
    bench.core.drive(bench.reset, 22, false);
    bench.core.pulse(dut.start, 20);  // not while reset is high
    bench.core.pulse(dut.start, 40);
    bench.run_through(80);
    CHECK(dut.using_pixels.at(17));  // the first pixel has its last use at position 7
    const RasterStep first = dut.painted(segment_row({3, 2}, {}, 2)).steps[0];
    for (int clock = 18; clock < 40; ++clock) {
        CHECK_FALSE(dut.runs.at(clock));
        CHECK_FALSE(dut.using_pixels.at(clock));
        CHECK(dut.steps.at(clock) == first);
    }
    dut.check_frame(40, dut.painted(segment_row({3, 2}, {}, 2)));
}

TEST_CASE("raster walker: a reset wakes a walker that sleeps, and leaves what power-up leaves") {
    ClockedTestbench bench;
    WalkerBench dut(bench);
    dut.show(2, segment_row({3, 2}, {}, 2));
    bench.core.pulse(dut.start, 10);
    bench.core.drive(bench.reset, 80, true);
    bench.core.drive(bench.reset, 82, false);
    bench.run_through(5);
    const std::vector<std::string> at_power_up = traced_values(dut.dut);
    bench.run_through(79);
    CHECK(traced_values(dut.dut) != at_power_up);
    bench.run_through(82);
    CHECK(traced_values(dut.dut) == at_power_up);
}

TEST_CASE(
    "raster walker: random segments, smoothed or not, are walked as they are painted, through random "
    "stalls") {
    const auto seed = random_seed(2217);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kFrames = 60;
    ClockedTestbench bench;
    std::vector<std::unique_ptr<WalkerBench>> duts;
    struct Walk {
        int start;
        std::optional<ViewportRow> row;
    };
    std::vector<std::vector<Walk>> walks(2);
    std::vector<std::set<int>> stalled(2);
    int end = 0;
    for (std::size_t i = 0; i < 2; ++i) {
        const bool smooths = i == 1;
        duts.push_back(std::make_unique<WalkerBench>(
            bench,
            walker_scenario(StarvationMode::kStall, smooths ? Smoothing::kBilinear : Smoothing::kReplicate),
            smooths ? "smooths" : "replicates"));
        WalkerBench& dut = *duts[i];
        int clock = 3;
        for (int stall = 0; stall < kFrames * 50; ++stall) {
            if (!random.one_in(5)) continue;
            stalled[i].insert(stall);
            bench.core.pulse(dut.column_stall, stall);
        }
        for (int frame = 0; frame < kFrames; ++frame) {
            std::optional<ViewportRow> row;
            if (!random.one_in(6)) {
                row =
                    smooths ? random_smoothed_row(random, kRaster, 7) : random_valid_row(random, kRaster, 7);
            }
            dut.show(clock, row);
            clock += random.one_in(4) ? random.between(0, 20) : 0;
            bench.core.drive(dut.start, clock, true);
            while (stalled[i].count(clock) != 0) ++clock;
            bench.core.drive(dut.start, clock + 1, false);
            walks[i].push_back({clock, row});
            clock = WalkerBench::edge_of(clock, kPixels - 1, stalled[i]) + 1;
        }
        end = std::max(end, clock);
    }
    bench.run_through(end + 5);
    for (std::size_t i = 0; i < 2; ++i) {
        for (const Walk& walk : walks[i]) {
            INFO("frame from clock " << walk.start);
            const PaintedRaster due = duts[i]->painted(walk.row);
            CHECK(duts[i]->steps_sampled.at(walk.start) == due.steps[0]);
            duts[i]->check_frame(walk.start, due, stalled[i]);
        }
    }
}

}  // namespace
}  // namespace metabuffer::test::raster_walker_test
