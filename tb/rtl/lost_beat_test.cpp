#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "composer_bench.h"
#include "composer_scenario.h"
#include "expected_report.h"
#include "support/scenarios.h"

namespace metabuffer::test::lost_beat_test {
namespace {

using rtl::BusBeat;
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

    // Nothing is waited for any more: PIPEREADY rises at the edge that finds the gap.
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
    // The row covers half the raster: what is not covered is marked as well.
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

TEST_CASE("composer: the next table shows that the last pixels of a segment were lost") {
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
    // The frame has left. Its last two pixels have starved; only now is it known that they are lost and not late.
    CHECK(lost_clocks(late).empty());
    for (const ComposerBench* dut : {&in_time, &late}) {
        CHECK(dut->composer.counters().starved_pixels == 2);
        CHECK(dut->composer.counters().lost_pixels == 2);
        CHECK(dut->picture_behind(last + 30) == dut->painted(row, 1));
    }
}

TEST_CASE("composer: each pixel of a frame that is over is counted as late or as lost") {
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
    // Pixel 6 has not come one edge before the edge that would composite it.
    CHECK(dut.stalls.high() == clock_range(start + 6, told));
    CHECK(dut.composer.counters().lost_pixels == 1);
    CHECK(dut.composer.counters().starved_pixels == 0);
    // Pixel 6 leaves at the edge that reads STALL low; six have left before.
    CHECK(lost_clocks(dut) == clock_range(told + 1, told + 1 + kPixels - 6));
}

TEST_CASE("composer: a pixel that comes from above marked as lost leaves with the mark") {
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
    // There is no space beside that of a slot: while two more pixels are announced, no slot is taken.
    ComposerBench dut(bench, "dut", lossy_scenario({8, 7, 2}));
    dut.put_table(5, {whole_raster()});
    dut.put_pixels(10, 0, 1, 2);  // announces 2 more of the burst, which do not come
    // The pixel that is held must be released by being composited.
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

TEST_CASE("composer: an otherwise idle composer counts the clocks of a burst whose end is lost as well") {
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

// ---- tables ----

/// Checks that nothing of the frame shows, and that it is marked from its first raster pixel on.
void check_abandoned(const ComposerBench& dut, int start) {
    CHECK(dut.picture_behind(start) == from_above());
    for (int i = 0; i < kPixels; ++i) REQUIRE(dut.pipes.at(start + 1 + i).lost);
}

/// Checks that the frame is shown whole.
void check_whole(const ComposerBench& dut, int start, const ViewportRow& row, int frame) {
    CHECK(dut.picture_behind(start) == dut.painted(row, frame));
    for (int i = 0; i < kPixels; ++i) REQUIRE_FALSE(dut.pipes.at(start + 1 + i).lost);
}

/// The next frame comes whole after `clock` and is composited. Returns its STARTFRAME.
int put_next_frame(ComposerBench& dut, int clock, int frame) {
    const int last = dut.put_table(clock, {whole_raster()});
    dut.put_single_pixels(last + 1, 0, kPixels, frame);
    dut.start_frame(last + kPixels + 5);
    return last + kPixels + 5;
}

TEST_CASE(
    "composer: any lost part of a table is noticed at the next beat that shows it and the next frame is "
    "right") {
    // Rows at 6, 7 and 8, the second of them this composer's; pixels for another from 12 on, for this one from 20 on.
    struct Case {
        std::vector<int> lost;
        int told;
    };
    const std::vector<Case> cases = {
        {{5}, 6},                // the start: by the first row
        {{5, 6}, 7},             // and by a later one
        {{5, 6, 7}, 8},          //
        {{5, 6, 7, 8}, 12},      // by pixels for another
        {{5, 6, 7, 8, 12}, 20},  // by its own pixels
        {{6}, 7},                // the first row: by the next
        {{6, 7}, 8},             //
        {{7}, 8},                // its own row
        {{8}, 12},               // the last, which is another's: by pixels
        {{7, 8}, 12},            //
        {{6, 7, 8}, 12},         // every row
        {{6, 7, 8, 12}, 20},     //
    };
    ClockedTestbench bench;
    std::vector<std::unique_ptr<ComposerBench>> duts;
    const int start = 60;
    int second = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        duts.push_back(std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(i), lossy_scenario()));
        ComposerBench& dut = *duts.back();
        bench.core.drive(dut.pipeready_in, 0, true);
        bench.core.drive(dut.pipeready_in, start, false);
        dut.put_table(5, {whole_raster(2), whole_raster(1), whole_raster(3)});
        dut.put_pixels(12, 0, 1, 0, 0, 2);
        dut.put_single_pixels(20, 0, kPixels);
        for (const int clock : cases[i].lost) dut.lose(clock);
        dut.start_frame(start);
        second = put_next_frame(dut, start + 5, 1);
    }
    bench.run_through(second + kPixels + 5);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        INFO("case " << i);
        const ComposerBench& dut = *duts[i];
        CHECK(dut.pipereadies.rises() == std::vector<int>{cases[i].told});
        check_abandoned(dut, start);
        check_whole(dut, second, whole_raster(), 1);
        CHECK(dut.composer.counters().lost_tables == 1);
        CHECK(dut.composer.counters().lost_pixels == 0);
        CHECK(dut.composer.counters().late_pixels == 0);
        CHECK(dut.composer.counters().starved_pixels == 0);
    }
}

TEST_CASE("composer: the next frame's start shows lost rows and frames that did not come at all") {
    ClockedTestbench bench;
    ComposerBench rows(bench, "rows", lossy_scenario());
    ComposerBench last_row(bench, "last_row", lossy_scenario());
    ComposerBench whole(bench, "whole", lossy_scenario());
    ComposerBench three(bench, "three", lossy_scenario());
    ComposerBench empty(bench, "empty", lossy_scenario());
    const int next = 80;
    for (ComposerBench* dut : {&rows, &last_row, &whole}) {
        dut->put_table(5, {whole_raster(), whole_raster(2)});
        dut->put_single_pixels(10, 0, kPixels);
    }
    rows.lose_from_to(6, 40);
    last_row.lose_from_to(7, 40);
    whole.lose_from_to(5, 40);
    empty.put_table(5, {});
    empty.lose(5);
    for (const int clock : {5, 15, 25}) three.put_table(clock, {whole_raster()});
    three.lose_from_to(5, 40);
    const std::vector<ComposerBench*> duts = {&rows, &last_row, &whole, &empty, &three};
    for (ComposerBench* dut : duts) {
        const int last = dut->put_table(next, {whole_raster()});
        dut->put_single_pixels(last + 1, 0, kPixels, 1);
        bench.core.drive(dut->pipeready_in, 0, true);
        const int missed = dut == &three ? 3 : 1;
        for (int frame = 0; frame <= missed; ++frame) dut->start_frame(next + 40 * (frame + 1));
    }
    bench.run_through(next + 240);
    for (ComposerBench* dut : duts) {
        const int missed = dut == &three ? 3 : 1;
        CHECK(dut->pipereadies.rises().front() == next);
        for (int frame = 0; frame < missed; ++frame) check_abandoned(*dut, next + 40 * (frame + 1));
        check_whole(*dut, next + 40 * (missed + 1), whole_raster(), 1);
        CHECK(dut->composer.counters().lost_tables == missed);
        CHECK(dut->composer.counters().lost_pixels == 0);
    }
}

TEST_CASE("composer: a frame that did not come takes its turn between two that are kept") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    const ViewportRow row = table_row(1, {0, 0}, {kWidth, 2}, {0, 1});
    dut.put_table(5, {row});
    dut.put_single_pixels(10, 0, 12);
    const int start = 40;
    dut.start_frame(start);
    // All while the first frame is composited.
    dut.put_table(start + 5, {});
    dut.lose(start + 5);
    dut.put_table(start + 10, {row});
    dut.put_single_pixels(start + 15, 0, 12, 2);
    const int missed = start + 40;
    const int third = missed + 40;
    dut.start_frame(missed);
    dut.start_frame(third);
    bench.run_through(third + kPixels + 5);
    check_whole(dut, start, row, 0);
    check_abandoned(dut, missed);
    check_whole(dut, third, row, 2);
    CHECK(dut.composer.counters().lost_tables == 1);
    CHECK(dut.composer.counters().late_pixels == 0);
    // Three frames are known when the third one's start comes, two from the first one's end on, one from the second's.
    CHECK(dut.tablereadies.falls() == std::vector<int>{start + 10});
    CHECK(dut.tablereadies.rises() == std::vector<int>{0, missed + kPixels});
}

