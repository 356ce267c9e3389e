#include "rtl/composer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "composer_bench.h"
#include "composer_scenario.h"
#include "expected_report.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

namespace metabuffer::test::composer_test {
namespace {

using rtl::BusBeat;
using rtl::PipePixel;

// ---- pipeline ----

TEST_CASE("composer: in reset all is low, BUSREADY and TABLEREADY rise at the first clock after it") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    bench.run_through(10);
    CHECK_FALSE(dut.busreadies.at(-1));
    CHECK_FALSE(dut.tablereadies.at(-1));
    CHECK(dut.busreadies.high() == clock_range(0, 11));
    CHECK(dut.tablereadies.high() == clock_range(0, 11));
    CHECK(dut.pipereadies.high().empty());
    CHECK(dut.startframes.high().empty());
    CHECK(dut.stalls.high().empty());
    CHECK(dut.pipes.clocks_where([](const PipePixel& pixel) { return pixel.valid; }).empty());
}

TEST_CASE(
    "composer: STARTFRAME and each pixel leave at the edge that samples them, w x h clocks from the first "
    "pixel to the last") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(5, {});
    const int start = 20;
    dut.start_frame(start);
    bench.run_through(start + kPixels + 10);
    CHECK(dut.startframes.high() == std::vector<int>{start});
    // One clock ahead of pixel 0.
    CHECK(dut.pipes.clocks_where([](const PipePixel& pixel) { return pixel.valid; }) ==
          clock_range(start + 1, start + 1 + kPixels));
    CHECK(dut.picture_behind(start) == dut.painted({}, 0));
}

TEST_CASE(
    "composer: PIPEMASTER answers its own PIPEREADY with STARTFRAME one clock later and makes the "
    "background") {
    ClockedTestbench bench;
    Scenario first = composer_scenario();
    first.displays.background[0] = 11;
    first.displays.background[1] = 22;
    first.displays.background[2] = 33;
    Scenario second = first;
    second.depth_format = DepthFormat::kZ24;
    ComposerBench a8z16(bench, "a8z16", first, Strap::kMaster);
    ComposerBench z24(bench, "z24", second, Strap::kMaster);
    const int ready = 30;
    for (ComposerBench* dut : {&a8z16, &z24}) {
        dut->put_table(5, {});
        dut->start_frame(12);  // the pins from above are ignored
        bench.core.drive(dut->pipeready_in, ready, true);
    }
    bench.run_through(ready + kPixels + 20);
    for (ComposerBench* dut : {&a8z16, &z24}) {
        CHECK(dut->pipereadies.high() == std::vector<int>{ready});
        CHECK(dut->startframes.high() == std::vector<int>{ready + 1});
        CHECK(dut->pipes.clocks_where([](const PipePixel& pixel) { return pixel.valid; }) ==
              clock_range(ready + 2, ready + 2 + kPixels));
        const Pixel background(11, 22, 33, 0, dut == &a8z16 ? 0xFFFFU : 0xFF'FFFFU);
        CHECK(dut->picture_behind(ready + 1) == std::vector<Pixel>(kPixels, background));
    }
}

TEST_CASE("composer: rows and pixels for other displays are ignored") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    const ViewportRow own = table_row(1, {0, 0}, {2, 1}, {1, 1});
    dut.put_table(5, {table_row(2, {0, 0}, {3, 1}, {0, 0}), own, table_row(3, {0, 0}, {1, 1}, {0, 2})});
    dut.put_pixels(20, 100, 1, 5, 0, 2);
    dut.put_pixels(21, 0, 1, 0);
    dut.put_pixels(22, 101, 1, 0, 0, 3);
    dut.put_pixels(23, 1, 1, 0);
    dut.start_frame(30);
    bench.run_through(30 + kPixels + 5);
    CHECK(dut.picture_behind(30) == dut.painted(own, 0));
}

// ---- the buffer's timing and starvation ----

TEST_CASE(
    "composer: a pixel can be composited at the edge after the one that samples it, and starves if it is "
    "needed before") {
    ClockedTestbench bench;
    const ComposerSizes sizes{12, 5, 2};
    ComposerBench in_time(bench, "in_time", composer_scenario(sizes));
    ComposerBench late(bench, "late", composer_scenario(sizes));
    const int start = 40;
    const auto composited_at = [](int k) { return start + 1 + k; };
    for (ComposerBench* dut : {&in_time, &late}) {
        dut->put_table(5, {whole_raster()});
        for (int k = 0; k < 12; k += 2) dut->put_pixels(10 + k, k, 2, 0);
        dut->start_frame(start);
        for (int k = 14; k < kPixels; k += 2) dut->put_pixels(composited_at(k) - 1, k, 2, 0);
    }
    in_time.put_pixels(composited_at(12) - 1, 12, 2, 0);
    // Samples pixels 12 and 13 at the edge that composites pixel 12: 12 is late, 13 in time.
    late.put_pixels(composited_at(12), 12, 2, 0);
    bench.run_through(start + kPixels + 5);

    std::vector<Pixel> wanted = in_time.painted(whole_raster(), 0);
    CHECK(in_time.picture_behind(start) == wanted);

    wanted[12] = ComposerBench::upstream(12);
    CHECK(late.picture_behind(start) == wanted);
}

TEST_CASE("composer: pixels that come after their last use are dropped and displace no later pixel") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({24, 17, 8}));
    const int start = 40;
    dut.put_table(5, {whole_raster()});
    dut.put_pixels(10, 0, 8, 0);
    dut.start_frame(start);
    // Pixel 11 is composited at the edge that brings pixels 8 to 15.
    dut.put_pixels(start + 12, 8, 8, 0);
    dut.put_pixels(start + 14, 16, 8, 0);
    bench.run_through(start + kPixels + 5);
    std::vector<Pixel> wanted = dut.painted(whole_raster(), 0);
    for (int k = 8; k < 12; ++k) wanted[static_cast<std::size_t>(k)] = ComposerBench::upstream(k);
    CHECK(dut.picture_behind(start) == wanted);
}

TEST_CASE("composer: pixels that arrive when their frame is over are dropped, the next frame is whole") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({24, 5, 2}));
    const int start = 40;
    dut.put_table(5, {whole_raster()});
    for (int k = 0; k < 20; k += 2) dut.put_pixels(10 + k, k, 2, 0);
    dut.start_frame(start);
    const int end = start + kPixels;  // composites the last pixel
    dut.put_pixels(end + 1, 20, 2, 0);
    dut.put_pixels(end + 2, 22, 2, 0);
    const ViewportRow next = table_row(1, {0, 0}, {2, 2}, {1, 1});
    dut.put_table(end + 5, {next});
    dut.put_pixels(end + 10, 0, 2, 0, 1);
    dut.put_pixels(end + 11, 2, 2, 0, 1);
    dut.start_frame(end + 20);
    bench.run_through(end + 20 + kPixels + 5);
    std::vector<Pixel> wanted = dut.painted(whole_raster(), 0);
    for (int k = 20; k < 24; ++k) wanted[static_cast<std::size_t>(k)] = ComposerBench::upstream(k);
    CHECK(dut.picture_behind(start) == wanted);
    CHECK(dut.picture_behind(end + 20) == dut.painted(next, 1));
}

// ---- BUSREADY ----

TEST_CASE("composer: BUSREADY is high while exactly ready_space_pixels are free, low with one less") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}));
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 11);
    const int start = 40;
    dut.start_frame(start);
    bench.run_through(start + 3);
    CHECK(dut.busreadies.at(19));        // 10 held, 6 free
    CHECK_FALSE(dut.busreadies.at(20));  // 11 held, 5 free
    CHECK(dut.busreadies.falls() == std::vector<int>{20});
    // Pixel 0 is released at the edge that composites it.
    CHECK(dut.busreadies.rises() == std::vector<int>{0, start + 1});
}

TEST_CASE("composer: a burst's rest that fits one beat is counted beside the space for a slot") {
    ClockedTestbench bench;
    ComposerBench fits(bench, "fits", composer_scenario({16, 6, 1}));
    ComposerBench lacks(bench, "lacks", composer_scenario({16, 6, 1}));
    fits.put_table(5, {whole_raster()});
    lacks.put_table(5, {whole_raster()});
    fits.put_single_pixels(10, 0, 8);
    lacks.put_single_pixels(10, 0, 9);
    // A burst of two beats: after the first, one pixel is still to come.
    fits.put_pixels(20, 8, 1, 1);
    fits.put_pixels(22, 9, 1, 0);
    lacks.put_pixels(20, 9, 1, 1);
    lacks.put_pixels(22, 10, 1, 0);
    bench.run_through(30);
    CHECK(fits.busreadies.falls().empty());                   // 7 free and 1 to come, then 6 free
    CHECK(lacks.busreadies.falls() == std::vector<int>{20});  // 6 free and 1 to come
}

