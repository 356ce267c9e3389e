#include "rtl/tmds_encoder.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "support/random_seed.h"
#include "tmds_waveform.h"

namespace metabuffer::test::tmds_encoder_test {
namespace {

using rtl::ClockGating;
using rtl::DviLink;
using rtl::TmdsEncoder;
using rtl::TmdsLink;

constexpr int kWidth = 19;
constexpr int kHeight = 5;

/// An encoder whose link plays a waveform from clock 0 on.
struct EncoderBench {
    sc_core::sc_signal<DviLink> link;
    sc_core::sc_signal<TmdsLink> tmds;
    TmdsEncoder encoder;
    Waveform wave;
    const Recording<TmdsLink>& sent;

    EncoderBench(ClockedTestbench& bench, const std::string& name, ClockGating gating = ClockGating::kOn)
        : encoder(name.c_str(), gating), sent(bench.core.record(tmds)) {
        encoder.clk_i(bench.core.clk);
        encoder.reset_i(bench.reset);
        encoder.link_i(link);
        encoder.tmds_o(tmds);
        bench.trace(encoder);
        bench.core.each_clock([this](int clock) {
            const auto index = static_cast<std::size_t>(clock);
            link.write(index < wave.size() ? wave[index] : DviLink{});
        });
    }
};

TEST_CASE("tmds encoder: a pixel's characters are on the wire a clock later, by DVI's flow chart") {
    ClockedTestbench bench;
    EncoderBench dut(bench, "encoder");
    const std::uint64_t seed = random_seed(51);
    INFO("seed " << seed);
    dut.wave = random_waveform(kWidth, kHeight, 1, 3, seed);
    const TmdsWaveform wanted = tmds_waveform(dut.wave);
    bench.run_through(static_cast<int>(wanted.size()));
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        INFO("clock " << i);
        // Edge i samples the pixel and drives its characters.
        REQUIRE(dut.sent.at(static_cast<int>(i)) == wanted[i]);
    }
}

TEST_CASE("tmds encoder: HSYNC and VSYNC are on the blue channel alone") {
    ClockedTestbench bench;
    EncoderBench dut(bench, "encoder");
    for (const bool vsync : {false, true}) {
        for (const bool hsync : {false, true}) dut.wave.push_back({0, false, hsync, vsync});
    }
    bench.run_through(6);
    CHECK(dut.sent.at(0).channels[0] == 0b1101010100);
    CHECK(dut.sent.at(1).channels[0] == 0b0010101011);
    CHECK(dut.sent.at(2).channels[0] == 0b0101010100);
    CHECK(dut.sent.at(3).channels[0] == 0b1010101011);
    for (int clock = 0; clock < 4; ++clock) {
        CHECK(dut.sent.at(clock).channels[1] == 0b1101010100);
        CHECK(dut.sent.at(clock).channels[2] == 0b1101010100);
    }
}

TEST_CASE("tmds encoder: each line begins without a disparity") {
    ClockedTestbench bench;
    EncoderBench dut(bench, "encoder");
    // The first character of byte 0 leaves a disparity, so the second one is another.
    for (int line = 0; line < 3; ++line) {
        dut.wave.push_back({0, true, false, false});
        dut.wave.push_back({0, true, false, false});
        dut.wave.push_back(DviLink{});
    }
    bench.run_through(9);
    CHECK_FALSE(dut.sent.at(0) == dut.sent.at(1));
    for (const int first : {3, 6}) {
        CHECK(dut.sent.at(first) == dut.sent.at(0));
        CHECK(dut.sent.at(first + 1) == dut.sent.at(1));
    }
}

TEST_CASE("tmds encoder: a reset drives control characters and forgets the disparity") {
    ClockedTestbench bench;
    EncoderBench dut(bench, "encoder");
    for (int i = 0; i < 12; ++i) dut.wave.push_back({0, true, false, false});
    bench.core.pulse(bench.reset, 5);
    bench.run_through(11);
    CHECK(dut.sent.at(-1) == TmdsLink{});
    CHECK(dut.sent.at(5) == TmdsLink{});
    for (int i = 0; i < 5; ++i) CHECK(dut.sent.at(6 + i) == dut.sent.at(i));
}

TEST_CASE("tmds encoder: a reset wakes a block that sleeps in a pause") {
    ClockedTestbench bench;
    EncoderBench dut(bench, "encoder");
    constexpr int kReset = 30;
    dut.wave = Waveform(60, {0, false, true, false});
    bench.core.pulse(bench.reset, kReset);
    bench.run_through(40);
    CHECK_FALSE(dut.sent.at(kReset - 1) == TmdsLink{});
    CHECK(dut.sent.at(kReset) == TmdsLink{});
    CHECK(dut.sent.at(kReset + 1) == dut.sent.at(kReset - 1));
}

TEST_CASE("tmds encoder: clock gating changes nothing, after pauses of any length") {
    ClockedTestbench bench;
    EncoderBench gated(bench, "gated");
    EncoderBench ungated(bench, "ungated", ClockGating::kOff);
    Random random(random_seed(52));
    Waveform wave;
    for (int pause = 0; pause < 40; ++pause) {
        append_line(wave, 5, {static_cast<std::uint32_t>(random.bits()) & 0xFF'FFFFU, 7}, random.one_in(3));
        wave.insert(wave.end(), static_cast<std::size_t>(random.between(0, 40)), DviLink{});
    }
    gated.wave = wave;
    ungated.wave = wave;
    bench.run_through(static_cast<int>(wave.size()));
    for (int clock = 0; clock < static_cast<int>(wave.size()); ++clock) {
        INFO("clock " << clock);
        REQUIRE(gated.sent.at(clock) == ungated.sent.at(clock));
    }
}

}  // namespace
}  // namespace metabuffer::test::tmds_encoder_test
