#include "rtl/tmds_decoder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "support/random_seed.h"
#include "tmds_waveform.h"

namespace metabuffer::test::tmds_decoder_test {
namespace {

using rtl::ClockGating;
using rtl::DviLink;
using rtl::TmdsDecoder;
using rtl::TmdsLink;

constexpr int kWidth = 19;
constexpr int kHeight = 4;
constexpr int kLine = line_clocks(kWidth);
constexpr int kFrame = frame_clocks(kWidth, kHeight);
/// From the edge that samples a pixel's characters to the one that drives the pixel.
constexpr int kDelay = 5;
/// Clocks of the vertical sync that waveforms begin with.
constexpr int kFirstSync = 2 * kLine;

/// A decoder that receives a waveform of characters from clock 0 on.
struct DecoderBench {
    sc_core::sc_signal<TmdsLink> tmds;
    sc_core::sc_signal<DviLink> link;
    TmdsDecoder decoder;
    TmdsWaveform wave;
    const Recording<DviLink>& seen;

    DecoderBench(ClockedTestbench& bench, const std::string& name, TmdsWaveform with,
                 ClockGating gating = ClockGating::kOn)
        : decoder(name.c_str(), gating), wave(std::move(with)), seen(bench.core.record(link)) {
        decoder.clk_i(bench.core.clk);
        decoder.reset_i(bench.reset);
        decoder.tmds_i(tmds);
        decoder.link_o(link);
        bench.trace(decoder);
        bench.core.each_clock([this](int clock) {
            const auto index = static_cast<std::size_t>(clock);
            tmds.write(index < wave.size() ? wave[index] : TmdsLink{});
        });
    }
};

Waveform random_frames(int frames, std::uint64_t seed) {
    return random_waveform(kWidth, kHeight, kFirstSync / kLine, frames, seed);
}

/// Where frame n of such a waveform begins.
constexpr int frame_start(int frame) { return kFirstSync + frame * kFrame; }
constexpr int pixel_at(int frame, int line, int x) {
    return frame_start(frame) + clock_in_frame(kWidth, x, line);
}

/// The first clock of the waveform from `first` on, up to `end`, whose pixel is not there when it should be; -1: none.
int first_wrong(const Recording<DviLink>& seen, const Waveform& wave, int first, int end) {
    for (int clock = first; clock < end; ++clock) {
        if (!(seen.at(clock + kDelay) == wave[static_cast<std::size_t>(clock)])) return clock;
    }
    return -1;
}

/// Clocks from `first` up to `end` at which DE is not as it was sent.
int wrong_de(const Recording<DviLink>& seen, const Waveform& wave, int first, int end) {
    int count = 0;
    for (int clock = first; clock < end; ++clock) {
        count += seen.at(clock + kDelay).de != wave[static_cast<std::size_t>(clock)].de ? 1 : 0;
    }
    return count;
}

int length(const Waveform& wave) { return static_cast<int>(wave.size()) - 10; }

TEST_CASE("tmds decoder: a pixel is there six clocks after its characters, once characters have been found") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(3, random_seed(61));
    DecoderBench dut(bench, "decoder", tmds_waveform(wave));
    CHECK(kTmdsDecoderClocks == kDelay + 1);
    bench.run_through(static_cast<int>(wave.size()));
    CHECK(first_wrong(dut.seen, wave, kLine, length(wave)) == -1);
    // The characters of the reset count, too: the twelfth in a row is there at this edge.
    constexpr int kFound = kTmdsAlignmentRun - 1;
    CHECK(dut.seen.at(kFound - 1) == DviLink{});
    CHECK(dut.seen.at(kFound).vsync);
}

TEST_CASE("tmds decoder: every skew of up to four characters is removed from the second line on") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, random_seed(62));
    const TmdsStreams streams = tmds_streams(wave);
    std::vector<std::unique_ptr<DecoderBench>> benches;
    for (unsigned skew = 0; skew < 125; ++skew) {
        const std::array<unsigned, 3> late{skew % 5 * 10, skew / 5 % 5 * 10, skew / 25 * 10};
        if (*std::min_element(late.begin(), late.end()) > 0) continue;
        benches.push_back(std::make_unique<DecoderBench>(
            bench,
            "late_" + std::to_string(late[0]) + "_" + std::to_string(late[1]) + "_" + std::to_string(late[2]),
            tmds_waveform(late_streams(streams, late))));
    }
    CHECK(benches.size() == 61);
    bench.run_through(static_cast<int>(wave.size()));
    for (const auto& dut : benches) {
        INFO(dut->decoder.name());
        CHECK(first_wrong(dut->seen, wave, pixel_at(0, 1, 0) - 8, length(wave)) == -1);
    }
}