TEST_CASE(
    "composer: in a burst BUSREADY drops when the beat on its way and one more do not fit, and what is in "
    "flight is received") {
    ClockedTestbench bench;
    ComposerBench one(bench, "one", composer_scenario({16, 6, 1}));
    ComposerBench two(bench, "two", composer_scenario({16, 6, 2}));
    one.put_table(5, {whole_raster()});
    two.put_table(5, {whole_raster()});
    // A burst of 20: with 14 held two more fit, with 15 held one.
    for (int i = 0; i < 16; ++i) one.put_pixels(10 + i, i, 1, 19 - i);
    // The same in beats of two: with 12 held two more beats fit, with 14 held one.
    for (int i = 0; i < 8; ++i) two.put_pixels(10 + i, 2 * i, 2, 18 - 2 * i);
    bench.run_through(60);
    CHECK(one.busreadies.at(23));
    CHECK(one.busreadies.falls() == std::vector<int>{24});
    CHECK(two.busreadies.at(15));
    CHECK(two.busreadies.falls() == std::vector<int>{16});
}

TEST_CASE("composer: a burst whose rest fits is not cut, though it fills the buffer completely") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}));
    dut.put_table(5, {whole_raster()});
    for (int i = 0; i < 16; ++i) dut.put_pixels(10 + i, i, 1, 15 - i);
    bench.run_through(40);
    // BUSREADY is high to the last beat but one. From there on it answers for a further slot.
    CHECK(dut.busreadies.falls() == std::vector<int>{24});
}

TEST_CASE("composer: a drop lasts one clock when a slot can be taken after it") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 2, 1}));
    dut.put_table(5, {whole_raster()});
    for (int i = 0; i < 15; ++i) dut.put_pixels(10 + i, i, 1, 19 - i);
    // The edge after the drop composites pixel 0 and samples no beat: two pixels are free.
    dut.start_frame(24);
    bench.run_through(26);
    CHECK(dut.busreadies.falls() == std::vector<int>{24});
    CHECK(dut.busreadies.rises() == std::vector<int>{0, 25});
}

TEST_CASE(
    "composer: read latency and bus registers widen the margin, and BUSREADY stays low until all has come") {
    // A beat's answer is read four clocks later than otherwise: six beats can be on their way.
    Scenario delayed = composer_scenario({16, 6, 1});
    delayed.memory.read_latency_cycles = 2;
    delayed.bus.register_stages = 1;
    ClockedTestbench bench;
    ComposerBench full(bench, "full", delayed);
    ComposerBench stopped(bench, "stopped", delayed);
    full.put_table(5, {whole_raster()});
    stopped.put_table(5, {whole_raster()});
    // A burst of 20: with 10 held six more fit, with 11 held five. Those five come.
    for (int i = 0; i < 16; ++i) full.put_pixels(10 + i, i, 1, 19 - i);
    // Only two pixels of the other burst come, since the memory has to open a page.
    for (int i = 0; i < 13; ++i) stopped.put_pixels(10 + i, i, 1, 19 - i);
    stopped.start_frame(21);  // releases a pixel at each edge from 22 on: with the one of 24 a slot would fit
    bench.run_through(30);
    CHECK(full.busreadies.falls() == std::vector<int>{20});
    CHECK(full.busreadies.rises() == std::vector<int>{0});
    CHECK(stopped.busreadies.falls() == std::vector<int>{20});
    CHECK(stopped.busreadies.rises() == std::vector<int>{0, 25});
}

TEST_CASE("composer: what a cut burst had announced no longer counts") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}));
    dut.put_table(5, {whole_raster()});
    for (int i = 0; i < 16; ++i) dut.put_pixels(10 + i, i, 1, 19 - i);
    const int start = 40;
    dut.start_frame(start);
    bench.run_through(start + 12);
    // Pixel k is released at start + 1 + k. Six are free at start + 6, whatever the burst still announced.
    CHECK(dut.busreadies.rises() == std::vector<int>{0, start + 6});
}

TEST_CASE("composer: a pixel for a full buffer breaks the protocol, is reported and is dropped") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}));
    ExpectedReport report("/metabuffer/composer/protocol");
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 17);
    bench.run_through(25);
    CHECK(report.count() == 0);
    bench.run_through(26);
    CHECK(report.count() == 1);
}

// ---- tables ----

TEST_CASE(
    "composer: TABLEREADY falls with the second frame's table and rises with the first one's last pixel") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(10, {});
    dut.put_table(20, {});
    dut.start_frame(30);
    bench.run_through(30 + kPixels + 10);
    CHECK(dut.tablereadies.falls() == std::vector<int>{20});
    CHECK(dut.tablereadies.rises() == std::vector<int>{0, 30 + kPixels});
}

TEST_CASE("composer: a third frame's table breaks the protocol") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    ExpectedReport report("/metabuffer/composer/protocol");
    dut.put_table(10, {});
    dut.put_table(20, {});
    dut.put_table(30, {});
    bench.run_through(29);
    CHECK(report.count() == 0);
    bench.run_through(30);
    CHECK(report.count() == 1);
}

// ---- PIPEREADY ----

TEST_CASE("composer: PIPEREADY rises when the whole segment is there") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    bench.core.drive(dut.pipeready_in, 0, true);
    dut.put_table(5, {table_row(1, {0, 0}, {2, 2}, {0, 0})});
    for (int k = 0; k < 4; ++k) dut.put_pixels(20 + 5 * k, k, 1, 0);
    bench.run_through(60);
    CHECK(dut.pipereadies.high() == clock_range(35, 61));
}

TEST_CASE("composer: PIPEREADY rises when the buffer takes no further slot") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}));
    bench.core.drive(dut.pipeready_in, 0, true);
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 10);
    dut.put_single_pixels(40, 10, 1);  // the eleventh leaves less than a slot
    bench.run_through(60);
    CHECK(dut.pipereadies.high() == clock_range(40, 61));
}

TEST_CASE("composer: without a row PIPEREADY rises when the table has been broadcast to its end") {
    ClockedTestbench bench;
    ComposerBench no_row(bench, "no_row", composer_scenario());
    ComposerBench empty(bench, "empty", composer_scenario());
    bench.core.drive(no_row.pipeready_in, 0, true);
    bench.core.drive(empty.pipeready_in, 0, true);
    no_row.put(10, BusBeat::frame_start(0, false));
    no_row.put(14, BusBeat::table_row(0, 0, whole_raster(2), false));
    no_row.put(18, BusBeat::table_row(0, 1, whole_raster(3), true));
    empty.put(10, BusBeat::frame_start(0, true));
    bench.run_through(40);
    CHECK(no_row.pipereadies.high() == clock_range(18, 41));
    CHECK(empty.pipereadies.high() == clock_range(10, 41));
}

TEST_CASE("composer: PIPEREADY waits for the one from below and falls at the edge that sees STARTFRAME") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(5, {});
    bench.core.drive(dut.pipeready_in, 30, true);
    bench.core.drive(dut.pipeready_in, 51, false);
    dut.start_frame(50);
    bench.run_through(50 + kPixels + 10);
    CHECK(dut.pipereadies.high() == clock_range(30, 50));
}

TEST_CASE("composer: PIPEREADY once given stands until STARTFRAME, whatever comes from below") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(5, {});
    bench.core.pulse(dut.pipeready_in, 30);
    dut.start_frame(50);
    bench.run_through(50 + kPixels + 10);
    CHECK(dut.pipereadies.high() == clock_range(30, 50));
}

TEST_CASE(
    "composer: with the next frame prefetched PIPEREADY rises one clock after the last pixel, never with "
    "it") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(5, {});
    dut.put_table(8, {});
    bench.core.drive(dut.pipeready_in, 0, true);
    const int start = 30;
    dut.start_frame(start);
    bench.run_through(start + kPixels + 10);
    const int last = start + kPixels;
    CHECK(dut.pipereadies.rises() == std::vector<int>{5, last + 1});
    CHECK(dut.pipereadies.falls() == std::vector<int>{start});
}

TEST_CASE(
    "composer: back-to-back frames, each STARTFRAME three clocks after the last pixel of the frame before") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}), Strap::kMaster);
    bench.core.drive(dut.pipeready_in, 20, true);  // a display side that is always ready
    const ViewportRow first = table_row(1, {0, 0}, {4, 2}, {0, 0});
    const ViewportRow second = table_row(1, {0, 0}, {4, 2}, {2, 2});
    const ViewportRow third = table_row(1, {0, 0}, {1, 3}, {5, 1});
    dut.put_table(5, {first});
    dut.put_single_pixels(8, 0, 8, 0);
    dut.put_table(18, {second});
    dut.put_single_pixels(25, 0, 8, 1);
    dut.put_table(21 + kPixels + 2, {third});
    dut.put_single_pixels(21 + kPixels + 5, 0, 3, 2);
    bench.run_through(20 + 4 * (kPixels + 3));
    // PIPEREADY at 20, STARTFRAME at 21, last pixel at 21 + w h, PIPEREADY one clock after it.
    const int period = kPixels + 2;
    CHECK(dut.pipereadies.high() == std::vector<int>{20, 20 + period, 20 + 2 * period});
    CHECK(dut.startframes.high() == std::vector<int>{21, 21 + period, 21 + 2 * period});
    const auto background = [](int) { return Pixel(0, 0, 0, 0, 0xFFFF); };
    CHECK(dut.picture_behind(21) == dut.painted(first, 0, background));
    CHECK(dut.picture_behind(21 + period) == dut.painted(second, 1, background));
    CHECK(dut.picture_behind(21 + 2 * period) == dut.painted(third, 2, background));
}

