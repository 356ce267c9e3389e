#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "composer_bench.h"
#include "composer_scenario.h"
#include "expected_report.h"
#include "small_scenario.h"

namespace metabuffer::test {
namespace {

using rtl::PipePixel;

constexpr int kPageMiss = 3;

ComposerSizes roomy() {
    ComposerSizes sizes;
    sizes.buffer = 32;
    return sizes;
}

Scenario lossy_scenario(const ComposerSizes& sizes = roomy(), StarvationMode mode = StarvationMode::kGlitch) {
    Scenario scenario = composer_scenario(sizes, mode);
    scenario.memory.page_miss_cycles = kPageMiss;
    return scenario;
}

std::vector<int> lost_clocks(const ComposerBench& dut) {
    return dut.pipes.clocks_where([](const PipePixel& pixel) { return pixel.lost; });
}

std::vector<Pixel> from_above() {
    std::vector<Pixel> picture;
    for (int i = 0; i < kPixels; ++i) picture.push_back(ComposerBench::upstream(i));
    return picture;
}

TEST_CASE("composer: a gap found while it prefetches marks the whole frame and the next one is right") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 4);
    dut.put_single_pixels(16, 6, 1);  // pixels 4 and 5 have not come
    bench.core.drive(dut.pipeready_in, 12, true);
    bench.core.drive(dut.pipeready_in, 40, false);
    dut.put_single_pixels(20, 7, kPixels - 7);
    const int start = 40;
    dut.start_frame(start);
    dut.put_table(start + 10, {whole_raster()});
    dut.put_single_pixels(start + 15, 0, kPixels, 1);
    const int second = start + 60;
    dut.start_frame(second);
    bench.run_through(second + kPixels + 5);

    // Nothing is waited for any more: PIPEREADY at the edge that finds the gap.
    CHECK(dut.pipereadies.rises() == std::vector<int>{16});
    CHECK(lost_clocks(dut) == clock_range(start + 1, start + 1 + kPixels));
    CHECK(dut.picture_behind(start) == from_above());
    CHECK(dut.picture_behind(second) == dut.painted(whole_raster(), 1));
    CHECK(dut.composer.counters().lost_pixels == 2);
    CHECK(dut.composer.counters().late_pixels == 0);
    CHECK(dut.composer.counters().starved_pixels == 0);
}

TEST_CASE("composer: a gap found while it composites marks every pixel from the next clock on") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    // Covers half the raster: what is not covered is marked as well.
    const ViewportRow row = table_row(1, {0, 0}, {kWidth, 2}, {0, 0});
    dut.put_table(5, {row});
    dut.put_single_pixels(10, 0, 6);
    const int start = 30;
    dut.start_frame(start);
    const int told = start + 9;  // composites pixel 8
    dut.put_pixels(told, 7, 1, 0);
    bench.run_through(start + kPixels + 5);
    CHECK(lost_clocks(dut) == clock_range(told + 1, start + 1 + kPixels));
    std::vector<Pixel> wanted = from_above();
    for (int k = 0; k < 6; ++k) wanted[static_cast<std::size_t>(k)] = ComposerBench::local(0, k);
    CHECK(dut.picture_behind(start) == wanted);
    CHECK(dut.composer.counters().starved_pixels == 3);  // 6, 7 and 8, before the gap was known
    CHECK(dut.composer.counters().lost_pixels == 1);
}

TEST_CASE("composer: the next table tells that the last pixels of a segment were lost") {
    ClockedTestbench bench;
    const ViewportRow row = table_row(1, {0, 0}, {kWidth, 2}, {0, 0});
    ComposerBench in_time(bench, "in_time", lossy_scenario());
    ComposerBench late(bench, "late", lossy_scenario());
    const int start = 30;
    const int last = start + kPixels;  // the edge that composites the last pixel
    for (ComposerBench* dut : {&in_time, &late}) {
        dut->put_table(5, {row});
        dut->put_single_pixels(10, 0, 10);
        dut->start_frame(start);
    }
    in_time.put_table(last - 1, {row});
    late.put_table(last, {row});
    for (ComposerBench* dut : {&in_time, &late}) {
        dut->put_single_pixels(last + 5, 0, 12, 1);
        dut->start_frame(last + 30);
    }
    bench.run_through(last + 30 + kPixels + 5);
    CHECK(lost_clocks(in_time) == std::vector<int>{last});
    // The frame has gone: its last two pixels have starved, which is known only now not to be lateness.
    CHECK(lost_clocks(late).empty());
    for (const ComposerBench* dut : {&in_time, &late}) {
        CHECK(dut->composer.counters().starved_pixels == 2);
        CHECK(dut->composer.counters().lost_pixels == 2);
        CHECK(dut->picture_behind(last + 30) == dut->painted(row, 1));
    }
}

TEST_CASE("composer: pixels of a frame that is over are counted as late or lost each for itself") {
    ClockedTestbench bench;
    const ViewportRow row = table_row(1, {0, 0}, {kWidth, 2}, {0, 0});
    ComposerBench dut(bench, "dut", lossy_scenario());
    dut.put_table(5, {row});
    dut.put_single_pixels(10, 0, 4);
    const int start = 30;
    dut.start_frame(start);
    const int over = start + kPixels + 5;
    dut.put_single_pixels(over, 4, 2);
    dut.put_single_pixels(over + 4, 9, 1);  // 6, 7 and 8 were lost
    dut.put_table(over + 10, {row});        // and so were 10 and 11
    dut.put_single_pixels(over + 15, 0, 12, 1);
    dut.start_frame(over + 40);
    bench.run_through(over + 40 + kPixels + 5);
    CHECK(dut.composer.counters().starved_pixels == 8);
    CHECK(dut.composer.counters().late_pixels == 3);
    CHECK(dut.composer.counters().lost_pixels == 5);
    CHECK(lost_clocks(dut).empty());
    CHECK(dut.picture_behind(over + 40) == dut.painted(row, 1));
}

