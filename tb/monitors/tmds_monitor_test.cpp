#include "monitors/tmds_monitor.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "support/random_seed.h"
#include "tmds_waveform.h"

namespace metabuffer::test::tmds_monitor_test {

namespace {

constexpr int kWidth = 14;
constexpr int kHeight = 3;
constexpr int kFirstSync = 2 * line_clocks(kWidth);
constexpr int kEncoder = 1;  ///< clocks from a pixel to its characters
constexpr int kLink = 7;     ///< and to the pixel at the other end

/// The clock of a pixel in the first frame.
constexpr int pixel_at(int line, int x) { return kFirstSync + clock_in_frame(kWidth, x, line); }

Waveform frames() {
    Random random(random_seed(101));
    Waveform wave;
    append_blank_lines(wave, kWidth, 2, true);
    for (int frame = 0; frame < 2; ++frame) {
        LinkLines lines(kHeight, std::vector<std::uint32_t>(kWidth));
        for (auto& line : lines) {
            for (std::uint32_t& pixel : line) pixel = static_cast<std::uint32_t>(random.bits()) & 0xFF'FFFFU;
        }
        append_frame(wave, kWidth, lines);
    }
    return wave;
}

/// A monitor on a link whose waveforms a test writes: pixels, characters a clock later, and pixels at the other end.
struct Bench {
    ClockedTestbench bench;
    sc_core::sc_signal<rtl::DviLink> link;
    sc_core::sc_signal<rtl::TmdsLink> tmds;
    sc_core::sc_signal<rtl::DviLink> seen;
    monitors::ViolationLog log;
    monitors::TmdsMonitor monitor;
    Waveform wave = frames();
    TmdsWaveform characters = tmds_waveform(wave);
    Waveform received = wave;
    std::vector<monitors::Violation> violations;