TEST_CASE("composer: the bus carries frame k + 1 while frame k is composited, and the two are kept apart") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({32, 6, 1}));
    const ViewportRow first = whole_raster();
    const ViewportRow second = table_row(1, {0, 0}, {3, 2}, {-1, -1}, 2);
    dut.put_table(5, {first});
    dut.put_single_pixels(10, 0, kPixels, 0);
    const int start = 50;
    dut.start_frame(start);
    // The second frame's table and pixels come while the first frame's pixels are being used.
    dut.put_table(start + 3, {second});
    dut.put_single_pixels(start + 6, 0, 6, 1);
    const int next = start + kPixels + 3;
    dut.start_frame(next);
    bench.run_through(next + kPixels + 5);
    CHECK(dut.picture_behind(start) == dut.painted(first, 0));
    CHECK(dut.picture_behind(next) == dut.painted(second, 1));
}

// ---- the moving window ----

/// Segments that touch the raster's edges and cross them, in several sizes of window.
std::vector<ViewportRow> replicated_rows() {
    return {
        table_row(1, {0, 0}, {3, 2}, {0, 0}, 2),        table_row(1, {0, 0}, {4, 3}, {-1, -1}, 2),
        table_row(1, {0, 0}, {2, 2}, {1, 1}, 2),        table_row(1, {0, 0}, {3, 2}, {-2, -1}, 3),
        table_row(1, {0, 0}, {2, 1}, {3, 2}, 3),        table_row(1, {0, 0}, {1, 1}, {-4, -2}, 5),
        table_row(1, {0, 0}, {1, 1}, {-20, -9}, 30),    table_row(1, {0, 0}, {kWidth, kHeight}, {0, 0}, 1),
        table_row(1, {0, 0}, {1, 1}, {-254, -254}, 255)};
}

TEST_CASE("composer: replicated pixels are read again from the window, clipped at every edge of the raster") {
    ClockedTestbench bench;
    const std::vector<ViewportRow> rows = replicated_rows();
    std::vector<std::unique_ptr<ComposerBench>> duts;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        duts.push_back(std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(i),
                                                       composer_scenario({40, 6, 1})));
        duts[i]->put_table(5, {rows[i]});
        duts[i]->put_single_pixels(10, 0, rows[i].sdx * rows[i].sdy);
        duts[i]->start_frame(50);
    }
    bench.run_through(50 + kPixels + 5);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        INFO("case " << i);
        CHECK(duts[i]->picture_behind(50) == duts[i]->painted(rows[i], 0));
    }
}

TEST_CASE("composer: a replicated pixel's space is free at its last repetition and not before") {
    ClockedTestbench bench;
    // Two source rows of three pixels, doubled, over the top left of the raster. The buffer has room for three more.
    ComposerBench dut(bench, "dut", composer_scenario({9, 4, 1}));
    dut.put_table(5, {table_row(1, {0, 0}, {3, 2}, {0, 0}, 2)});
    dut.put_single_pixels(10, 0, 6);
    const int start = 30;
    dut.start_frame(start);
    bench.run_through(start + kPixels + 5);
    CHECK(dut.busreadies.falls() == std::vector<int>{15});  // six held, three free
    // Pixel 0 shows last at raster position (1, 1).
    CHECK(dut.busreadies.rises() == std::vector<int>{0, start + 1 + kWidth + 1});
}

// ---- stall ----

TEST_CASE(
    "composer: STALL is raised one clock before the column needs a pixel that has not come, and the column "
    "stands until it has") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({12, 5, 2}, StarvationMode::kStall));
    const int start = 40;
    dut.put_table(5, {whole_raster()});
    for (int k = 0; k < 12; k += 2) dut.put_pixels(10 + k, k, 2, 0);
    dut.start_frame(start);
    const int due = start + 1 + 12;  // the edge that would composite pixel 12
    const int waited = 4;
    for (int k = 12; k < kPixels; k += 2) dut.put_pixels(due - 1 + waited + k - 12, k, 2, 0);
    bench.run_through(start + kPixels + waited + 10);
    CHECK(dut.stalls.high() == clock_range(due - 1, due - 1 + waited));
    std::vector<Pixel> wanted = dut.painted(whole_raster(), 0);
    for (int position = 0; position < kPixels; ++position) {
        const int clock = start + 1 + position + (position < 12 ? 0 : waited);
        INFO("raster position " << position);
        CHECK(dut.pipes.at(clock).pixel == wanted[static_cast<std::size_t>(position)]);
    }
    for (int clock = due; clock < due + waited; ++clock) {
        CHECK(dut.pipes.at(clock) == dut.pipes.at(due - 1));
    }
    CHECK(dut.pipes.at(start + kPixels + waited).valid);
    CHECK_FALSE(dut.pipes.at(start + kPixels + waited + 1).valid);
}

TEST_CASE("composer: in stall mode a beat exactly in time stalls nothing") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({12, 5, 2}, StarvationMode::kStall));
    const int start = 40;
    dut.put_table(5, {whole_raster()});
    for (int k = 0; k < 12; k += 2) dut.put_pixels(10 + k, k, 2, 0);
    dut.start_frame(start);
    for (int k = 12; k < kPixels; k += 2) dut.put_pixels(start + k, k, 2, 0);
    bench.run_through(start + kPixels + 10);
    // STALL signals at edge n that the pixel for edge n + 1 has not come; the beat sampled at n already counts.
    CHECK(dut.stalls.high().empty());
    CHECK(dut.picture_behind(start) == dut.painted(whole_raster(), 0));
}

TEST_CASE("composer: while COLUMNSTALL is high the pipeline side stands still and the bus side goes on") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}, StarvationMode::kStall), Strap::kRelay,
                      StallWire::kDriven);
    const ViewportRow row = table_row(1, {0, 0}, {4, 4}, {0, 0});
    dut.put_table(5, {row});
    dut.put_single_pixels(10, 0, 8);
    const int start = 40;
    dut.start_frame(start);
    const int from = start + 4;
    const int stalled = 20;
    bench.core.drive(dut.column_stall, from, true);
    bench.core.drive(dut.column_stall, from + stalled, false);
    dut.put_single_pixels(from + 2, 8, 8);
    bench.run_through(start + kPixels + stalled + 5);
    // Three pixels have been released before: 5 + 8 of 16 are held after the eighth beat, 11 after the sixth.
    CHECK(dut.busreadies.falls() == std::vector<int>{from + 2 + 5});
    for (int clock = from; clock < from + stalled; ++clock) {
        CHECK(dut.pipes.at(clock) == dut.pipes.at(from - 1));
    }
    const std::vector<Pixel> wanted = dut.painted(row, 0);
    for (int position = 0; position < kPixels; ++position) {
        const int clock = start + 1 + position + (start + 1 + position < from ? 0 : stalled);
        INFO("raster position " << position);
        CHECK(dut.pipes.at(clock).pixel == wanted[static_cast<std::size_t>(position)]);
    }
}

TEST_CASE("composer: a frame's last pixel stands for as long as COLUMNSTALL does, and leaves when it falls") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}, StarvationMode::kStall), Strap::kRelay,
                      StallWire::kDriven);
    dut.put_table(5, {});
    const int start = 30;
    dut.start_frame(start);
    const int last = start + kPixels;
    const int stalled = 40;  // longer than the idle clocks after which the clock gate closes
    bench.core.drive(dut.column_stall, last + 1, true);
    bench.core.drive(dut.column_stall, last + 1 + stalled, false);
    bench.run_through(last + stalled + 20);
    CHECK(dut.pipes.clocks_where([](const PipePixel& pixel) { return pixel.valid; }) ==
          clock_range(start + 1, last + stalled + 1));
}