TEST_CASE("composer: STALL for a lost pixel falls at the edge that finds the gap") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario(roomy(), StarvationMode::kStall));
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 6);
    const int start = 30;
    dut.start_frame(start);
    const int told = start + 20;
    dut.put_pixels(told, 7, 1, 0);
    bench.run_through(told + kPixels + 5);
    // Pixel 6 is missed one edge ahead of the one that would composite it.
    CHECK(dut.stalls.high() == clock_range(start + 6, told));
    CHECK(dut.composer.counters().lost_pixels == 1);
    CHECK(dut.composer.counters().starved_pixels == 0);
    // Pixel 6 leaves at the edge that reads STALL low; six have gone.
    CHECK(lost_clocks(dut) == clock_range(told + 1, told + 1 + kPixels - 6));
}

TEST_CASE("composer: what comes from above marked as lost goes on so") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    dut.put_table(5, {});
    bench.core.pulse(dut.startframe_in, 20);
    for (int i = 0; i < kPixels; ++i) {
        bench.core.drive(dut.pipe_in, 21 + i, PipePixel{ComposerBench::upstream(i), true, i == 3 || i == 7});
    }
    bench.run_through(21 + kPixels + 5);
    CHECK(lost_clocks(dut) == std::vector<int>{24, 28});
    CHECK(dut.composer.counters().lost_pixels == 0);
}

TEST_CASE("composer: a burst whose end is lost is over after a page miss and a beat") {
    ClockedTestbench bench;
    // No room beside what a slot needs: as long as two pixels are counted on, no slot is taken.
    ComposerBench dut(bench, "dut", lossy_scenario({8, 7, 2}));
    dut.put_table(5, {whole_raster()});
    dut.put_pixels(10, 0, 1, 2);  // 2 of the burst behind it, which do not come
    // It must be let go: the pixel that is held by being composited.
    dut.start_frame(12);
    bench.run_through(12 + kPixels);
    // Pixel 0 is released at edge 13; the gap is longer than a page miss and a beat at edge 10 + 4.
    CHECK(dut.busreadies.falls() == std::vector<int>{10});
    CHECK(dut.busreadies.rises() == std::vector<int>{0, 10 + kPageMiss + 1});
    CHECK(dut.composer.counters().busready_drops == 0);
}

TEST_CASE("composer: pixels of an abandoned frame take no room") {
    ClockedTestbench bench;
    const ViewportRow six = table_row(1, {0, 0}, {kWidth, 1}, {0, 0});
    ComposerBench full(bench, "full", lossy_scenario({6, 2, 1}));
    ComposerBench dut(bench, "dut", lossy_scenario({8, 2, 1}));
    for (ComposerBench* each : {&full, &dut}) {
        each->put_table(5, {six});
        each->put_single_pixels(10, 0, 6);
        each->put_table(20, {whole_raster()});
        each->start_frame(60);
    }
    dut.put_single_pixels(25, 0, 1, 1);
    dut.put_single_pixels(27, 3, kPixels - 3, 1);   // 21 pixels where there is room for 2
    full.put_single_pixels(27, 1, kPixels - 1, 1);  // and where there is none
    bench.run_through(60 + kPixels + 5);
    CHECK(dut.composer.counters().lost_pixels == 2);
    CHECK(dut.composer.counters().buffer_high_water == 7);
    CHECK(full.composer.counters().lost_pixels == 1);
    CHECK(full.composer.counters().buffer_high_water == 6);
    for (const ComposerBench* each : {&full, &dut}) {
        CHECK(lost_clocks(*each).empty());  // the frame before it is whole
        CHECK(each->picture_behind(60) == each->painted(six, 0));
    }
}

TEST_CASE("composer: one that does nothing else counts the clocks of a burst whose end is lost as well") {
    constexpr int kLongMiss = 40;  // longer than a composer without work stays awake
    ClockedTestbench bench;
    Scenario scenario = lossy_scenario({8, 7, 2});
    scenario.memory.page_miss_cycles = kLongMiss;
    ComposerBench dut(bench, "dut", scenario);
    dut.put_table(5, {whole_raster()});
    dut.put_pixels(10, 0, 1, 2);
    bench.run_through(10 + kLongMiss + 20);
    CHECK(dut.busreadies.falls() == std::vector<int>{10});
    CHECK(dut.busreadies.rises() == std::vector<int>{0, 10 + kLongMiss + 1});
}

TEST_CASE("composer: a pixel that is sent again and one without a table are reported") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    ExpectedReport report("/metabuffer/composer/protocol");
    dut.put_pixels(2, 0, 1, 0);
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 3);
    dut.put_single_pixels(14, 2, 1);
    bench.run_through(1);
    CHECK(report.count() == 0);
    bench.run_through(13);
    CHECK(report.count() == 1);
    bench.run_through(14);
    CHECK(report.count() == 2);
}

}  // namespace
}  // namespace metabuffer::test
