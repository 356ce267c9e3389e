#include <catch2/catch.hpp>
#include <string>

#include "clocked_testbench.h"
#include "composer_wave.h"
#include "random_composer.h"
#include "rtl/composer_fifo.h"

namespace metabuffer::test::composer_smoothing_test {

// A composer that smooths, through its pins.
namespace {

using rtl::Composer;

Scenario smoothing_scenario(int width, int height) {
    Scenario scenario = wave_scenario(width, height);
    scenario.composer.smoothing = Smoothing::kBilinear;
    return scenario;
}

/// Every pixel of the segment is `a`, so that each mixture is.
ComposerWave::Letters<rtl::BusBeat> even_beats(const ViewportRow& row) {
    auto letters = beats(row);
    for (int k = 0; k < kLetters; ++k) letters[static_cast<char>('a' + k)].words[0] = local_pixel(0).word();
    return letters;
}

}  // namespace

TEST_CASE("composer: smoothed, in lockstep with its reference") {
    LockstepBench bench(72);
    run_random_composers(bench, Smoothing::kBilinear, 40, 4000);
}

TEST_CASE("composer: timing: smoothed pixel read from the bus to its first use as a neighbour too") {
    LockstepBench bench;
    // Pixel b goes into position 1 and comes at the edge before, pixel c into position 3 and comes at that edge.
    ComposerWave columns(bench, "columns", composer_of(smoothing_scenario(6, 2)));
    columns.drive("..FRa..b..c...........", &Composer::bus_i, even_beats(segment_row({3, 1}, {}, 2)));
    columns.drive("______-_______________", &Composer::startframe_i);
    columns.drive(".......000300000000...", &Composer::pipe_i, pixels());
    columns.check("........aaa3aaaaaaaa..", &Composer::pipe_o, pixels());
    // Pixel b goes into the second raster row, whose first position is composited at edge 9.
    ComposerWave rows(bench, "rows", composer_of(smoothing_scenario(2, 4)));
    rows.drive("..FRa...b.............", &Composer::bus_i, even_beats(segment_row({1, 2}, {}, 2)));
    rows.drive("______-_______________", &Composer::startframe_i);
    rows.check("........aaaaaaaa......", &Composer::pipe_o, pixels());
    ComposerWave late(bench, "late", composer_of(smoothing_scenario(2, 4)));
    late.drive("..FRa....b............", &Composer::bus_i, even_beats(segment_row({1, 2}, {}, 2)));
    late.drive("______-_______________", &Composer::startframe_i);
    late.drive(".......0123456789.....", &Composer::pipe_i, pixels());
    late.check("........aa2aaaaa......", &Composer::pipe_o, pixels());
    rows.drive(".......0123456789.....", &Composer::pipe_i, pixels());
    run({&columns, &rows, &late});
}

TEST_CASE(
    "composer: timing: smoothed STARTFRAME read to the release of a source row above the raster that nothing "
    "needs") {
    LockstepBench bench;
    Scenario scenario = smoothing_scenario(6, 4);
    scenario.composer.buffer_pixels = 9;
    scenario.composer.ready_space_pixels = 4;
    // Source row 1 shows in raster row 0, whose other source row is row 2: nothing needs the two pixels of row 0.
    ComposerWave dut(bench, "composer", composer_of(scenario));
    dut.drive("..FRabcdef......", &Composer::bus_i, beats(segment_row({2, 3}, {0, -7}, 4)));
    dut.drive("____________-___", &Composer::startframe_i);
    dut.check("_---------___---", &Composer::busready_o);
    run({&dut});
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