TEST_CASE("composer: COLUMNSTALL holds STARTFRAME back at its input and high at its output") {
    ClockedTestbench bench;
    const Scenario scenario = composer_scenario({16, 6, 1}, StarvationMode::kStall);
    ComposerBench input(bench, "input", scenario, Strap::kRelay, StallWire::kDriven);
    ComposerBench output(bench, "output", scenario, Strap::kRelay, StallWire::kDriven);
    ComposerBench master(bench, "master", scenario, Strap::kMaster, StallWire::kDriven);
    for (ComposerBench* dut : {&input, &output, &master}) dut->put_table(5, {});
    input.start_frame(30);
    bench.core.drive(input.column_stall, 30, true);
    bench.core.drive(input.column_stall, 35, false);
    output.start_frame(30);
    bench.core.drive(output.column_stall, 31, true);
    bench.core.drive(output.column_stall, 36, false);
    bench.core.drive(master.pipeready_in, 29, true);
    bench.core.drive(master.column_stall, 30, true);
    bench.core.drive(master.column_stall, 35, false);
    bench.run_through(35 + kPixels + 10);
    CHECK(input.startframes.high() == std::vector<int>{35});
    CHECK(input.picture_behind(35) == input.painted({}, 0));
    CHECK(output.startframes.high() == clock_range(30, 36));
    CHECK(output.picture_behind(35) == output.painted({}, 0));
    CHECK(master.pipereadies.high() == clock_range(29, 35));
    CHECK(master.startframes.high() == std::vector<int>{35});
    CHECK(master.pipes.clocks_where([](const PipePixel& pixel) { return pixel.valid; }) ==
          clock_range(36, 36 + kPixels));
}

TEST_CASE("composer: in glitch mode COLUMNSTALL is not read") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario(), Strap::kRelay, StallWire::kDriven);
    dut.put_table(5, {});
    bench.core.pulse(dut.startframe_in, 30);
    for (int i = 0; i < kPixels; ++i) {
        bench.core.drive(dut.pipe_in, 31 + i, PipePixel{ComposerBench::upstream(i), true});
    }
    bench.core.drive(dut.column_stall, 25, true);
    bench.run_through(30 + kPixels + 5);
    CHECK(dut.startframes.high() == std::vector<int>{30});
    CHECK(dut.picture_behind(30) == dut.painted({}, 0));
}

// ---- pixels lost on the bus ----

TEST_CASE(
    "composer: from the clock after the beat that shows a loss every raster pixel passes, marked lost") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({40, 6, 1}));
    const ViewportRow row = table_row(1, {0, 0}, {4, 4}, {0, 0});
    dut.put_table(5, {row});
    dut.put_single_pixels(10, 0, 9);
    const int start = 40;
    dut.start_frame(start);
    const int seen = start + 1 + 8;  // composites the third pixel of the second raster row
    dut.put_single_pixels(seen, 10, 6);
    const ViewportRow next = table_row(1, {0, 0}, {2, 2}, {1, 1});
    dut.put_table(start + 20, {next});
    dut.put_single_pixels(start + 22, 0, 4, 1);
    dut.start_frame(start + kPixels + 10);
    bench.run_through(start + 2 * kPixels + 20);
    const std::vector<Pixel> whole = dut.painted(row, 0);
    for (int position = 0; position < kPixels; ++position) {
        INFO("raster position " << position);
        const bool lost = position > 8;
        CHECK(dut.pipes.at(start + 1 + position) ==
              PipePixel{lost ? ComposerBench::upstream(position) : whole[static_cast<std::size_t>(position)],
                        true, lost});
    }
    CHECK(dut.raster_behind(start + kPixels + 10) == dut.due_behind(start + kPixels + 10, 1));
    CHECK(dut.picture_behind(start + kPixels + 10) == dut.painted(next, 1));
}

TEST_CASE(
    "composer: with a loss known before STARTFRAME nothing is waited for and the whole raster is marked") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({40, 6, 1}));
    bench.core.drive(dut.pipeready_in, 0, true);
    dut.put_table(5, {table_row(1, {0, 0}, {4, 2}, {0, 0})});
    dut.put_single_pixels(10, 0, 3);
    dut.put_single_pixels(20, 4, 1);  // pixel 3 has not come
    dut.start_frame(40);
    bench.run_through(40 + kPixels + 5);
    CHECK(dut.pipereadies.high() == clock_range(20, 40));
    for (int position = 0; position < kPixels; ++position) {
        CHECK(dut.pipes.at(41 + position) == PipePixel{ComposerBench::upstream(position), true, true});
    }
}

TEST_CASE("composer: pixels lost at the end of a segment are noticed by the next frame's table") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({40, 6, 1}));
    bench.core.drive(dut.pipeready_in, 0, true);
    const ViewportRow row = table_row(1, {0, 0}, {4, 2}, {0, 0});
    dut.put_table(5, {row});
    dut.put_single_pixels(10, 0, 7);
    dut.put_table(30, {row});
    dut.put_single_pixels(35, 0, 8, 1);
    dut.start_frame(50);
    dut.start_frame(50 + kPixels + 5);
    bench.run_through(50 + 2 * kPixels + 10);
    CHECK(dut.pipereadies.rises() == std::vector<int>{30, 50 + kPixels + 1});
    CHECK(dut.pipes.at(51).lost);
    CHECK(dut.raster_behind(50) == dut.due_behind(50, 0));
    CHECK(dut.raster_behind(50 + kPixels + 5) == dut.due_behind(50 + kPixels + 5, 1));
    CHECK(dut.picture_behind(50 + kPixels + 5) == dut.painted(row, 1));
}

TEST_CASE("composer: an abandoned frame frees its space and stores no more pixels") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({16, 6, 1}));
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 12);
    dut.put_single_pixels(30, 13, kPixels - 13);
    bench.run_through(60);
    CHECK(dut.busreadies.falls() == std::vector<int>{20});
    CHECK(dut.busreadies.rises() == std::vector<int>{0, 30});
}

TEST_CASE("composer: a mark from above is passed on with its pixel") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    ComposerBench master(bench, "master", composer_scenario(), Strap::kMaster);
    const ViewportRow row = table_row(1, {0, 0}, {2, 1}, {0, 0});
    for (ComposerBench* each : {&dut, &master}) {
        each->put_table(5, {row});
        each->put_single_pixels(10, 0, 2);
    }
    bench.core.drive(master.pipeready_in, 28, true);
    bench.core.pulse(dut.startframe_in, 30);
    for (ComposerBench* each : {&dut, &master}) {
        for (int i = 0; i < kPixels; ++i) {
            const bool lost = i == 1 || i == 5;  // covered and not
            bench.core.drive(each->pipe_in, 31 + i, PipePixel{ComposerBench::upstream(i), true, lost});
        }
    }
    bench.run_through(31 + kPixels + 5);
    const auto marked = [](const PipePixel& pixel) { return pixel.lost; };
    CHECK(dut.pipes.clocks_where(marked) == std::vector<int>{32, 36});
    CHECK(dut.picture_behind(30) == dut.painted(row, 0));
    CHECK(master.pipes.clocks_where(marked).empty());  // the pins from above are ignored
}

TEST_CASE("composer: a pixel sent again and a pixel without a table break the protocol") {
    ClockedTestbench bench;
    ComposerBench again(bench, "again", composer_scenario());
    ComposerBench bare(bench, "bare", composer_scenario());
    ExpectedReport report("/metabuffer/composer/protocol");
    again.put_table(5, {whole_raster()});
    again.put_single_pixels(10, 0, 4);
    again.put_single_pixels(20, 3, 1);
    bare.put_single_pixels(30, 0, 1);
    bench.run_through(19);
    CHECK(report.count() == 0);
    bench.run_through(29);
    CHECK(report.count() == 1);
    bench.run_through(40);
    CHECK(report.count() == 2);
}

TEST_CASE("composer: a burst is over if nothing of it comes for a page miss and a beat") {
    ClockedTestbench bench;
    Scenario scenario = composer_scenario({16, 6, 1});
    scenario.memory.page_miss_cycles = 4;
    ComposerBench stopped(bench, "stopped", scenario);
    ComposerBench waits(bench, "waits", scenario);
    for (ComposerBench* dut : {&stopped, &waits}) {
        dut->put_table(5, {whole_raster()});
        dut->put_single_pixels(10, 0, 9);
        dut->put_pixels(20, 9, 1, 1);  // beside the one still to come there is no room for a slot
    }
    waits.put_pixels(25, 10, 1, 0);  // as late as a beat may come
    bench.run_through(40);
    CHECK(stopped.busreadies.falls() == std::vector<int>{20});
    CHECK(stopped.busreadies.rises() == std::vector<int>{0, 25});
    CHECK(waits.busreadies.falls() == std::vector<int>{20});
    CHECK(waits.busreadies.rises() == std::vector<int>{0});
}

// ---- composition ----

struct Merge {
    Pixel local;
    Pixel upstream;
    Pixel z;
    Pixel z_alpha_key;
    Pixel over;
};