    explicit Bench(bool disturbed = false)
        : monitor("tmds_monitor", {"TMDS_IN_1", "DVI_IN_1", "dvi_in", disturbed}, log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.link_i(link);
        monitor.tmds_i(tmds);
        monitor.seen_i(seen);
        log.on_violation([this](const monitors::Violation& violation) { violations.push_back(violation); });
        // What edge n samples: a pixel, the characters of the one before it, and the pixel of seven clocks ago.
        bench.core.each_clock([this](int clock) {
            link.write(at(wave, clock));
            tmds.write(at(characters, clock - kEncoder));
            seen.write(at(received, clock - kLink));
        });
    }
    template <typename Value>
    static Value at(const std::vector<Value>& values, int index) {
        return index >= 0 && index < static_cast<int>(values.size()) ? values[static_cast<std::size_t>(index)]
                                                                     : Value{};
    }
    TmdsCharacter& character(int line, int x, std::size_t channel) {
        return characters[static_cast<std::size_t>(pixel_at(line, x))].channels[channel];
    }
    void run() { bench.run_through(static_cast<int>(wave.size()) + 10); }
    void check_first(const std::string& rule, const std::string& signal, int clock) const {
        REQUIRE_FALSE(violations.empty());
        CHECK(violations[0].rule == rule);
        CHECK(violations[0].signal == signal);
        CHECK(violations[0].clock == "dvi_in");
        CHECK(violations[0].cycle == clock + bench.core.reset_clocks());
        CHECK_FALSE(violations[0].detail.empty());
    }
};

}  // namespace

TEST_CASE("TMDS monitor: a legal link breaks no rule", "[monitors]") {
    Bench bench;
    bench.run();
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
    CHECK(bench.monitor.pixels() == 2 * kWidth * kHeight);
    CHECK(bench.monitor.unreported() == 0);
}

TEST_CASE("TMDS monitor: every character that the flow chart makes is legal, and no other", "[monitors]") {
    std::set<TmdsCharacter> legal;
    for (int disparity = -8; disparity <= 8; disparity += 2) {
        for (unsigned byte = 0; byte < 256; ++byte) {
            TmdsFlowChart chart;
            chart.cnt = disparity;
            chart.encode(byte);
            legal.insert(chart.character());
        }
    }
    for (TmdsCharacter character = 0; character < 1024; ++character) {
        INFO("character " << character);
        CHECK(monitors::TmdsMonitor::is_of_a_pixel(character) == (legal.count(character) > 0));
    }
}

TEST_CASE("TMDS monitor: a character that no encoder sends", "[monitors]") {
    Bench bench;
    TmdsCharacter& character = bench.character(1, 5, 2);
    character = 0b1010101010;
    bench.run();
    bench.check_first("tmds/character", "TMDS_IN_1", pixel_at(1, 5) + kEncoder);
    CHECK(bench.violations.size() == 1);
}

TEST_CASE("TMDS monitor: a control character in a pixel, and a pixel's in blanking", "[monitors]") {
    Bench bench;
    bench.character(1, 5, 1) = 0b1101010100;
    bench.run();
    bench.check_first("tmds/control", "TMDS_IN_1", pixel_at(1, 5) + kEncoder);
}

TEST_CASE("TMDS monitor: a pixel's character in blanking", "[monitors]") {
    Bench bench;
    bench.character(1, kWidth + 2, 0) = bench.character(1, 3, 0);
    bench.run();
    bench.check_first("tmds/control", "TMDS_IN_1", pixel_at(1, kWidth + 2) + kEncoder);
}

namespace {

/// A control character in a line's front porch, where all are of two bits 0.
void check_control_character(std::size_t channel, TmdsCharacter character) {
    Bench bench;
    bench.character(1, kWidth + 2, channel) = character;
    bench.run();
    bench.check_first("tmds/control", "TMDS_IN_1", pixel_at(1, kWidth + 2) + kEncoder);
}

}  // namespace

TEST_CASE("TMDS monitor: a HSYNC that the link has not", "[monitors]") {
    check_control_character(0, 0b0010101011);
}

TEST_CASE("TMDS monitor: a VSYNC that the link has not", "[monitors]") {
    check_control_character(0, 0b0101010100);
}

TEST_CASE("TMDS monitor: syncs on another channel than blue", "[monitors]") {
    check_control_character(2, 0b1010101011);
}

TEST_CASE("TMDS monitor: a character of another byte", "[monitors]") {
    Bench bench;
    TmdsFlowChart chart;
    chart.encode((bench.wave[static_cast<std::size_t>(pixel_at(2, 0))].data >> 8 & 0xFFU) ^ 0x40U);
    bench.character(2, 0, 1) = chart.character();
    bench.run();
    bench.check_first("tmds/data", "TMDS_IN_1", pixel_at(2, 0) + kEncoder);
}

TEST_CASE("TMDS monitor: the character of a byte that adds to the disparity", "[monitors]") {
    Bench bench;
    // Byte 0 has eight zeros more than ones; the same character again adds to that.
    for (const int x : {0, 1}) {
        const auto clock = static_cast<std::size_t>(pixel_at(0, x));
        bench.wave[clock].data = 0;
        bench.received[clock].data = 0;
        for (TmdsCharacter& character : bench.characters[clock].channels) character = 0b0100000000;
    }
    bench.run();
    bench.check_first("tmds/disparity", "TMDS_IN_1", pixel_at(0, 1) + kEncoder);
}

TEST_CASE("TMDS monitor: a pixel that comes wrong", "[monitors]") {
    Bench bench;
    bench.received[static_cast<std::size_t>(pixel_at(1, 4))].data ^= 1U;
    bench.run();
    bench.check_first("tmds/link", "DVI_IN_1", pixel_at(1, 4) + kLink);
}

TEST_CASE("TMDS monitor: a pixel that comes a clock late", "[monitors]") {
    Bench bench;
    const int from = pixel_at(1, 4);
    bench.received.insert(bench.received.begin() + from, bench.received[static_cast<std::size_t>(from) - 1]);
    bench.run();
    bench.check_first("tmds/link", "DVI_IN_1", from + kLink);
}

TEST_CASE("TMDS monitor: DE before the characters can have been found", "[monitors]") {
    Bench bench;
    bench.received[20].de = true;
    bench.run();
    bench.check_first("tmds/link", "DVI_IN_1", 20 + kLink);
}

TEST_CASE("TMDS monitor: before the end of the first vertical sync, the decoder may give blanking",
          "[monitors]") {
    Bench bench;
    for (int clock = 0; clock < 100; ++clock) bench.received[static_cast<std::size_t>(clock)] = {};
    bench.run();
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
}

TEST_CASE("TMDS monitor: a link that a fault disturbs is judged at its encoder alone", "[monitors]") {
    Bench bench(true);
    for (rtl::DviLink& link : bench.received) link.data ^= 1U;
    bench.run();
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
}

TEST_CASE("TMDS monitor: after a reset the link comes up again", "[monitors]") {
    Bench bench;
    const int reset = pixel_at(1, 5);
    for (int clock = reset; clock < static_cast<int>(bench.wave.size()); ++clock) {
        bench.wave[static_cast<std::size_t>(clock)] = {};
        bench.characters[static_cast<std::size_t>(clock) - 1] = {};
        bench.received[static_cast<std::size_t>(clock) - kLink] = {};
    }
    bench.characters.back() = {};
    bench.bench.core.pulse(bench.bench.reset, reset);
    bench.run();
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
}

}  // namespace metabuffer::test::tmds_monitor_test