TEST_CASE(
    "tmds decoder: skew is measured by lines behind eight control characters, and by none behind fewer") {
    constexpr int kLines = 4;
    ClockedTestbench bench;
    std::vector<std::unique_ptr<DecoderBench>> benches;
    std::vector<Waveform> waves;
    for (const int pause : {kTmdsPauseBeforeLine - 1, kTmdsPauseBeforeLine}) {
        Random random(random_seed(69));
        Waveform wave;
        append_blank_lines(wave, kWidth, kFirstSync / kLine, true);
        for (int line = 0; line < kLines; ++line) {
            for (int x = 0; x < kWidth; ++x) {
                wave.push_back({static_cast<std::uint32_t>(random.bits()) & 0xFF'FFFFU, true, false, true});
            }
            wave.insert(wave.end(), static_cast<std::size_t>(pause), DviLink{0, false, false, true});
        }
        append_blank_lines(wave, kWidth, 1, true);
        // Green comes two characters late.
        benches.push_back(
            std::make_unique<DecoderBench>(bench, "pause_" + std::to_string(pause),
                                           tmds_waveform(late_streams(tmds_streams(wave), {0, 20, 0}))));
        waves.push_back(std::move(wave));
    }
    bench.run_through(static_cast<int>(waves.back().size()));
    const auto last_line_is_right = [&](std::size_t i, int pause) {
        const int first = kFirstSync + (kLines - 1) * (kWidth + pause);
        return first_wrong(benches[i]->seen, waves[i], first, first + kWidth) == -1;
    };
    CHECK_FALSE(last_line_is_right(0, kTmdsPauseBeforeLine - 1));
    CHECK(last_line_is_right(1, kTmdsPauseBeforeLine));
}

TEST_CASE("tmds decoder: channels whose words begin anywhere in characters, and come late besides") {
    const std::uint64_t seed = random_seed(63);
    INFO("seed " << seed);
    Random random(seed);
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, seed);
    const TmdsStreams streams = tmds_streams(wave);
    std::vector<std::unique_ptr<DecoderBench>> benches;
    for (unsigned i = 0; i < 60; ++i) {
        std::array<unsigned, 3> late{};
        for (unsigned& bits : late) bits = static_cast<unsigned>(random.between(0, 49));
        if (i < 30) late = {i % 10, (i + i / 10) % 10, (3 * i) % 10};
        late[i % 3] = i % 10;  // the one that comes first
        benches.push_back(
            std::make_unique<DecoderBench>(bench,
                                           "late_" + std::to_string(i) + "_by_" + std::to_string(late[0]) +
                                               "_" + std::to_string(late[1]) + "_" + std::to_string(late[2]),
                                           tmds_waveform(late_streams(streams, late))));
    }
    bench.run_through(static_cast<int>(wave.size()));
    for (const auto& dut : benches) {
        INFO(dut->decoder.name());
        CHECK(first_wrong(dut->seen, wave, pixel_at(0, 1, 0) - 8, length(wave)) == -1);
    }
}

TEST_CASE("tmds decoder: a channel that slips gives wrong bytes up to the next pause, and no wrong DE") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, random_seed(64));
    const TmdsStreams streams = tmds_streams(wave);
    const int slip = pixel_at(0, 1, 6);
    std::vector<std::unique_ptr<DecoderBench>> benches;
    for (unsigned channel = 0; channel < 3; ++channel) {
        for (unsigned bits = 1; bits < 10; ++bits) {
            TmdsStreams slipped = streams;
            const std::vector<TmdsCharacter> late = late_words(streams[channel], bits);
            std::copy(late.begin() + slip, late.end(), slipped[channel].begin() + slip);
            benches.push_back(std::make_unique<DecoderBench>(
                bench, "channel_" + std::to_string(channel) + "_bits_" + std::to_string(bits),
                tmds_waveform(slipped)));
        }
    }
    bench.run_through(static_cast<int>(wave.size()));
    for (std::size_t i = 0; i < benches.size(); ++i) {
        const DecoderBench& dut = *benches[i];
        INFO(dut.decoder.name());
        const std::uint32_t channel_bits = 0xFFU << (8 * (i / 9));
        CHECK(first_wrong(dut.seen, wave, kLine, slip) == -1);
        int wrong_pixels = 0;
        for (int clock = slip; clock < pixel_at(0, 1, kWidth); ++clock) {
            const DviLink& seen = dut.seen.at(clock + kDelay);
            const DviLink& sent = wave[static_cast<std::size_t>(clock)];
            CHECK(seen.de);
            CHECK(((seen.data ^ sent.data) & ~channel_bits) == 0);
            wrong_pixels += seen.data != sent.data ? 1 : 0;
        }
        CHECK(wrong_pixels > 0);
        CHECK(wrong_de(dut.seen, wave, slip, pixel_at(0, 2, 0)) == 0);
        CHECK(first_wrong(dut.seen, wave, pixel_at(0, 2, 0), length(wave)) == -1);
    }
}

