#include "rtl/dvi_display.h"

#include <catch2/catch.hpp>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "expected_report.h"

namespace metabuffer::test::dvi_display_test {
namespace {

using rtl::DviDisplay;
using rtl::DviLink;

constexpr int kWidth = 9;
constexpr int kHeight = 4;
constexpr int kFrame = frame_clocks(kWidth, kHeight);
constexpr int kVsync = vsync_in_frame(kWidth, kHeight);

struct Capture {
    int clock = 0;
    ColourImage image;
};

/// A monitor whose link plays a waveform from clock 0 on.
struct DisplayBench {
    ClockedTestbench bench;
    sc_core::sc_signal<DviLink> link;
    DviDisplay display;
    Waveform wave;
    std::vector<Capture> captures;

    DisplayBench() : display("dvi_display") {
        display.clk_i(bench.core.clk);
        display.reset_i(bench.reset);
        display.link_i(link);
        bench.trace(display);
        // The edge under way is the one after the last that the driver has recorded.
        display.on_frame([this](const ColourImage& image) {
            captures.push_back({bench.core.clock() + 1, image});
        });
        bench.core.each_clock([this](int clock) {
            const auto index = static_cast<std::size_t>(clock);
            link.write(index < wave.size() ? wave[index] : DviLink{});
        });
    }
    int add(const LinkLines& lines) {
        const auto start = static_cast<int>(wave.size());
        append_frame(wave, kWidth, lines);
        return start;
    }
    void run() { bench.run_through(static_cast<int>(wave.size()) + 2); }
};

LinkLines picture(std::uint32_t seed) {
    LinkLines lines(kHeight, std::vector<std::uint32_t>(kWidth));
    for (auto& line : lines) {
        for (std::uint32_t& pixel : line) {
            seed = seed * 1664525U + 1013904223U;
            pixel = seed >> 8;
        }
    }
    return lines;
}

std::vector<std::uint32_t> flat(const LinkLines& lines) {
    std::vector<std::uint32_t> values;
    for (const auto& line : lines) values.insert(values.end(), line.begin(), line.end());
    return values;
}

TEST_CASE("dvi display: captures the picture it is shown at the edge that sees VSYNC rise after it") {
    DisplayBench dut;
    append_blank_lines(dut.wave, kWidth, 1, true);
    const int first = dut.add(picture(1));
    const int second = dut.add(picture(2));
    dut.run();
    REQUIRE(dut.captures.size() == 2);
    CHECK(dut.captures[0].clock == first + kVsync);
    CHECK(dut.captures[1].clock == second + kVsync);
    CHECK(dut.captures[0].image.width_pixels == kWidth);
    CHECK(dut.captures[0].image.height_pixels == kHeight);
    CHECK(dut.captures[0].image.values == flat(picture(1)));
    CHECK(dut.captures[1].image.values == flat(picture(2)));
    CHECK(dut.display.frames_captured() == 2);
}

TEST_CASE("dvi display: a picture whose beginning it has not seen is not captured") {
    DisplayBench dut;
    dut.add(picture(1));
    dut.add(picture(2));
    dut.run();
    REQUIRE(dut.captures.size() == 1);
    CHECK(dut.captures[0].clock == kFrame + kVsync);
    CHECK(dut.captures[0].image.values == flat(picture(2)));
}

TEST_CASE("dvi display: measures the geometry it is shown, which may change from frame to frame") {
    DisplayBench dut;
    append_blank_lines(dut.wave, kWidth, 1, true);
    LinkLines narrow = picture(3);
    for (auto& line : narrow) line.resize(5);
    LinkLines low = picture(4);
    low.resize(2);
    dut.add(narrow);
    dut.add(low);
    dut.run();
    REQUIRE(dut.captures.size() == 2);
    CHECK(dut.captures[0].image.width_pixels == 5);
    CHECK(dut.captures[0].image.height_pixels == kHeight);
    CHECK(dut.captures[0].image.values == flat(narrow));
    CHECK(dut.captures[1].image.width_pixels == kWidth);
    CHECK(dut.captures[1].image.height_pixels == 2);
    CHECK(dut.captures[1].image.values == flat(low));
}

TEST_CASE("dvi display: a VSYNC without lines before it is not a frame") {
    DisplayBench dut;
    append_blank_lines(dut.wave, kWidth, 1, true);
    append_blank_lines(dut.wave, kWidth, 3, false);
    append_blank_lines(dut.wave, kWidth, 1, true);
    dut.add(picture(1));
    dut.run();
    CHECK(dut.captures.size() == 1);
}

TEST_CASE("dvi display: a frame of unequal lines causes a warning and is not captured, the next one is") {
    DisplayBench dut;
    ExpectedReport report("/metabuffer/dvi_display/geometry");
    append_blank_lines(dut.wave, kWidth, 1, true);
    LinkLines ragged = picture(5);
    ragged[2].pop_back();
    const int bad = dut.add(ragged);
    const int good = dut.add(picture(6));
    dut.bench.run_through(bad + kVsync - 1);
    CHECK(report.count() == 0);
    dut.bench.run_through(bad + kVsync);
    CHECK(report.count() == 1);
    dut.run();
    CHECK(report.count() == 1);
    REQUIRE(dut.captures.size() == 1);
    CHECK(dut.captures[0].clock == good + kVsync);
    CHECK(dut.captures[0].image.values == flat(picture(6)));
    CHECK(dut.display.frames_captured() == 1);
}

TEST_CASE(
    "dvi display: a line that VSYNC breaks off spoils its picture, and its rest belongs to the next one") {
    DisplayBench dut;
    ExpectedReport report("/metabuffer/dvi_display/geometry");
    append_blank_lines(dut.wave, kWidth, 1, true);
    const int first = dut.add(picture(7));
    dut.wave.resize(static_cast<std::size_t>(first + kVsync));  // up to its vertical sync
    constexpr int kShort = 5;
    for (int x = 0; x < kShort; ++x) {
        DviLink link;
        link.de = true;
        link.vsync = x > 1;  // the pixel that sees it rise still belongs to the line that it ends
        link.data = static_cast<std::uint32_t>(x);
        dut.wave.push_back(link);
    }
    append_blank_lines(dut.wave, kWidth, 1, false);
    LinkLines narrow = picture(8);
    for (auto& line : narrow) line.resize(kShort - 3);
    dut.add(narrow);
    dut.run();
    CHECK(report.count() == 1);
    REQUIRE(dut.captures.size() == 1);
    CHECK(dut.captures[0].image.width_pixels == kShort - 3);
    CHECK(dut.captures[0].image.height_pixels == 1 + kHeight);
    std::vector<std::uint32_t> wanted{3, 4};
    for (const std::uint32_t value : flat(narrow)) wanted.push_back(value);
    CHECK(dut.captures[0].image.values == wanted);
}

TEST_CASE("dvi display: a reset in the middle of a picture drops it") {
    DisplayBench dut;
    append_blank_lines(dut.wave, kWidth, 1, true);
    const int first = dut.add(picture(1));
    dut.add(picture(2));
    dut.bench.core.pulse(dut.bench.reset, first + clock_in_frame(kWidth, 3, 1));
    dut.run();
    REQUIRE(dut.captures.size() == 1);
    CHECK(dut.captures[0].image.values == flat(picture(2)));
}

TEST_CASE("dvi display: a reset wakes a display that sleeps, and drops its picture") {
    DisplayBench dut;
    append_blank_lines(dut.wave, kWidth, 1, true);
    const int first = dut.add(picture(1));
    dut.wave.resize(static_cast<std::size_t>(first + kVsync));
    constexpr int kStill = 40;
    dut.wave.resize(dut.wave.size() + kStill);
    append_blank_lines(dut.wave, kWidth, 1, true);
    dut.add(picture(2));
    dut.bench.core.pulse(dut.bench.reset, first + kVsync + kStill - 5);
    dut.run();
    REQUIRE(dut.captures.size() == 1);
    CHECK(dut.captures[0].image.values == flat(picture(2)));
}

}  // namespace
}  // namespace metabuffer::test::dvi_display_test
