#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "composer_bench.h"
#include "composer_scenario.h"
#include "rtl/composer_fifo.h"

namespace metabuffer::test::composer_smoothing_test {

// A composer that smooths, through its pins.
namespace {

Scenario smoothing_scenario(const ComposerSizes& sizes, StarvationMode mode = StarvationMode::kGlitch) {
    Scenario scenario = composer_scenario(sizes, mode);
    scenario.composer.smoothing = Smoothing::kBilinear;
    return scenario;
}

/// The source lines of an axis at a raster position, and the weight of the other one, by the formula.
struct Lines {
    int own = 0;
    int other = 0;
    int weight = 0;

    Lines(int distance, int count, int m) : own(distance / m), other(own) {
        const int i = distance % m;
        if (2 * i + 1 < m) other = std::max(own - 1, 0);
        if (2 * i + 1 > m) other = std::min(own + 1, count - 1);
        weight = 256 * std::abs(2 * i + 1 - m) / (2 * m);
    }
};

/// What leaves the composer for a segment of which every pixel is there.
std::vector<Pixel> smoothed_picture(const ViewportRow& row, int frame = 0,
                                    Pixel (*pixel_of)(int, std::int64_t) = &ComposerBench::local) {
    std::vector<Pixel> picture;
    for (int position = 0; position < kPixels; ++position) {
        const int x = position % kWidth;
        const int y = position / kWidth;
        const bool covered = x >= row.dx && y >= row.dy && x < row.dx + row.sdx * row.dmultiple &&
                             y < row.dy + row.sdy * row.dmultiple;
        if (!covered) {
            picture.push_back(ComposerBench::upstream(position));
            continue;
        }
        const Lines columns(x - row.dx, row.sdx, row.dmultiple);
        const Lines rows(y - row.dy, row.sdy, row.dmultiple);
        const auto mixed = [&](std::uint8_t (Pixel::*channel)() const) {
            const auto of = [&](int column, int line) {
                return (pixel_of(frame, std::int64_t{line} * row.sdx + column).*channel)();
            };
            const int sum = of(columns.own, rows.own) * (256 - columns.weight) * (256 - rows.weight) +
                            of(columns.other, rows.own) * columns.weight * (256 - rows.weight) +
                            of(columns.own, rows.other) * (256 - columns.weight) * rows.weight +
                            of(columns.other, rows.other) * columns.weight * rows.weight;
            return static_cast<std::uint8_t>((sum + 32768) / 65536);
        };
        const Pixel own = pixel_of(frame, std::int64_t{rows.own} * row.sdx + columns.own);
        picture.emplace_back(mixed(&Pixel::r), mixed(&Pixel::g), mixed(&Pixel::b), mixed(&Pixel::a), own.z());
    }
    return picture;
}

/// Segments in and across every edge, with source lines beside the raster that are mixed in or not needed at all.
std::vector<ViewportRow> smoothed_rows() {
    return {table_row(1, {0, 0}, {3, 2}, {0, 0}, 2),
            table_row(1, {0, 0}, {4, 3}, {-1, -1}, 2),
            table_row(1, {0, 0}, {2, 2}, {1, 1}, 2),
            table_row(1, {0, 0}, {3, 3}, {-2, -1}, 3),
            table_row(1, {0, 0}, {4, 3}, {-4, -3}, 3),
            table_row(1, {0, 0}, {4, 4}, {-5, -5}, 3),
            table_row(1, {0, 0}, {4, 3}, {-7, -7}, 4),
            table_row(1, {0, 0}, {2, 1}, {3, 2}, 3),
            table_row(1, {0, 0}, {1, 1}, {-4, -2}, 5),
            table_row(1, {0, 0}, {3, 3}, {-254, -254}, 255),
            whole_raster()};
}

}  // namespace

TEST_CASE("composer: smoothed, a raster pixel is mixed of the four source pixels around it, at every edge") {
    ClockedTestbench bench;
    const std::vector<ViewportRow> rows = smoothed_rows();
    std::vector<std::unique_ptr<ComposerBench>> duts;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        duts.push_back(std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(i),
                                                       smoothing_scenario({40, 6, 1})));
        duts[i]->put_table(5, {rows[i]});
        duts[i]->put_single_pixels(10, 0, rows[i].sdx * rows[i].sdy);
        duts[i]->start_frame(50);
    }
    bench.run_through(50 + kPixels + 5);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        INFO("case " << i);
        CHECK(duts[i]->picture_behind(50) == smoothed_picture(rows[i]));
        CHECK(duts[i]->composer.counters().starved_pixels == 0);
    }
}