TEST_CASE("composer: TABLEREADY counts a frame that is known to be lost") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, kPixels);
    dut.put_table(50, {whole_raster(2)});
    dut.lose(50);
    const int start = 70;
    dut.start_frame(start);
    bench.run_through(start + kPixels + 5);
    CHECK(dut.tablereadies.falls() == std::vector<int>{51});
    CHECK(dut.tablereadies.rises() == std::vector<int>{0, start + kPixels});
}

TEST_CASE("composer: a lost table shows the lost pixels before it as one that comes does") {
    ClockedTestbench bench;
    ComposerBench prefetching(bench, "prefetching", lossy_scenario());
    ComposerBench over(bench, "over", lossy_scenario());
    ComposerBench stalling(bench, "stalling", lossy_scenario(roomy(), StarvationMode::kStall));
    const int start = 30;
    const int told = 71;  // the row, whose frame start is lost
    for (ComposerBench* dut : {&prefetching, &over, &stalling}) {
        dut->put_table(5, {whole_raster()});
        dut->put_single_pixels(10, 0, 10);
        dut->put_table(70, {whole_raster()});
        dut->lose(70);
    }
    prefetching.start_frame(told + 10);
    over.start_frame(start);
    stalling.start_frame(start);
    // Pixels of the lost frame, and some more: none is late or lost.
    over.put_single_pixels(80, 0, 5, 1);
    const int next = put_next_frame(over, told + 60, 2);
    over.start_frame(told + 30);
    bench.run_through(next + kPixels + 5);
    check_abandoned(prefetching, told + 10);
    CHECK(lost_clocks(over) == clock_range(told + 31, told + 31 + kPixels));
    CHECK(stalling.stalls.high() == clock_range(start + 10, told));
    check_whole(over, next, whole_raster(), 2);
    for (const ComposerBench* dut : {&prefetching, &over, &stalling}) {
        CHECK(dut->composer.counters().lost_tables == 1);
        CHECK(dut->composer.counters().lost_pixels == kPixels - 10);
        CHECK(dut->composer.counters().late_pixels == 0);
    }
    CHECK(over.composer.counters().starved_pixels == kPixels - 10);
}