/// Worked out by hand: over adds back * (255 - A) / 255, rounded to nearest, and saturates.
std::vector<Merge> merges() {
    const Pixel near_opaque(10, 20, 30, 255, 100);
    const Pixel far_opaque(40, 50, 60, 255, 200);
    const Pixel near_clear(0, 0, 0, 0, 100);
    const Pixel near_half(100, 0, 8, 128, 100);
    const Pixel half_over_far(100 + 20, 25, 8 + 30, 255, 100);  // 40, 50, 60, 255 times 127 / 255
    const Pixel far_half(100, 0, 8, 128, 200);
    const Pixel opaque_same_depth(1, 2, 3, 255, 100);
    const Pixel near_bright(250, 255, 0, 100, 50);
    const Pixel far_bright(255, 255, 255, 255, 60);
    const Pixel bright_over(255, 255, 155, 255, 50);  // 250 + 155 and 255 + 155 saturate
    return {
        {near_opaque, far_opaque, near_opaque, near_opaque, near_opaque},
        {far_opaque, near_opaque, near_opaque, near_opaque, near_opaque},
        {near_clear, far_opaque, near_clear, far_opaque, Pixel(40, 50, 60, 255, 100)},
        {near_half, far_opaque, near_half, near_half, half_over_far},
        {far_half, near_opaque, near_opaque, near_opaque, near_opaque},
        // A tie keeps the upstream pixel; under `over` it is in front.
        {opaque_same_depth, near_opaque, near_opaque, near_opaque, near_opaque},
        {near_opaque, near_half, near_half, near_half, Pixel(100 + 5, 10, 8 + 15, 255, 100)},
        {near_bright, far_bright, near_bright, near_bright, bright_over},
    };
}

TEST_CASE("composer: merges as its composition mode says, worked out by hand") {
    ClockedTestbench bench;
    const std::vector<Merge> cases = merges();
    const auto count = static_cast<int>(cases.size());
    std::vector<std::unique_ptr<ComposerBench>> duts;
    for (const Composition mode : {Composition::kZ, Composition::kZAlphaKey, Composition::kOver}) {
        Scenario scenario = small_scenario(count, 1);
        scenario.composition = mode;
        duts.push_back(
            std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(duts.size()), scenario));
        ComposerBench& dut = *duts.back();
        dut.put_table(5, {table_row(1, {0, 0}, {count, 1}, {0, 0})});
        for (int k = 0; k < count; ++k) {
            BusBeat beat;
            beat.kind = BusBeat::Kind::kPixels;
            beat.destination = 1;
            beat.count = 1;
            beat.first = static_cast<std::uint32_t>(k);
            beat.words[0] = cases[static_cast<std::size_t>(k)].local.word();
            dut.put(10 + k, beat);
        }
        bench.core.pulse(dut.startframe_in, 30);
        for (int k = 0; k < count; ++k) {
            bench.core.drive(dut.pipe_in, 31 + k,
                             PipePixel{cases[static_cast<std::size_t>(k)].upstream, true});
        }
    }
    bench.run_through(31 + count);
    for (std::size_t k = 0; k < cases.size(); ++k) {
        INFO("case " << k);
        const int clock = 31 + static_cast<int>(k);
        CHECK(duts[0]->pipes.at(clock).pixel.word() == cases[k].z.word());
        CHECK(duts[1]->pipes.at(clock).pixel.word() == cases[k].z_alpha_key.word());
        CHECK(duts[2]->pipes.at(clock).pixel.word() == cases[k].over.word());
    }
}

TEST_CASE("composer: over is exact for every channel value under every alpha") {
    ClockedTestbench bench;
    constexpr int kValues = 256;
    constexpr int kChannels = 4;  // four values of the pixel behind at a time
    constexpr int kRaster = kValues * kValues / kChannels;
    Scenario scenario = small_scenario(kValues, kValues / kChannels);
    scenario.composition = Composition::kOver;
    ComposerBench dut(bench, "dut", scenario);
    dut.put_table(5, {table_row(1, {0, 0}, {kValues, kValues / kChannels}, {0, 0})});
    const int start = 30;
    bench.core.pulse(dut.startframe_in, start);
    const auto front = [](int position) { return Pixel(0, 0, 0, static_cast<std::uint8_t>(position), 1); };
    const auto behind = [](int position, int channel) {
        return static_cast<std::uint8_t>(position / kValues * kChannels + channel);
    };
    dut.bus_master = [&](int clock) {
        const int brought = clock - start + 10;
        if (brought >= 0 && brought < kRaster) {
            BusBeat beat;
            beat.kind = BusBeat::Kind::kPixels;
            beat.destination = 1;
            beat.count = 1;
            beat.first = static_cast<std::uint32_t>(brought);
            beat.words[0] = front(brought).word();
            dut.put(clock, beat);
        }
        const int due = clock - start - 1;
        if (due >= 0 && due < kRaster) {
            dut.pipe_in.write(
                {Pixel(behind(due, 0), behind(due, 1), behind(due, 2), behind(due, 3), 2), true, false});
        }
    };
    bench.run_through(start + kRaster + 2);
    const auto rounded = [](int back, int alpha) {
        return static_cast<std::uint8_t>((2 * back * (255 - alpha) + 255) / (2 * 255));
    };
    int wrong = 0;
    for (int i = 0; i < kRaster; ++i) {
        const int alpha = i % kValues;
        const Pixel wanted(rounded(behind(i, 0), alpha), rounded(behind(i, 1), alpha),
                           rounded(behind(i, 2), alpha),
                           static_cast<std::uint8_t>(std::min(255, alpha + rounded(behind(i, 3), alpha))), 1);
        wrong += dut.pipes.at(start + 1 + i) == PipePixel{wanted, true} ? 0 : 1;
    }
    CHECK(wrong == 0);
}

TEST_CASE("composer: a reset in the middle of a frame empties buffer and pipeline") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(5, {whole_raster()});
    dut.put_single_pixels(10, 0, 11);
    dut.start_frame(30);
    const int restart = 36;
    bench.core.pulse(bench.reset, restart);
    const ViewportRow row = table_row(1, {0, 0}, {2, 1}, {3, 3});
    dut.put_table(restart + 40, {row});
    dut.put_single_pixels(restart + 45, 0, 2, 1);
    dut.start_frame(restart + 50);
    bench.run_through(restart + 50 + kPixels + 5);
    CHECK_FALSE(dut.busreadies.at(restart));
    CHECK(dut.busreadies.at(restart + 1));
    CHECK_FALSE(dut.pipes.at(restart).valid);
    CHECK_FALSE(dut.pipes.at(restart + 1).valid);
    CHECK(dut.picture_behind(restart + 50) == dut.painted(row, 1));
}

TEST_CASE("composer: a reset in the middle of a burst forgets what was announced") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({8, 8, 1}));
    dut.put_table(5, {whole_raster()});
    dut.put_pixels(20, 0, 1, 1);
    bench.core.pulse(bench.reset, 21);
    bench.run_through(30);
    CHECK(dut.busreadies.falls() == std::vector<int>{20});
    CHECK(dut.busreadies.rises() == std::vector<int>{0, 22});  // the whole buffer is free
}

/// Plays the same frame in each round, with a reset one clock later each time. After the reset everything must happen
/// as in the round before.
void check_resets(StarvationMode mode, Strap strap) {
    constexpr int kRound = 140;
    constexpr int kFirstReset = 4;
    constexpr int kRounds = 90;
    constexpr int kStart = 30;
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({8, 4, 2}, mode), strap);
    // A composer that replaces the model may have no such wires.
    rtl::FifoWires* const fifo = dut.composer.fifo_wires();
    const auto* const fifo_writes = fifo == nullptr ? nullptr : &bench.core.record(fifo->write);
    const auto* const fifo_reads = fifo == nullptr ? nullptr : &bench.core.record(fifo->read);
    const auto* const fifo_releases = fifo == nullptr ? nullptr : &bench.core.record(fifo->release);
    const auto reset_at = [](int round) { return kFirstReset + round; };
    for (int round = 0; round < kRounds; ++round) {
        // After the reset its neighbours send nothing more in this round.
        const auto when = [&](int clock, const std::function<void(int)>& happens) {
            if (clock < reset_at(round) || round == kRounds - 1) happens(round * kRound + clock);
        };
        when(5, [&](int at) { dut.put(at, BusBeat::frame_start(0, false)); });
        when(7, [&](int at) { dut.put(at, BusBeat::table_row(0, 0, whole_raster(), true)); });
        // A burst that BUSREADY ends, then pairs of pixels, one of which comes too late.
        for (int beat = 0; beat < 4; ++beat) {
            when(10 + beat, [&](int at) { dut.put_pixels(at, 2 * beat, 2, 8 - 2 * beat); });
        }
        for (int pair = 0; pair < 8; ++pair) {
            const int late = pair >= 4 ? 5 : 0;
            when(36 + 3 * pair + late, [&](int at) { dut.put_pixels(at, 8 + 2 * pair, 2, 0); });
        }
        when(kStart - 8, [&](int at) { bench.core.drive(dut.pipeready_in, at, true); });
        bench.core.drive(dut.pipeready_in, round * kRound + kStart - 4, false);
        if (strap == Strap::kRelay) when(kStart, [&](int at) { dut.start_frame(at); });
        if (round < kRounds - 1) bench.core.pulse(bench.reset, round * kRound + reset_at(round));
    }
    bench.run_through(kRounds * kRound - 1);
    for (int round = 1; round < kRounds; ++round) {
        for (int clock = 0; clock < reset_at(round - 1); ++clock) {
            INFO("round " << round << ", clock " << clock);
            const int now = round * kRound + clock;
            const int before = now - kRound;
            REQUIRE(dut.busreadies.at(now) == dut.busreadies.at(before));
            REQUIRE(dut.tablereadies.at(now) == dut.tablereadies.at(before));
            REQUIRE(dut.startframes.at(now) == dut.startframes.at(before));
            REQUIRE(dut.pipes.at(now) == dut.pipes.at(before));
            REQUIRE(dut.pipereadies.at(now) == dut.pipereadies.at(before));
            REQUIRE(dut.stalls.at(now) == dut.stalls.at(before));
        }
    }
    for (int round = 0; fifo != nullptr && round < kRounds - 1; ++round) {
        INFO("round " << round);
        const int reset = round * kRound + reset_at(round);
        CHECK(fifo_writes->at(reset) == rtl::FifoWrite{});
        CHECK(fifo_reads->at(reset) == rtl::FifoRead{});
        CHECK(fifo_releases->at(reset) == rtl::FifoRelease{});
    }
    // The rounds reach what they must: in the last one a burst was cut and pixels came late.
    const int last = (kRounds - 1) * kRound;
    CHECK_FALSE(dut.busreadies.at(last + 12));
    CHECK(dut.composer.counters().busready_drops > 0);
    CHECK(dut.composer.counters().starved_pixels + dut.composer.counters().stalled_cycles > 0);
    CHECK_FALSE(dut.startframes.high().empty());
}