/// Of a segment of 2 x 2 pixels: the two columns differ by all that red can, the two rows in green. So a channel shows the
/// weight itself.
Pixel contrasting_pixel(int frame, std::int64_t pixel) {
    const auto channel = [](bool high) { return static_cast<std::uint8_t>(high ? 255 : 0); };
    const bool column = pixel % 2 == 1;
    const bool row = pixel >= 2;
    return {channel(column), channel(row), channel(column != row), 255,
            ComposerBench::local(frame, pixel).z()};
}

TEST_CASE(
    "composer: smoothed, the weights are counted right at every multiple, across blocks and their centres") {
    ClockedTestbench bench;
    std::vector<ViewportRow> rows;
    std::vector<std::unique_ptr<ComposerBench>> duts;
    for (int m = 2; m <= kMaximumMultiple; ++m) {
        // Between two source pixels on one axis; in the middle of one on the other.
        rows.push_back(table_row(1, {0, 0}, {2, 2}, {kWidth / 2 - m, kHeight / 2 - m / 2}, m));
        rows.push_back(table_row(1, {0, 0}, {2, 2}, {kWidth / 2 - m / 2, kHeight / 2 - m}, m));
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
        duts.push_back(std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(i),
                                                       smoothing_scenario({40, 6, 1})));
        duts[i]->pixel_of = contrasting_pixel;
        duts[i]->put_table(5, {rows[i]});
        duts[i]->put_single_pixels(10, 0, 4);
        duts[i]->start_frame(20);
    }
    bench.run_through(20 + kPixels + 5);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        INFO("multiple " << static_cast<int>(rows[i].dmultiple) << ", case " << i);
        CHECK(duts[i]->picture_behind(20) == smoothed_picture(rows[i], 0, contrasting_pixel));
    }
}

TEST_CASE(
    "composer: smoothed, a pixel read from the bus can be mixed in at the next edge, as a neighbour too") {
    // Pixel 1 lies beside pixel 0 and goes into raster position (1, 0), which is composited at edge start + 2. Pixel 3
    // lies below pixel 0 and goes into position (0, 1).
    const ViewportRow row = table_row(1, {0, 0}, {3, 2}, {0, 0}, 2);
    constexpr int kStart = 30;
    ClockedTestbench bench;
    std::vector<std::unique_ptr<ComposerBench>> duts;
    for (const auto& [pixel, position] : {std::array<int, 2>{1, 1}, std::array<int, 2>{3, kWidth}}) {
        for (const int late : {0, 1}) {
            auto dut = std::make_unique<ComposerBench>(bench, "dut_" + std::to_string(duts.size()),
                                                       smoothing_scenario({40, 6, 1}));
            dut->put_table(5, {row});
            dut->put_single_pixels(10, 0, pixel);
            // The edge before the one that composites the position, or that one.
            dut->put_single_pixels(kStart + position + late, pixel, 6 - pixel);
            dut->start_frame(kStart);
            duts.push_back(std::move(dut));
        }
    }
    bench.run_through(kStart + kPixels + 10);
    for (std::size_t i = 0; i < duts.size(); ++i) {
        INFO("case " << i);
        const bool late = i % 2 == 1;
        // Too late, pixel 3 keeps position (0, 1) waiting, and pixel 4 a clock after it position (1, 1).
        const int starved = i == 1 ? 1 : 2;
        CHECK(duts[i]->composer.counters().starved_pixels == (late ? starved : 0));
        if (!late) CHECK(duts[i]->picture_behind(kStart) == smoothed_picture(row));
    }
}