TEST_CASE("composer: pixels of a frame without a table count for BUSREADY as announced and take no room") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario({8, 7, 2}));
    dut.put_table(5, {whole_raster()});
    dut.lose(5);
    dut.put_pixels(10, 0, 1, 2);  // announces 2 more of the burst, which do not come
    bench.run_through(30);
    CHECK(dut.busreadies.falls() == std::vector<int>{10});
    CHECK(dut.busreadies.rises() == std::vector<int>{0, 10 + kPageMiss + 1});
    CHECK(dut.composer.counters().buffer_high_water == 0);
}

TEST_CASE("composer: pixels that are kept of the frame before a lost table stay") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, kPixels);
    dut.put_table(40, {whole_raster(), whole_raster(2)});
    dut.lose(42);
    dut.put_single_pixels(45, 0, kPixels, 1);
    dut.start_frame(80);
    dut.start_frame(120);
    bench.run_through(160);
    check_whole(dut, 80, whole_raster(), 0);
    check_abandoned(dut, 120);
    CHECK(dut.composer.counters().buffer_high_water == kPixels);
}

TEST_CASE("composer: a reset forgets lost tables and the frames' numbers") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    for (const int clock : {5, 15, 25}) dut.put_table(clock, {whole_raster()});
    dut.lose_from_to(5, 25);  // the third one's row is left
    bench.core.pulse(bench.reset, 40);
    const int start = put_next_frame(dut, 50, 3);
    bench.run_through(start + kPixels + 5);
    CHECK(dut.composer.counters().lost_tables == 3);
    check_whole(dut, start, whole_raster(), 3);
    CHECK(dut.tablereadies.falls() ==
          std::vector<int>{26});  // the first two are known by the third one's row
    CHECK(dut.tablereadies.rises() == std::vector<int>{0, 41});
}