TEST_CASE("composer: a reset at any clock of a frame leaves what power-up leaves (glitch)") {
    check_resets(StarvationMode::kGlitch, Strap::kRelay);
}
TEST_CASE("composer: a reset at any clock of a frame leaves what power-up leaves (stall)") {
    check_resets(StarvationMode::kStall, Strap::kRelay);
}
TEST_CASE("composer: a reset at any clock of a frame leaves what power-up leaves (PIPEMASTER)") {
    check_resets(StarvationMode::kGlitch, Strap::kMaster);
}

TEST_CASE("composer: PIPEMASTER is a strap, read while reset is high and not after it") {
    ClockedTestbench bench;
    ComposerBench master(bench, "master", composer_scenario(), Strap::kMaster);
    ComposerBench relay(bench, "relay", composer_scenario(), Strap::kRelay);
    bench.core.drive(master.pipemaster, 10, false);
    bench.core.drive(relay.pipemaster, 10, true);
    for (ComposerBench* dut : {&master, &relay}) {
        dut->put_table(15, {});
        bench.core.drive(dut->pipeready_in, 20, true);
    }
    relay.start_frame(30);
    bench.run_through(30 + kPixels + 10);
    CHECK(master.startframes.high() == std::vector<int>{21});
    CHECK(master.picture_behind(21) == std::vector<Pixel>(kPixels, Pixel(0, 0, 0, 0, 0xFFFF)));
    CHECK(relay.startframes.high() == std::vector<int>{30});
    CHECK(relay.picture_behind(30) == relay.painted({}, 0));
}

TEST_CASE("composer: a reset is seen after any number of idle clocks") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(5, {});
    dut.put_table(10, {});
    bench.core.drive(dut.pipeready_in, 15, true);
    bench.core.pulse(bench.reset, 200);
    bench.run_through(210);
    CHECK(dut.pipereadies.high() == clock_range(15, 200));
    CHECK(dut.tablereadies.falls() == std::vector<int>{10});  // two tables, then none
    CHECK(dut.tablereadies.rises() == std::vector<int>{0, 201});
    CHECK(dut.busreadies.falls() == std::vector<int>{200});
}

// ---- random ----

struct RandomTraffic {
    std::vector<ViewportRow> rows;  ///< of one frame each
    int beat_pixels = 1;
    int burst_pixels = 1;
    int laziness = 2;  ///< one clock in this many starts nothing
    // One beat in this many does not arrive, except in the last frame; 0: all arrive.
    int beats_a_loss = 0;        ///< of pixels
    int table_beats_a_loss = 0;  ///< of tables
};

/// A bus that keeps the input framebuffer's side of the protocol and otherwise does everything that it may: bursts and
/// beats of any length, gaps as of page misses, other composers' traffic. If asked to, it loses beats.
class RandomBusMaster {
  public:
    RandomBusMaster(ComposerBench& dut, RandomTraffic traffic, std::uint64_t seed)
        : dut_(dut),
          rows_(std::move(traffic.rows)),
          beat_pixels_(traffic.beat_pixels),
          burst_pixels_(traffic.burst_pixels),
          laziness_(traffic.laziness),
          beats_a_loss_(traffic.beats_a_loss),
          table_beats_a_loss_(traffic.table_beats_a_loss),
          random_(seed) {
        dut.bus_master = [this](int clock) { edge(clock); };
    }

  private:
    /// What the input framebuffer does at edge clock - 1; the composer samples it at edge `clock`.
    void edge(int clock) {
        const bool busready = busready_read_;  // as it stood before edge clock - 1
        const bool tableready = tableready_read_;
        busready_read_ = dut_.busready.read();
        tableready_read_ = dut_.tableready.read();
        const int seen = announced_before_;
        announced_before_ = announced_;
        const bool passed_over = std::exchange(unseen_, false);
        if (clock < 2) return;
        if (left_ == 0) {
            if (frame_ + 1 < static_cast<int>(rows_.size()) && tableready && !random_.one_in(4)) {
                if (!started_) {
                    put_table_beat(clock, BusBeat::frame_start(0, false));
                    started_ = true;
                    return;
                }
                ++frame_;
                put_table_beat(clock,
                               BusBeat::table_row(0, 0, rows_[static_cast<std::size_t>(frame_)], true));
                started_ = false;
                left_ = std::int64_t{rows_[static_cast<std::size_t>(frame_)].sdx} *
                        rows_[static_cast<std::size_t>(frame_)].sdy;
                next_ = 0;
            }
            return;
        }
        if (burst_ > 0 && seen > beat_pixels_ && !busready) {
            burst_ = 0;
            announced_ = 0;
        }
        if (burst_ == 0) {
            if (!busready || passed_over || random_.one_in(laziness_)) return;
            burst_ = static_cast<int>(std::min<std::int64_t>(left_, random_.between(1, burst_pixels_)));
            first_beat_ = true;
        }
        if (pause_ > 0) {
            --pause_;
            return;
        }
        if (!std::exchange(paused_, false) && random_.one_in(laziness_)) {  // a page is being opened
            paused_ = true;
            pause_ = random_.between(1, dut_.scenario.memory.page_miss_cycles) - 1;
            return;
        }
        const int count = std::min(burst_, random_.between(1, beat_pixels_));
        burst_ -= count;
        const bool lost =
            beats_a_loss_ > 0 && frame_ + 1 < static_cast<int>(rows_.size()) && random_.one_in(beats_a_loss_);
        dut_.put_pixels(clock, next_, count, burst_, frame_);
        if (lost) dut_.lose(clock);
        next_ += count;
        left_ -= count;
        announced_ = burst_;
        unseen_ = burst_ == 0 && first_beat_;
        first_beat_ = false;
    }

    void put_table_beat(int clock, const BusBeat& beat) {
        dut_.put(clock, beat);
        const int frame = frame_ + (beat.kind == BusBeat::Kind::kFrameStart ? 1 : 0);
        const bool may_lose = table_beats_a_loss_ > 0 && frame + 1 < static_cast<int>(rows_.size());
        if (may_lose && random_.one_in(table_beats_a_loss_)) dut_.lose(clock);
    }

    ComposerBench& dut_;
    std::vector<ViewportRow> rows_;
    int beat_pixels_;
    int burst_pixels_;
    int laziness_;
    int beats_a_loss_;
    int table_beats_a_loss_;
    Random random_;
    bool busready_read_ = false;
    bool tableready_read_ = false;
    bool started_ = false;
    int frame_ = -1;
    std::int64_t left_ = 0;
    std::int64_t next_ = 0;
    int burst_ = 0;
    int pause_ = 0;
    bool paused_ = false;
    int announced_ = 0;
    int announced_before_ = 0;
    bool first_beat_ = false;
    bool unseen_ = false;
};

struct RandomRun {
    std::vector<ViewportRow> rows;
    std::unique_ptr<ComposerBench> dut;
    std::unique_ptr<RandomBusMaster> master;
    std::string what;
};

constexpr int kRandomWidth = 14;
constexpr int kRandomHeight = 9;
constexpr int kRandomFrames = 4;

/// A replicated row has at most `longest_source_row` pixels a source row.
ViewportRow random_row(Random& random, int longest_source_row) {
    const int multiple = random.one_in(2) ? 1 : random.between(2, 4);
    const int longest = multiple == 1 ? kRandomWidth : longest_source_row;
    return test::random_row(random, {longest, kRandomHeight}, {kRandomWidth, kRandomHeight}, 1, multiple);
}