TEST_CASE("composer: smoothed, a pixel's space is free at its last use as a neighbour and not before") {
    ClockedTestbench bench;
    // Two source rows of three pixels, doubled, over the top left of the raster. The buffer has room for three more.
    ComposerBench dut(bench, "dut", smoothing_scenario({9, 4, 1}));
    dut.put_table(5, {table_row(1, {0, 0}, {3, 2}, {0, 0}, 2)});
    dut.put_single_pixels(10, 0, 6);
    const int start = 30;
    dut.start_frame(start);
    bench.run_through(start + kPixels + 5);
    CHECK(dut.busreadies.falls() == std::vector<int>{15});  // six held, three free
    // Pixel 0 shows last at raster position (1, 1), and goes into (2, 2).
    CHECK(dut.busreadies.rises() == std::vector<int>{0, start + 1 + 2 * kWidth + 2});
}

TEST_CASE("composer: smoothed, STARTFRAME releases a source row above the raster that nothing needs") {
    ClockedTestbench bench;
    // Source row 1 shows in raster row 0, whose other source row is row 2: nothing needs row 0.
    ComposerBench dut(bench, "dut", smoothing_scenario({9, 4, 1}));
    dut.put_table(5, {table_row(1, {0, 0}, {2, 3}, {0, -7}, 4)});
    dut.put_single_pixels(10, 0, 6);
    const int start = 30;
    dut.start_frame(start);
    bench.run_through(start + kPixels + 5);
    CHECK(dut.busreadies.falls() == std::vector<int>{15});
    CHECK(dut.busreadies.rises() == std::vector<int>{0, start});
    CHECK(dut.picture_behind(start) == smoothed_picture(table_row(1, {0, 0}, {2, 3}, {0, -7}, 4)));
}

TEST_CASE("composer: smoothed, a reset ends the reads of both rows, and the next frame is whole") {
    ClockedTestbench bench;
    const ViewportRow row = table_row(1, {0, 0}, {3, 2}, {0, 0}, 2);
    ComposerBench dut(bench, "dut", smoothing_scenario({40, 6, 1}));
    rtl::FifoWires* const wires = dut.composer.fifo_wires();  // null if the FIFO is inside
    const Recording<rtl::FifoRead>* const reads =
        wires == nullptr ? nullptr : &bench.core.record(wires->second_row->read);
    const auto put_frame = [&](int clock, int frame) {
        dut.put_table(clock, {row});
        dut.put_single_pixels(clock + 5, 0, 6, frame);
        dut.start_frame(clock + 15);
        return clock + 15;
    };
    const int start = put_frame(5, 0);
    bench.run_through(start + kPixels + 5);
    // In the same frame again, the reset comes while the second row is read.
    int into_frame = kPixels / 2;
    if (reads != nullptr) {
        into_frame = 1;
        while (into_frame < kPixels && !reads->at(start + into_frame).enable) ++into_frame;
        REQUIRE(into_frame < kPixels);
    }
    const int again = put_frame(start + kPixels + 10, 1);
    const int reset = again + into_frame + 1;
    bench.core.pulse(bench.reset, reset);
    bench.run_through(reset);
    if (wires != nullptr) {
        REQUIRE(reads->at(reset - 1).enable);
        CHECK_FALSE(wires->read.read().enable);
        CHECK_FALSE(wires->second_row->read.read().enable);
    }
    dut.put_table(reset + 5, {row});
    dut.put_single_pixels(reset + 10, 0, 6);
    dut.start_frame(reset + 20);
    bench.run_through(reset + 20 + kPixels + 5);
    CHECK(dut.picture_behind(reset + 20) == smoothed_picture(row));
}