TEST_CASE(
    "tmds decoder: a skew that changes in a line is removed after two more, and no line changes its length") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, random_seed(65));
    const TmdsStreams streams = tmds_streams(wave);
    const int change = pixel_at(0, 0, 9);
    std::vector<std::unique_ptr<DecoderBench>> benches;
    for (unsigned channel = 0; channel < 3; ++channel) {
        for (unsigned characters = 1; characters <= 4; ++characters) {
            TmdsStreams skewed = streams;
            const std::vector<TmdsCharacter> late = late_words(streams[channel], 10 * characters);
            std::copy(late.begin() + change, late.end(), skewed[channel].begin() + change);
            benches.push_back(std::make_unique<DecoderBench>(
                bench, "channel_" + std::to_string(channel) + "_by_" + std::to_string(characters),
                tmds_waveform(skewed)));
        }
    }
    bench.run_through(static_cast<int>(wave.size()));
    for (const auto& dut : benches) {
        INFO(dut->decoder.name());
        CHECK(first_wrong(dut->seen, wave, kLine, change) == -1);
        CHECK(wrong_de(dut->seen, wave, change, length(wave)) == 0);
        // Lines 1 and 2 begin with the new skew.
        CHECK(first_wrong(dut->seen, wave, pixel_at(0, 1, 0), pixel_at(0, 2, 0)) != -1);
        CHECK(first_wrong(dut->seen, wave, pixel_at(0, 2, 0), length(wave)) == -1);
    }
}

TEST_CASE("tmds decoder: any bits that flip in a pixel change the bytes of that pixel and nothing else") {
    const std::uint64_t seed = random_seed(66);
    INFO("seed " << seed);
    Random random(seed);
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, seed);
    std::vector<std::unique_ptr<DecoderBench>> benches;
    std::vector<int> places;
    for (int i = 0; i < 60; ++i) {
        TmdsWaveform flipped = tmds_waveform(wave);
        const int place = pixel_at(0, random.between(0, kHeight - 1), random.between(0, kWidth - 1));
        TmdsCharacter& character = flipped[static_cast<std::size_t>(place)].channels[i % 3];
        // Of the last ones every bit, so that control characters are among them.
        character = i < 48 ? static_cast<TmdsCharacter>(character ^ random.between(1, 0x3FF))
                           : kTmdsControl[static_cast<std::size_t>(i) % 4];
        places.push_back(place);
        benches.push_back(
            std::make_unique<DecoderBench>(bench, "flip_" + std::to_string(i), std::move(flipped)));
    }
    bench.run_through(static_cast<int>(wave.size()));
    for (std::size_t i = 0; i < benches.size(); ++i) {
        const DecoderBench& dut = *benches[i];
        INFO(dut.decoder.name());
        CHECK(first_wrong(dut.seen, wave, kLine, places[i]) == -1);
        CHECK(first_wrong(dut.seen, wave, places[i] + 1, length(wave)) == -1);
        const DviLink& seen = dut.seen.at(places[i] + kDelay);
        const DviLink& sent = wave[static_cast<std::size_t>(places[i])];
        CHECK(seen.de);
        CHECK(((seen.data ^ sent.data) & ~(0xFFU << (8 * (i % 3)))) == 0);
    }
}

