#include "monitors/tmds_monitor.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "rule_table.h"
#include "support/random_seed.h"
#include "tmds_waveform.h"

namespace metabuffer::test::tmds_monitor_test {

namespace {

constexpr int kWidth = 14;
constexpr int kHeight = 3;
constexpr int kSyncLines = 2;
constexpr int kFrames = 2;
constexpr int kFirstSync = kSyncLines * line_clocks(kWidth);
constexpr int kEncoder = 1;  ///< clocks from a pixel to its characters
constexpr int kLink = 7;     ///< and to the pixel at the other end

/// The clock of a pixel in the first frame.
constexpr int pixel_at(int line, int x) { return kFirstSync + clock_in_frame(kWidth, x, line); }

/// A monitor on a link whose waveforms a test writes: pixels, characters a clock later, and pixels at the other end.
struct TmdsBench : ClockedRuleBench {
    sc_core::sc_signal<bool> reset{"reset", true};
    sc_core::sc_signal<rtl::DviLink> link;
    sc_core::sc_signal<rtl::TmdsLink> tmds;
    sc_core::sc_signal<rtl::DviLink> seen;
    monitors::TmdsMonitor monitor;
    Waveform wave = random_waveform(kWidth, kHeight, kSyncLines, kFrames, random_seed(101));
    TmdsWaveform characters = tmds_waveform(wave);
    Waveform received = wave;
    int reset_at = -1;

    TmdsBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench, bool disturbed = false)
        : ClockedRuleBench(name, testbench),
          monitor("tmds_monitor", {"TMDS_IN_1", "DVI_IN_1", "dvi_in", disturbed}, log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(reset);
        monitor.link_i(link);
        monitor.tmds_i(tmds);
        monitor.seen_i(seen);
        // What edge n samples: a pixel, the characters of the one before it, and the pixel of seven clocks ago.
        bench.core.each_clock([this](int clock) {
            reset.write(clock == reset_at);
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
};

Reported on_tmds(const std::string& rule, int line, int x) {
    return {rule, "TMDS_IN_1", pixel_at(line, x) + kEncoder, -1, "dvi_in"};
}
Reported on_link(int clock) { return {"tmds/link", "DVI_IN_1", clock + kLink, -1, "dvi_in"}; }

/// A character of a line's front porch, where all control characters are of two bits 0.
std::function<void(TmdsBench&)> in_the_porch(std::size_t channel, TmdsCharacter character) {
    return [=](TmdsBench& bench) { bench.character(1, kWidth + 2, channel) = character; };
}

}  // namespace

TEST_CASE("TMDS monitor: its rules in a table", "[monitors]") {
    ClockedRuleTable<TmdsBench> rules;
    rules.of();
    rules.row("a link by the rules", {}, {}, [](const auto& bench) {
        CHECK(bench.monitor.pixels() == kFrames * kWidth * kHeight);
        CHECK(bench.monitor.unreported() == 0);
    });
    rules.row("a character that no encoder sends", {on_tmds("tmds/character", 1, 5)},
              [](auto& bench) { bench.character(1, 5, 2) = 0b1010101010; });
    rules.row("a control character in a pixel", {on_tmds("tmds/control", 1, 5), kOthers},
              [](auto& bench) { bench.character(1, 5, 1) = 0b1101010100; });
    rules.row("the character of a pixel in blanking", {on_tmds("tmds/control", 1, kWidth + 2)},
              [](auto& bench) { bench.character(1, kWidth + 2, 0) = bench.character(1, 3, 0); });
    rules.row("HSYNC that the link has not", {on_tmds("tmds/control", 1, kWidth + 2)},
              in_the_porch(0, 0b0010101011));
    rules.row("VSYNC that the link has not", {on_tmds("tmds/control", 1, kWidth + 2)},
              in_the_porch(0, 0b0101010100));
    rules.row("syncs on another channel than blue", {on_tmds("tmds/control", 1, kWidth + 2)},
              in_the_porch(2, 0b1010101011));
    rules.row("the character of another byte", {on_tmds("tmds/data", 2, 0)}, [](auto& bench) {
        TmdsFlowChart chart;
        chart.encode((bench.wave[static_cast<std::size_t>(pixel_at(2, 0))].data >> 8 & 0xFFU) ^ 0x40U);
        bench.character(2, 0, 1) = chart.character();
    });
    rules.row("a character that adds to the disparity", {on_tmds("tmds/disparity", 0, 1)}, [](auto& bench) {
        // Byte 0 has eight zeros more than ones; the same character again adds to that.
        for (const int x : {0, 1}) {
            const auto clock = static_cast<std::size_t>(pixel_at(0, x));
            bench.wave[clock].data = bench.received[clock].data = 0;
            for (TmdsCharacter& character : bench.characters[clock].channels) character = 0b0100000000;
        }
    });
    rules.row("a pixel comes wrong", {on_link(pixel_at(1, 4))},
              [](auto& bench) { bench.received[static_cast<std::size_t>(pixel_at(1, 4))].data ^= 1U; });
    rules.row("a pixel comes a clock late", {on_link(pixel_at(1, 4))}, [](auto& bench) {
        const auto from = bench.received.begin() + pixel_at(1, 4);
        bench.received.insert(from, rtl::DviLink(*(from - 1)));
    });
    rules.row("DE before the characters can have been found", {on_link(20)},
              [](auto& bench) { bench.received[20].de = true; });
    rules.row("blanking before the end of the first vertical sync", {},
              [](auto& bench) { std::fill_n(bench.received.begin(), 100, rtl::DviLink{}); });
    rules.row("after a reset the link comes up again", {}, [](auto& bench) {
        const int reset = bench.reset_at = pixel_at(1, 5);
        for (int clock = reset; clock < static_cast<int>(bench.wave.size()); ++clock) {
            bench.wave[static_cast<std::size_t>(clock)] = {};
            bench.characters[static_cast<std::size_t>(clock) - 1] = {};
            bench.received[static_cast<std::size_t>(clock) - kLink] = {};
        }
        bench.characters.back() = {};
    });
    rules.of(true);
    rules.row("a link that a fault disturbs is judged at its encoder alone", {}, [](auto& bench) {
        for (rtl::DviLink& link : bench.received) link.data ^= 1U;
    });
    rules.run_and_check(static_cast<int>(random_waveform(kWidth, kHeight, kSyncLines, kFrames, 1).size()) +
                        10);
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

}  // namespace metabuffer::test::tmds_monitor_test