TEST_CASE("composer: smoothed, the column stands still until the last neighbour has come") {
    ClockedTestbench bench;
    const ViewportRow row = table_row(1, {0, 0}, {3, 2}, {0, 0}, 2);
    ComposerBench dut(bench, "dut", smoothing_scenario({40, 6, 1}, StarvationMode::kStall));
    const int start = 30;
    const int waited = 4;
    dut.put_table(5, {row});
    dut.put_single_pixels(10, 0, 3);
    // Raster row 1 needs the second source row from its first position on.
    const int due = start + 1 + kWidth;
    dut.put_single_pixels(due - 1 + waited, 3, 3);
    dut.start_frame(start);
    bench.run_through(start + kPixels + waited + 10);
    CHECK(dut.stalls.high() == clock_range(due - 1, due - 1 + waited));
    std::vector<Pixel> shown;
    for (int position = 0; position < kPixels; ++position) {
        shown.push_back(dut.pipes.at(start + 1 + position + (position < kWidth ? 0 : waited)).pixel);
    }
    CHECK(shown == smoothed_picture(row));
}

TEST_CASE(
    "composer fifo: for two rows it has two read ports, each with the word after the one that is read") {
    ClockedTestbench bench;
    rtl::FifoWires wires(2);
    rtl::ComposerFifo dut("fifo", 20, 2);  // 32 addresses
    dut.clk_i(bench.core.clk);
    dut.reset_i(bench.reset);
    dut.write_i(wires.write);
    dut.read_i(wires.read);
    dut.release_i(wires.release);
    dut.word_o(wires.word);
    dut.free_o(wires.free);
    dut.second_row->next_word_o(wires.second_row->next_word);
    dut.second_row->row_read_i(wires.second_row->read);
    dut.second_row->row_word_o(wires.second_row->word);
    dut.second_row->row_next_word_o(wires.second_row->row_next_word);
    const auto& words = bench.core.record(wires.word);
    const auto& next_words = bench.core.record(wires.second_row->next_word);
    const auto& row_words = bench.core.record(wires.second_row->word);
    const auto& row_next_words = bench.core.record(wires.second_row->row_next_word);
    const auto put = [&](int clock, std::uint32_t address, std::uint64_t first) {
        rtl::FifoWrite beat;
        beat.address = address;
        beat.count = 8;
        for (std::size_t i = 0; i < 8; ++i) beat.words[i] = first + i;
        bench.core.drive(wires.write, clock, beat);
        bench.core.drive(wires.write, clock + 1, rtl::FifoWrite{});
    };
    put(2, 24, 100);
    put(3, 0, 200);
    // One port reads across the last address, and the second word of the pair is written at that edge. Of the other port's
    // pair, both are.
    bench.core.drive(wires.read, 3, rtl::FifoRead{true, 31});
    bench.core.drive(wires.read, 4, rtl::FifoRead{});
    bench.core.drive(wires.second_row->read, 3, rtl::FifoRead{true, 5});
    bench.core.drive(wires.second_row->read, 4, rtl::FifoRead{});
    // After a pause in which the block sleeps, the second port alone wakes it.
    bench.core.drive(wires.second_row->read, 40, rtl::FifoRead{true, 26});
    bench.core.drive(wires.second_row->read, 41, rtl::FifoRead{});
    bench.core.drive(bench.reset, 46, true);
    bench.run_through(39);
    CHECK_FALSE(dut.sleeps());
    bench.run_through(46);
    CHECK(words.at(3) == 107);
    CHECK(next_words.at(3) == 200);
    CHECK(row_words.at(3) == 205);
    CHECK(row_next_words.at(3) == 206);
    CHECK(words.at(45) == 107);
    CHECK(next_words.at(45) == 200);
    CHECK(row_words.at(40) == 102);
    CHECK(row_next_words.at(40) == 103);
    for (const auto* all : {&words, &next_words, &row_words, &row_next_words}) CHECK(all->at(46) == 0);
}

}  // namespace metabuffer::test::composer_smoothing_test