TEST_CASE("tmds decoder: in blanking a wrong bit changes nothing, except for the one that is VSYNC on blue") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, random_seed(67));
    const int place = pixel_at(0, 1, kWidth + 4);  // front porch
    constexpr TmdsCharacter kVsyncBit = 0x200;     // control characters with and without C1 differ in it
    std::vector<std::unique_ptr<DecoderBench>> benches;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        for (TmdsCharacter bit = 1; bit < 1024; bit = static_cast<TmdsCharacter>(bit * 2)) {
            TmdsWaveform flipped = tmds_waveform(wave);
            if (channel == 0 && bit == kVsyncBit) continue;
            flipped[static_cast<std::size_t>(place)].channels[channel] ^= bit;
            benches.push_back(std::make_unique<DecoderBench>(
                bench, "channel_" + std::to_string(channel) + "_bit_" + std::to_string(bit),
                std::move(flipped)));
        }
    }
    TmdsWaveform vsync = tmds_waveform(wave);
    vsync[static_cast<std::size_t>(place)].channels[0] ^= kVsyncBit;
    DecoderBench pulse(bench, "vsync", vsync);
    TmdsWaveform unaffected = tmds_waveform(wave);
    unaffected[static_cast<std::size_t>(place)].channels[1] = 0b0101010100;
    DecoderBench green(bench, "green", unaffected);
    bench.run_through(static_cast<int>(wave.size()));
    for (const auto& dut : benches) {
        INFO(dut->decoder.name());
        CHECK(first_wrong(dut->seen, wave, kLine, length(wave)) == -1);
    }
    CHECK(first_wrong(green.seen, wave, kLine, length(wave)) == -1);
    CHECK(first_wrong(pulse.seen, wave, kLine, place) == -1);
    CHECK(pulse.seen.at(place + kDelay).vsync);
    CHECK(first_wrong(pulse.seen, wave, place + 1, length(wave)) == -1);
}

TEST_CASE("tmds decoder: a bit error that hides one line's beginning does not move a channel") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, random_seed(68));
    std::vector<std::unique_ptr<DecoderBench>> benches;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        for (int before = 1; before <= 4; ++before) {
            TmdsWaveform flipped = tmds_waveform(wave);
            flipped[static_cast<std::size_t>(pixel_at(0, 1, 0) - before)].channels[channel] ^= 0x10;
            benches.push_back(std::make_unique<DecoderBench>(
                bench, "channel_" + std::to_string(channel) + "_before_" + std::to_string(before),
                std::move(flipped)));
        }
    }
    bench.run_through(static_cast<int>(wave.size()));
    for (const auto& dut : benches) {
        INFO(dut->decoder.name());
        CHECK(first_wrong(dut->seen, wave, kLine, length(wave)) == -1);
    }
}

TEST_CASE("tmds decoder: with one channel of random bits, the others and DE stay right") {
    const std::uint64_t seed = random_seed(69);
    INFO("seed " << seed);
    Random random(seed);
    ClockedTestbench bench;
    const Waveform wave = random_frames(3, seed);
    std::vector<std::unique_ptr<DecoderBench>> benches;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        TmdsWaveform broken = tmds_waveform(wave);
        for (auto clock = static_cast<std::size_t>(frame_start(1)); clock < broken.size(); ++clock) {
            broken[clock].channels[channel] = static_cast<TmdsCharacter>(random.between(0, 0x3FF));
        }
        benches.push_back(
            std::make_unique<DecoderBench>(bench, "channel_" + std::to_string(channel), std::move(broken)));
    }
    bench.run_through(static_cast<int>(wave.size()));
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const DecoderBench& dut = *benches[channel];
        CHECK(wrong_de(dut.seen, wave, kLine, length(wave)) == 0);
        int others_wrong = 0;
        for (int clock = kLine; clock < length(wave); ++clock) {
            const std::uint32_t differs =
                dut.seen.at(clock + kDelay).data ^ wave[static_cast<std::size_t>(clock)].data;
            others_wrong += (differs & ~(0xFFU << (8 * channel))) != 0 ? 1 : 0;
        }
        CHECK(others_wrong == 0);
    }
}

