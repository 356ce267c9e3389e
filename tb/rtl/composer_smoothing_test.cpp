#include <catch2/catch.hpp>
#include <string>

#include "composer_wave.h"
#include "random_composer.h"

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

}  // namespace metabuffer::test::composer_smoothing_test