TEST_CASE("composer: hundreds of frames in a row may be lost, and the frames keep their numbers") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", lossy_scenario());
    constexpr int kPeriod = kPixels + 8;
    constexpr int kFrames = 520;
    const std::vector<int> lost = {127, 255, 257, 511};
    for (int frame = 0; frame < kFrames; ++frame) {
        const int clock = 5 + frame * kPeriod;
        dut.put_table(clock, {});
        if (std::find(lost.begin(), lost.end(), frame) != lost.end()) dut.lose(clock);
        dut.start_frame(clock + kPeriod + 4);
    }
    ComposerBench many(bench, "many", lossy_scenario());
    many.put_table(5, {});
    many.put_table(10, {});
    many.misname(10, 65535);  // as far ahead as a number may be
    bench.run_through((kFrames + 2) * kPeriod);
    std::vector<int> abandoned;
    for (int frame = 0; frame < kFrames; ++frame) {
        const int start = 5 + frame * kPeriod + kPeriod + 4;
        const bool marked = dut.pipes.at(start + 1).lost;
        REQUIRE(dut.pipes.at(start + kPixels).lost == marked);
        if (marked) abandoned.push_back(frame);
    }
    CHECK(abandoned == lost);
    CHECK(dut.composer.counters().lost_tables == static_cast<std::int64_t>(lost.size()));
    CHECK(many.composer.counters().lost_tables == 65534);
}

TEST_CASE("composer: beats that go back are reported, since no loss can cause them") {
    ClockedTestbench bench;
    ExpectedReport report("/metabuffer/composer/protocol");
    int reports = 0;
    const auto check_reported_at = [&](int clock) {
        bench.run_through(clock - 1);
        CHECK(report.count() == reports);
        bench.run_through(clock);
        CHECK(report.count() == ++reports);
    };
    ComposerBench dut(bench, "dut", lossy_scenario());
    dut.put_table(5, {whole_raster(2), whole_raster(), whole_raster(3)});
    dut.put(9, BusBeat::table_row(0, 3, whole_raster(4), false));  // after the last
    dut.put_table(20, {whole_raster(2), whole_raster(3), whole_raster()});
    dut.put(22, BusBeat::table_row(0, 0, whole_raster(2), false));  // the first again
    dut.put_pixels(30, 0, 1, 0);
    dut.misname(30, 0);  // of the frame before
    dut.put_table(40, {});
    dut.misname(40, 1);  // begins again
    dut.put_table(45, {});
    dut.misname(45, 1 + 65536);  // where no bus can be
    check_reported_at(9);
    check_reported_at(22);
    check_reported_at(30);
    check_reported_at(40);
    check_reported_at(45);
    bench.run_through(50);
    CHECK(report.count() == reports);
}

TEST_CASE(
    "composer: a frame that begins again is reported even if there is room for it and changes nothing") {
    ClockedTestbench bench;
    ExpectedReport report("/metabuffer/composer/protocol");
    ComposerBench dut(bench, "dut", lossy_scenario());
    dut.put_table(5, {});
    dut.put_table(20, {});
    dut.misname(20, 0);
    bench.run_through(19);
    CHECK(report.count() == 0);
    bench.run_through(30);
    CHECK(report.count() == 1);
    CHECK(dut.tablereadies.falls().empty());
}

TEST_CASE("composer: a pixel that is sent again announces nothing") {
    ClockedTestbench bench;
    ExpectedReport report("/metabuffer/composer/protocol");
    ComposerBench dut(bench, "dut", lossy_scenario({8, 7, 2}));
    dut.put_table(5, {whole_raster()});
    dut.put_pixels(10, 0, 1, 0);
    dut.put_pixels(12, 0, 1, 2);
    bench.run_through(20);
    CHECK(report.count() == 1);
    CHECK(dut.busreadies.falls().empty());
}

}  // namespace
}  // namespace metabuffer::test::lost_beat_test