TEST_CASE("tmds decoder: after a reset it gives nothing until it has found the characters again") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(2, random_seed(70));
    DecoderBench dut(bench, "decoder", tmds_waveform(wave));
    const int reset = pixel_at(0, 1, 3);
    bench.core.pulse(bench.reset, reset);
    bench.run_through(static_cast<int>(wave.size()));
    for (int clock = reset; clock < pixel_at(0, 1, kWidth) + kTmdsAlignmentRun; ++clock) {
        INFO("clock " << clock);
        CHECK(dut.seen.at(clock) == DviLink{});
    }
    CHECK(first_wrong(dut.seen, wave, pixel_at(0, 2, 0), length(wave)) == -1);
}

TEST_CASE("tmds decoder: a wrong character of blue in a pause leaves HSYNC and VSYNC as they were") {
    ClockedTestbench bench;
    const Waveform wave = random_frames(1, random_seed(71));
    TmdsWaveform sent = tmds_waveform(wave);
    int during_vsync = 0;
    int during_hsync = 0;
    for (int clock = kLine; clock < length(wave); clock += 7) {
        const DviLink& link = wave[static_cast<std::size_t>(clock)];
        const DviLink& before = wave[static_cast<std::size_t>(clock) - 1];
        // As a sync changes, a wrong character would hide that.
        if (link.de || before.hsync != link.hsync || before.vsync != link.vsync) continue;
        sent[static_cast<std::size_t>(clock)].channels[0] ^=
            1U;  // no control character is so near to another there
        during_vsync += link.vsync ? 1 : 0;
        during_hsync += link.hsync ? 1 : 0;
    }
    CHECK(during_vsync > 0);
    CHECK(during_hsync > 0);
    DecoderBench dut(bench, "decoder", std::move(sent));
    bench.run_through(static_cast<int>(wave.size()));
    int wrong = 0;
    for (int clock = kLine; clock < length(wave); ++clock) {
        const DviLink& seen = dut.seen.at(clock + kDelay);
        const DviLink& of = wave[static_cast<std::size_t>(clock)];
        wrong += seen.hsync != of.hsync || seen.vsync != of.vsync ? 1 : 0;
    }
    CHECK(wrong == 0);
}

TEST_CASE("tmds decoder: a reset wakes a block that sleeps in a pause") {
    ClockedTestbench bench;
    constexpr int kReset = 60;
    DecoderBench dut(bench, "decoder", tmds_waveform(Waveform(120, {0, false, true, false})));
    bench.core.pulse(bench.reset, kReset);
    bench.run_through(110);
    CHECK(dut.seen.at(kReset - 1).hsync);
    for (int clock = kReset; clock < kReset + kTmdsAlignmentRun; ++clock) {
        INFO("clock " << clock);
        CHECK(dut.seen.at(clock) == DviLink{});
    }
    CHECK(dut.seen.at(100).hsync);
}

TEST_CASE("tmds decoder: says what it waits for while a channel gives no control characters") {
    ClockedTestbench bench;
    TmdsLink silent;
    silent.channels[2] = 0;
    DecoderBench deaf(bench, "deaf", TmdsWaveform(200, silent));
    DecoderBench hears(bench, "hears", TmdsWaveform(200, TmdsLink{}));
    bench.run_through(150);
    CHECK(deaf.decoder.waiting_for() == "waits for control characters on every channel");
    CHECK(hears.decoder.waiting_for().empty());
}

TEST_CASE("tmds decoder: clock gating changes nothing, after pauses of any length") {
    ClockedTestbench bench;
    Random random(random_seed(71));
    Waveform wave;
    append_blank_lines(wave, 5, 1, true);
    for (int pause = 0; pause < 40; ++pause) {
        append_line(wave, 5, {static_cast<std::uint32_t>(random.bits()) & 0xFF'FFFFU, 7}, random.one_in(3));
        wave.insert(wave.end(), static_cast<std::size_t>(random.between(0, 40)), DviLink{});
    }
    const TmdsWaveform characters = tmds_waveform(late_streams(tmds_streams(wave), {3, 0, 24}));
    DecoderBench gated(bench, "gated", characters);
    DecoderBench ungated(bench, "ungated", characters, ClockGating::kOff);
    bench.run_through(static_cast<int>(characters.size()));
    for (int clock = 0; clock < static_cast<int>(characters.size()); ++clock) {
        INFO("clock " << clock);
        REQUIRE(gated.seen.at(clock) == ungated.seen.at(clock));
    }
}

}  // namespace
}  // namespace metabuffer::test::tmds_decoder_test
