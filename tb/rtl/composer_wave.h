#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>

#include "lockstep/waveform_case.h"
#include "pixel_beat.h"
#include "rtl/composer.h"
#include "support/rows.h"
#include "support/scenarios.h"

namespace metabuffer::test {

/// A composer of display 1 whose pins are written down as strings.
///
/// - On the bus `F` is the start of frame 0, `E` its start if its table is empty, `R` its only row, which is this
///   composer's. `a`, `b`, ... are the pixels of its segment. `G` and `H` are the starts of frames 1 and 2, whose tables are
///   empty, `S` is a row of frame 1.
/// - On the pipeline `a`, `b`, ... are the same pixels, which are in front of those from above. Those are `0`, `1`, ... by
///   raster position, or `A`, `B`, ... if they are marked as lost.
using ComposerWave = WaveformCase<rtl::Composer>;

inline ComposerWave::Factory composer_of(const Scenario& scenario) {
    return [scenario](const char* name, rtl::ClockGating) {
        return std::make_unique<rtl::Composer>(name, scenario, 1);
    };
}

inline Pixel local_pixel(int k) {
    return {static_cast<std::uint8_t>(40 * k), static_cast<std::uint8_t>(k), 7, 255, 5};
}
inline rtl::PipePixel from_above(int position, bool lost = false) {
    return {Pixel(192, 0, static_cast<std::uint8_t>(position), 128, 0x8000), true, lost};
}

/// `count` pixels of the segment of frame 0. The burst's last one is `last`.
inline rtl::BusBeat burst_beat(int first, int last, int count = 1) {
    return pixel_beat(0, 1, first, count, last - first - count + 1,
                      [](std::int64_t k) { return local_pixel(static_cast<int>(k)).word(); });
}

constexpr int kLetters = 16;

/// Each pixel is alone in its burst.
inline ComposerWave::Letters<rtl::BusBeat> beats(const ViewportRow& row) {
    ComposerWave::Letters<rtl::BusBeat> letters{
        {'F', rtl::BusBeat::frame_start(0, false)},      {'E', rtl::BusBeat::frame_start(0, true)},
        {'G', rtl::BusBeat::frame_start(1, true)},       {'H', rtl::BusBeat::frame_start(2, true)},
        {'S', rtl::BusBeat::table_row(1, 0, row, true)}, {'R', rtl::BusBeat::table_row(0, 0, row, true)}};
    for (int k = 0; k < kLetters; ++k) letters[static_cast<char>('a' + k)] = burst_beat(k, k);
    return letters;
}
/// The pixels are one burst, of which the last is `last`.
inline ComposerWave::Letters<rtl::BusBeat> burst(const ViewportRow& row, int last) {
    auto letters = beats(row);
    for (int k = 0; k < kLetters; ++k) letters[static_cast<char>('a' + k)] = burst_beat(k, last);
    return letters;
}
inline ComposerWave::Letters<rtl::PipePixel> pixels() {
    ComposerWave::Letters<rtl::PipePixel> letters;
    for (int i = 0; i < kLetters; ++i) {
        if (i < 10) letters[static_cast<char>('0' + i)] = from_above(i);
        letters[static_cast<char>('A' + i)] = from_above(i, true);
        letters[static_cast<char>('a' + i)] = {local_pixel(i), true, false};
    }
    return letters;
}

/// The pins that a composer has no strings for stand low and are not checked.
inline void leave(ComposerWave& dut) {
    using rtl::Composer;
    dut.leave(&Composer::pipemaster_i, &Composer::bus_i, &Composer::busready_o, &Composer::tableready_o,
              &Composer::startframe_i, &Composer::startframe_o, &Composer::pipe_i, &Composer::pipe_o,
              &Composer::pipeready_i, &Composer::pipeready_o, &Composer::column_stall_i, &Composer::stall_o);
}
/// To the end of the strings, all of which are equally long.
inline void run(std::initializer_list<ComposerWave*> duts) {
    for (ComposerWave* dut : duts) leave(*dut);
    (*duts.begin())->run();
}

/// A raster of a few pixels and a buffer of 16.
inline Scenario wave_scenario(int width, int height = 1, StarvationMode mode = StarvationMode::kGlitch) {
    Scenario scenario = small_scenario(width, height);
    scenario.composer.buffer_pixels = 16;
    scenario.composer.ready_space_pixels = 2;
    scenario.composer.on_starvation = mode;
    return scenario;
}

}  // namespace metabuffer::test