struct Losses {
    int beats_a_loss = 0;
    int table_beats_a_loss = 0;
};

std::unique_ptr<RandomRun> random_run(ClockedTestbench& bench, Random& random, StarvationMode mode, int index,
                                      const Losses& losses) {
    auto run = std::make_unique<RandomRun>();
    RandomTraffic traffic;
    traffic.beat_pixels = 1 << random.between(0, 3);
    const int ready_space = 2 * traffic.beat_pixels + (random.one_in(2) ? 0 : random.between(0, 8));
    const int source_row = random.between(1, 4);
    const int buffer = source_row + ready_space + (random.one_in(2) ? 0 : random.between(0, 12));
    traffic.burst_pixels = random.between(1, 24);
    traffic.laziness = random.between(2, 12);
    traffic.beats_a_loss = losses.beats_a_loss;
    traffic.table_beats_a_loss = losses.table_beats_a_loss;
    for (int frame = 0; frame < kRandomFrames; ++frame) run->rows.push_back(random_row(random, source_row));
    traffic.rows = run->rows;
    run->what = "run " + std::to_string(index) + ": beats of " + std::to_string(traffic.beat_pixels) +
                ", bursts of " + std::to_string(traffic.burst_pixels) + ", ready space " +
                std::to_string(ready_space) + ", buffer " + std::to_string(buffer);
    Scenario scenario = composer_scenario({buffer, ready_space, traffic.beat_pixels}, mode);
    scenario.displays.width_pixels = kRandomWidth;
    scenario.displays.height_pixels = kRandomHeight;
    run->dut =
        std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(index), scenario, Strap::kMaster);
    run->master = std::make_unique<RandomBusMaster>(*run->dut, traffic, random.bits());
    bench.core.drive(run->dut->pipeready_in, 0, true);
    return run;
}

std::vector<std::unique_ptr<RandomRun>> random_runs(ClockedTestbench& bench, std::uint64_t seed,
                                                    StarvationMode mode, const Losses& losses = {}) {
    Random random(seed);
    std::vector<std::unique_ptr<RandomRun>> runs;
    for (int i = 0; i < 120; ++i) runs.push_back(random_run(bench, random, mode, i, losses));
    return runs;
}

constexpr int kRandomGlitchClocks = 4000;
constexpr int kRandomStallClocks = 8000;

Pixel black_background(int) { return {0, 0, 0, 0, 0xFFFF}; }

/// The segment's raster positions that do not show their pixel and are not marked lost, frame by frame.
std::vector<Glitch> starved_places(const RandomRun& run) {
    std::vector<Glitch> places;
    const std::vector<int> starts = run.dut->startframes.high();
    for (int frame = 0; frame < static_cast<int>(starts.size()); ++frame) {
        const auto at = static_cast<std::size_t>(frame);
        const std::vector<Pixel> whole = run.dut->painted(run.rows[at], frame, black_background);
        const std::vector<PipePixel> due = run.dut->due_behind(starts[at], frame, black_background);
        for (int i = 0; i < kRandomWidth * kRandomHeight; ++i) {
            const PipePixel& pixel = due[static_cast<std::size_t>(i)];
            if (!pixel.lost && pixel.pixel != whole[static_cast<std::size_t>(i)]) {
                places.push_back({frame, i % kRandomWidth, i / kRandomWidth});
            }
        }
    }
    return places;
}

TEST_CASE(
    "composer: under a random bus that keeps the protocol no buffer overflows, and exactly the pixels that "
    "come too late starve") {
    const auto seed = random_seed(71);
    INFO("METABUFFER_SEED=" << seed);
    ClockedTestbench bench;
    const auto runs = random_runs(bench, seed, StarvationMode::kGlitch);
    bench.run_through(kRandomGlitchClocks);
    std::size_t all_starved = 0;
    std::size_t all_falls = 0;
    for (const auto& run : runs) {
        INFO(run->what);
        const ComposerBench& dut = *run->dut;
        const std::vector<int> starts = dut.startframes.high();
        REQUIRE(starts.size() == run->rows.size());
        for (std::size_t frame = 0; frame < starts.size(); ++frame) {
            INFO("frame " << frame);
            CHECK(dut.raster_behind(starts[frame]) ==
                  dut.due_behind(starts[frame], static_cast<int>(frame), black_background));
        }
        all_starved += starved_places(*run).size();
        all_falls += dut.busreadies.falls().size();
    }
    // The sample is large enough: both have happened.
    CHECK(all_starved > 30);
    CHECK(all_falls > 30);
}

TEST_CASE("composer: under the same random bus in stall mode every picture is whole") {
    const auto seed = random_seed(72);
    INFO("METABUFFER_SEED=" << seed);
    ClockedTestbench bench;
    const auto runs = random_runs(bench, seed, StarvationMode::kStall);
    bench.run_through(kRandomStallClocks);
    std::size_t all_stalls = 0;
    for (const auto& run : runs) {
        INFO(run->what);
        const ComposerBench& dut = *run->dut;
        std::vector<Pixel> left;
        for (const PipePixel& pixel : dut.pixels_that_left()) left.push_back(pixel.pixel);
        std::vector<Pixel> wanted;
        for (std::size_t frame = 0; frame < run->rows.size(); ++frame) {
            const auto picture = dut.painted(run->rows[frame], static_cast<int>(frame), black_background);
            wanted.insert(wanted.end(), picture.begin(), picture.end());
        }
        CHECK(left == wanted);
        all_stalls += dut.stalls.high().size();
    }
    CHECK(all_stalls > 30);
}

TEST_CASE(
    "composer: under a random bus that loses beats a frame is marked lost from the right clock on, and the "
    "others are whole") {
    const auto seed = random_seed(73);
    INFO("METABUFFER_SEED=" << seed);
    ClockedTestbench bench;
    const auto runs = random_runs(bench, seed, StarvationMode::kGlitch, {40, 6});
    bench.run_through(kRandomGlitchClocks);
    int marked = 0;
    int untouched = 0;
    for (const auto& run : runs) {
        INFO(run->what);
        const ComposerBench& dut = *run->dut;
        const std::vector<int> starts = dut.startframes.high();
        REQUIRE(starts.size() == run->rows.size());
        for (std::size_t frame = 0; frame < starts.size(); ++frame) {
            INFO("frame " << frame);
            const auto due = dut.due_behind(starts[frame], static_cast<int>(frame), black_background);
            CHECK(dut.raster_behind(starts[frame]) == due);
            ++(due.back().lost ? marked : untouched);
        }
    }
    CHECK(marked > 30);
    CHECK(untouched > 30);
}

TEST_CASE(
    "composer: in stall mode a lost beat does not stop the column, and what is not marked lost is right") {
    const auto seed = random_seed(74);
    INFO("METABUFFER_SEED=" << seed);
    ClockedTestbench bench;
    const auto runs = random_runs(bench, seed, StarvationMode::kStall, {40, 6});
    bench.run_through(kRandomStallClocks);
    int marked = 0;
    for (const auto& run : runs) {
        INFO(run->what);
        const ComposerBench& dut = *run->dut;
        const std::vector<PipePixel> left = dut.pixels_that_left();
        REQUIRE(left.size() == run->rows.size() * kRandomWidth * kRandomHeight);
        const std::vector<FrameOnBus> on_bus = dut.frames_on_bus();
        auto pixel = left.begin();
        for (std::size_t frame = 0; frame < run->rows.size(); ++frame) {
            INFO("frame " << frame);
            for (const Pixel& whole :
                 dut.painted(run->rows[frame], static_cast<int>(frame), black_background)) {
                const Pixel wanted = pixel->lost ? black_background(0) : whole;
                if (pixel->pixel != wanted) FAIL("a pixel is neither right nor marked");
                ++pixel;
            }
            const bool ends_marked = std::prev(pixel)->lost;
            CHECK(ends_marked == on_bus[frame].loss_seen_at.has_value());
            marked += ends_marked ? 1 : 0;
        }
    }
    CHECK(marked > 30);
}

// ---- the counters ----
// Counters are not hardware behaviour: the test reads them beside the ports. A block that replaces the composer offers
// them too.

TEST_CASE("composer's counters: starved and late pixels, and the positions of the starved ones") {
    ClockedTestbench bench;
    ComposerBench in_time(bench, "in_time", composer_scenario({24, 17, 8}));
    ComposerBench late(bench, "late", composer_scenario({24, 17, 8}));
    std::vector<Glitch> glitches;
    late.composer.on_glitch([&](const Glitch& glitch) { glitches.push_back(glitch); });
    const int start = 40;
    for (ComposerBench* dut : {&in_time, &late}) {
        dut->put_table(5, {whole_raster()});
        dut->put_pixels(10, 0, 8, 0);
        dut->start_frame(start);
        dut->put_pixels(start + 14, 16, 8, 0);
    }
    in_time.put_pixels(start + 8, 8, 8, 0);  // pixel 8 is composited at the next edge
    late.put_pixels(start + 10, 8, 8, 0);
    const int end = start + kPixels;
    bench.run_through(end + 5);
    CHECK(in_time.composer.counters().starved_pixels == 0);
    CHECK(in_time.composer.counters().late_pixels == 0);
    CHECK(in_time.composer.counters().buffer_high_water == 10);
    CHECK(late.composer.counters().starved_pixels == 2);
    CHECK(late.composer.counters().late_pixels == 2);
    CHECK(glitches == std::vector<Glitch>{{0, 2, 1}, {0, 3, 1}});
    CHECK(late.composer.counters().first_glitch == glitches.front());
    CHECK(late.composer.first_starved_cycle() == start + 9 + bench.core.reset_clocks());
}

TEST_CASE("composer's counters: pixels of a frame that is over are late") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario({24, 5, 2}));
    const int start = 40;
    dut.put_table(5, {whole_raster()});
    for (int k = 0; k < 20; k += 2) dut.put_pixels(10 + k, k, 2, 0);
    dut.start_frame(start);
    dut.put_pixels(start + kPixels + 1, 20, 2, 0);
    dut.put_pixels(start + kPixels + 2, 22, 2, 0);
    bench.run_through(start + kPixels + 5);
    CHECK(dut.composer.counters().starved_pixels == 4);
    CHECK(dut.composer.counters().late_pixels == 4);
    CHECK(dut.composer.counters().lost_pixels == 0);
}

TEST_CASE("composer's counters: bursts cut short and the buffer's high water") {
    ClockedTestbench bench;
    ComposerBench cut(bench, "cut", composer_scenario({16, 6, 1}));
    ComposerBench brim(bench, "brim", composer_scenario({16, 6, 1}));
    ComposerBench others(bench, "others", composer_scenario());
    cut.put_table(5, {whole_raster()});
    brim.put_table(5, {whole_raster()});
    others.put_table(5, {whole_raster(2)});
    for (int i = 0; i < 16; ++i) {
        cut.put_pixels(10 + i, i, 1, 19 - i);
        brim.put_pixels(10 + i, i, 1, 15 - i);
        others.put_pixels(10 + i, i, 1, 15 - i, 0, 2);
    }
    bench.run_through(40);
    CHECK(cut.composer.counters().busready_drops == 1);
    CHECK(cut.composer.first_busready_drop_cycle() == 24 + bench.core.reset_clocks());
    CHECK(cut.composer.counters().buffer_high_water == 16);
    CHECK(brim.composer.counters().busready_drops == 0);
    CHECK(brim.composer.counters().buffer_high_water == 16);
    CHECK(others.composer.counters().buffer_high_water == 0);
}

TEST_CASE("composer's counters: a pixel is replayed where the raster row above shows it too") {
    ClockedTestbench bench;
    const std::vector<ViewportRow> rows = replicated_rows();
    std::vector<std::unique_ptr<ComposerBench>> duts;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        duts.push_back(std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(i),
                                                       composer_scenario({40, 6, 1})));
        duts[i]->put_table(5, {rows[i]});
        duts[i]->put_single_pixels(10, 0, rows[i].sdx * rows[i].sdy);
        duts[i]->start_frame(50);
    }
    bench.run_through(50 + kPixels + 5);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        INFO("case " << i);
        const std::vector<Pixel> picture = duts[i]->painted(rows[i], 0);
        std::int64_t replayed = 0;
        for (std::size_t at = kWidth; at < picture.size(); ++at) {
            replayed += picture[at] == picture[at - kWidth] ? 1 : 0;
        }
        CHECK(duts[i]->composer.counters().replayed_pixels == replayed);
    }
}

TEST_CASE("composer's counters: clocks that the column stood still for this composer, not for another") {
    ClockedTestbench bench;
    ComposerBench own(bench, "own", composer_scenario({12, 5, 2}, StarvationMode::kStall));
    ComposerBench other(bench, "other", composer_scenario({24, 5, 2}, StarvationMode::kStall), Strap::kRelay,
                        StallWire::kDriven);
    const int start = 40;
    const int waited = 4;
    own.put_table(5, {whole_raster()});
    other.put_table(5, {whole_raster()});
    for (int k = 0; k < 12; k += 2) own.put_pixels(10 + k, k, 2, 0);
    for (int k = 12; k < kPixels; k += 2) own.put_pixels(start + waited + k - 12 + 12, k, 2, 0);
    for (int k = 0; k < kPixels; k += 2) other.put_pixels(10 + k, k, 2, 0);
    own.start_frame(start);
    other.start_frame(start);
    bench.core.drive(other.column_stall, start + 4, true);
    bench.core.drive(other.column_stall, start + 4 + waited, false);
    bench.run_through(start + kPixels + waited + 10);
    CHECK(own.composer.counters().stalled_cycles == waited);
    CHECK(own.composer.counters().starved_pixels == 0);
    CHECK(own.composer.counters().late_pixels == 0);
    CHECK(own.composer.first_starved_cycle() == start + 12 + bench.core.reset_clocks());
    CHECK(other.composer.counters().stalled_cycles == 0);
}

TEST_CASE("composer's counters: lost pixels, from the indexes that beats name and from the next table") {
    ClockedTestbench bench;
    ComposerBench gap(bench, "gap", composer_scenario({32, 6, 1}));
    ComposerBench tail(bench, "tail", composer_scenario({32, 6, 1}));
    for (ComposerBench* dut : {&gap, &tail}) dut->put_table(5, {whole_raster()});
    gap.put_single_pixels(10, 0, 8);
    gap.put_single_pixels(30, 11, kPixels - 11);
    tail.put_single_pixels(10, 0, kPixels - 5);
    for (ComposerBench* dut : {&gap, &tail}) dut->put_table(60, {});
    bench.run_through(70);
    CHECK(gap.composer.counters().lost_pixels == 3);
    CHECK(gap.composer.counters().late_pixels == 0);
    CHECK(tail.composer.counters().lost_pixels == 5);
}

TEST_CASE("composer's counters: frames begin at their STARTFRAME and end with their last pixel") {
    ClockedTestbench bench;
    ComposerBench dut(bench, "dut", composer_scenario());
    dut.put_table(5, {});
    const int start = 20;
    dut.start_frame(start);
    bench.run_through(start + kPixels + 5);
    REQUIRE(dut.composer.frame_spans().size() == 1);
    const auto& span = dut.composer.frame_spans().front();
    CHECK(span.startframe_cycle == start + bench.core.reset_clocks());
    CHECK(span.start_cycle == start + 1 + bench.core.reset_clocks());
    CHECK(span.end_cycle == start + kPixels + bench.core.reset_clocks());
}

TEST_CASE("composer's counters: under the random bus they agree with the ports") {
    const auto seed = random_seed(71);
    INFO("METABUFFER_SEED=" << seed);
    ClockedTestbench bench;
    const auto runs = random_runs(bench, seed, StarvationMode::kGlitch, {60, 8});
    std::vector<std::vector<Glitch>> glitches(runs.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
        runs[i]->dut->composer.on_glitch(
            [&glitches, i](const Glitch& glitch) { glitches[i].push_back(glitch); });
    }
    bench.run_through(kRandomGlitchClocks);
    std::int64_t all_drops = 0;
    std::int64_t all_late = 0;
    std::int64_t all_lost = 0;
    std::int64_t all_tables_lost = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO(runs[i]->what);
        const ComposerBench& dut = *runs[i]->dut;
        const ComposerCounters& counters = dut.composer.counters();
        CHECK(glitches[i] == starved_places(*runs[i]));
        CHECK(counters.starved_pixels == static_cast<std::int64_t>(glitches[i].size()));
        CHECK(counters.buffer_high_water <= dut.scenario.composer.buffer_pixels);
        std::int64_t not_come = 0;
        std::int64_t tables_lost = 0;
        const std::vector<FrameOnBus> frames = dut.frames_on_bus();
        for (std::size_t frame = 0; frame < frames.size(); ++frame) {
            tables_lost += frames[frame].table_lost ? 1 : 0;
            if (frames[frame].table_lost) continue;
            not_come += std::int64_t{runs[i]->rows[frame].sdx} * runs[i]->rows[frame].sdy -
                        static_cast<std::int64_t>(frames[frame].sampled_at.size());
        }
        CHECK(counters.lost_pixels == not_come);
        CHECK(counters.lost_tables == tables_lost);
        all_drops += counters.busready_drops;
        all_late += counters.late_pixels;
        all_lost += counters.lost_pixels;
        all_tables_lost += counters.lost_tables;
    }
    CHECK(all_drops > 30);
    CHECK(all_late > 30);
    CHECK(all_lost > 30);
    CHECK(all_tables_lost > 30);
}

}  // namespace
}  // namespace metabuffer::test::composer_test
