#include "rtl/tmds_fault.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/fault_tally.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "tmds_waveform.h"

namespace metabuffer::test::tmds_fault_test {
namespace {

using rtl::FaultTally;
using rtl::TmdsFault;
using rtl::TmdsLink;

constexpr int kClocks = 400;

/// A wire of characters behind a fault. The source says of each clock's pixel what goes wrong with it, and the encoder's
/// characters of that pixel come a clock later.
struct WireBench {
    Scenario scenario;
    FaultTally tally;
    sc_core::sc_signal<TmdsDisturbance> disturbance;
    sc_core::sc_signal<TmdsLink> encoded;
    sc_core::sc_signal<TmdsLink> wire;
    TmdsFault fault;
    TmdsWaveform wave;                          ///< by the clock of the pixel
    std::vector<TmdsDisturbance> disturbances;  ///< likewise
    const Recording<TmdsLink>& received;

    WireBench(ClockedTestbench& bench, const std::string& name, Scenario with = {})
        : scenario(std::move(with)),
          tally(scenario.faults.size()),
          fault(name.c_str(), scenario, indices(scenario.faults.size()), tally),
          disturbances(kClocks),
          received(bench.core.record_sampled(wire)) {
        scenario.clocks.core_mhz = 1e6 / ClockedTestbench::kCorePeriodPicoseconds;
        Random random(random_seed(81));
        for (int clock = 0; clock < kClocks; ++clock) {
            TmdsLink link;
            for (TmdsCharacter& character : link.channels) {
                character = static_cast<TmdsCharacter>(random.between(0, 0x3FF));
            }
            wave.push_back(link);
        }
        fault.clk_i(bench.core.clk);
        fault.reset_i(bench.reset);
        fault.disturbance_i(disturbance);
        fault.tmds_i(encoded);
        fault.tmds_o(wire);
        bench.trace(fault);
        // Edge n samples the pixel of clock n, and drives its characters; edge n + 1 samples those.
        bench.core.each_clock([this](int clock) {
            if (clock < kClocks) disturbance.write(disturbances[static_cast<std::size_t>(clock)]);
            if (clock >= 1 && clock <= kClocks) encoded.write(wave[static_cast<std::size_t>(clock) - 1]);
        });
    }
    static std::vector<std::size_t> indices(std::size_t count) {
        std::vector<std::size_t> list;
        for (std::size_t i = 0; i < count; ++i) list.push_back(i);
        return list;
    }
    /// The characters of a pixel as the decoder samples them, if they are not late.
    const TmdsLink& of_pixel(int clock) const { return received.at(clock + 1); }
    const TmdsLink& sent(int clock) const { return wave[static_cast<std::size_t>(clock)]; }
};

Scenario noisy(int per_billion, std::int64_t from_cycle, std::optional<std::int64_t> cycles,
               std::uint64_t seed) {
    Scenario scenario = small_scenario(4, 4);
    scenario.clocks.core_mhz = 1e6 / ClockedTestbench::kCorePeriodPicoseconds;
    Fault fault;
    fault.kind = FaultKind::kTmdsNoise;
    fault.per_billion = per_billion;
    fault.from_cycle = from_cycle;
    fault.cycles = cycles;
    fault.seed = seed;
    scenario.faults.push_back(fault);
    return scenario;
}

int flipped_bits(const TmdsLink& a, const TmdsLink& b) {
    int count = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        for (unsigned bits = a.channels[channel] ^ b.channels[channel]; bits != 0; bits &= bits - 1) ++count;
    }
    return count;
}

TEST_CASE("tmds fault: undisturbed characters pass without a clock between") {
    ClockedTestbench bench;
    WireBench dut(bench, "wire");
    bench.run_through(kClocks);
    for (int clock = 0; clock < kClocks - 1; ++clock) {
        INFO("clock " << clock);
        CHECK(dut.of_pixel(clock) == dut.sent(clock));
    }
}

TEST_CASE(
    "tmds fault: bits are flipped in the characters of the pixel with which that is said, and in no other") {
    ClockedTestbench bench;
    WireBench dut(bench, "wire");
    dut.disturbances[50].flips = {0x001, 0, 0x3FF};
    dut.disturbances[51].flips = {0, 0x200, 0};
    bench.run_through(kClocks);
    for (int clock = 0; clock < kClocks - 1; ++clock) {
        TmdsLink wanted = dut.sent(clock);
        for (std::size_t channel = 0; channel < 3; ++channel) {
            wanted.channels[channel] ^= dut.disturbances[static_cast<std::size_t>(clock)].flips[channel];
        }
        INFO("clock " << clock);
        CHECK(dut.of_pixel(clock) == wanted);
    }
}

TEST_CASE("tmds fault: a channel comes late by bits and by characters, and with flipped bits") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<WireBench>> benches;
    for (unsigned late = 0; late < 50; ++late) {
        benches.push_back(std::make_unique<WireBench>(bench, "late_" + std::to_string(late)));
        for (TmdsDisturbance& disturbance : benches.back()->disturbances) {
            disturbance.late_bits = {static_cast<std::uint8_t>(late % 10), 0, 3};
            disturbance.late_characters = {static_cast<std::uint8_t>(late / 10), 2, 0};
        }
        benches.back()->disturbances[70].flips = {0x081, 0x3, 0x200};
    }
    bench.run_through(kClocks);
    for (unsigned late = 0; late < 50; ++late) {
        const WireBench& dut = *benches[late];
        INFO(dut.fault.name());
        TmdsStreams streams;
        for (int clock = 0; clock < kClocks; ++clock) {
            for (std::size_t channel = 0; channel < 3; ++channel) {
                const TmdsCharacter flips = clock == 70 ? dut.disturbances[70].flips[channel] : 0;
                streams[channel].push_back(
                    static_cast<TmdsCharacter>(dut.sent(clock).channels[channel] ^ flips));
            }
        }
        const TmdsWaveform wanted = tmds_waveform(late_streams(streams, {late, 20, 3}));
        int differing = 0;
        // What comes before the first character is not checked.
        for (int clock = 6; clock < kClocks - 1; ++clock) {
            differing += dut.of_pixel(clock) == wanted[static_cast<std::size_t>(clock)] ? 0 : 1;
        }
        CHECK(differing == 0);
    }
}

TEST_CASE("tmds fault: a channel that comes late from a pixel on is in step before it") {
    ClockedTestbench bench;
    WireBench dut(bench, "wire");
    for (int clock = 100; clock < 200; ++clock) {
        dut.disturbances[static_cast<std::size_t>(clock)].late_characters = {0, 3, 0};
    }
    bench.run_through(kClocks);
    CHECK(dut.of_pixel(99) == dut.sent(99));
    CHECK(dut.of_pixel(100).channels[1] == dut.sent(97).channels[1]);
    CHECK(dut.of_pixel(100).channels[0] == dut.sent(100).channels[0]);
    CHECK(dut.of_pixel(199).channels[1] == dut.sent(196).channels[1]);
    CHECK(dut.of_pixel(200) == dut.sent(200));
}

TEST_CASE("tmds fault: noise flips bits at its rate while it lasts, and counts the characters") {
    ClockedTestbench bench;
    constexpr int kFrom = 100;
    constexpr int kDuring = 200;
    WireBench dut(bench, "wire", noisy(100'000'000, kFrom, kDuring, 5));  // one bit in ten
    bench.run_through(kClocks);
    int bits = 0;
    int characters = 0;
    int first = -1;
    int last = -1;
    for (int clock = 0; clock < kClocks - 1; ++clock) {
        const int flipped = flipped_bits(dut.of_pixel(clock), dut.sent(clock));
        bits += flipped;
        for (std::size_t channel = 0; channel < 3; ++channel) {
            characters += dut.of_pixel(clock).channels[channel] != dut.sent(clock).channels[channel] ? 1 : 0;
        }
        if (flipped == 0) continue;
        if (first < 0) first = clock;
        last = clock;
    }
    CHECK(dut.tally.count(0) == characters);
    CHECK(bits > 30 * kDuring / 10 * 8 / 10);
    CHECK(bits < 30 * kDuring / 10 * 12 / 10);
    // Core cycles count the edges in reset, and the edge of cycle n drives what the edge after it samples.
    const int reset_clocks = bench.core.reset_clocks();
    CHECK(first >= kFrom - reset_clocks);
    CHECK(first <= kFrom - reset_clocks + 3);
    CHECK(last < kFrom - reset_clocks + kDuring);
    CHECK(last >= kFrom - reset_clocks + kDuring - 4);
}

TEST_CASE("tmds fault: noise depends on its seed, and flips every bit of a billion in a billion") {
    ClockedTestbench bench;
    WireBench one(bench, "one", noisy(50'000'000, 0, std::nullopt, 5));
    WireBench same(bench, "same", noisy(50'000'000, 0, std::nullopt, 5));
    WireBench other(bench, "other", noisy(50'000'000, 0, std::nullopt, 6));
    WireBench all(bench, "all", noisy(1'000'000'000, 0, std::nullopt, 7));
    bench.run_through(kClocks);
    int differ = 0;
    for (int clock = 0; clock < kClocks - 1; ++clock) {
        CHECK(one.of_pixel(clock) == same.of_pixel(clock));
        differ += one.of_pixel(clock) == other.of_pixel(clock) ? 0 : 1;
        CHECK(flipped_bits(all.of_pixel(clock), all.sent(clock)) == 30);
    }
    CHECK(differ > kClocks / 2);
}

TEST_CASE("tmds fault: every link, channel and clock has noise of its own") {
    ClockedTestbench bench;
    constexpr int kLinks = 8;
    std::vector<std::unique_ptr<WireBench>> wires;
    for (int renderer = 0; renderer < kLinks; ++renderer) {
        Scenario scenario = noisy(200'000'000, 0, std::nullopt, 5);
        scenario.faults[0].renderer = renderer;
        wires.push_back(
            std::make_unique<WireBench>(bench, "wire_" + std::to_string(renderer), std::move(scenario)));
    }
    bench.run_through(kClocks);
    // By link and channel: which bits are flipped at each clock.
    std::vector<std::vector<unsigned>> flips;
    for (const auto& wire : wires) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            std::vector<unsigned>& of_channel = flips.emplace_back();
            for (int clock = 0; clock < kClocks - 1; ++clock) {
                of_channel.push_back(wire->of_pixel(clock).channels[channel] ^
                                     wire->sent(clock).channels[channel]);
            }
        }
    }
    const auto differ = [](const std::vector<unsigned>& a, const std::vector<unsigned>& b,
                           std::size_t later) {
        int count = 0;
        for (std::size_t i = 0; i + later < a.size(); ++i) count += a[i] != b[i + later] ? 1 : 0;
        return count;
    };
    for (std::size_t i = 0; i < flips.size(); ++i) {
        INFO("link " << i / 3 << ", channel " << i % 3);
        CHECK(differ(flips[i], flips[i], 1) > kClocks / 2);
        for (std::size_t other = 0; other < i; ++other)
            CHECK(differ(flips[i], flips[other], 0) > kClocks / 2);
    }
}

TEST_CASE("tmds fault: a reset forgets what is late") {
    ClockedTestbench bench;
    WireBench dut(bench, "wire");
    for (int clock = 0; clock < 120; ++clock) {
        dut.disturbances[static_cast<std::size_t>(clock)].late_characters = {4, 4, 4};
    }
    bench.core.pulse(bench.reset, 120);
    bench.run_through(kClocks);
    CHECK(dut.of_pixel(119) == dut.sent(115));
    for (int clock = 120; clock < kClocks - 1; ++clock) CHECK(dut.of_pixel(clock) == dut.sent(clock));
}

}  // namespace
}  // namespace metabuffer::test::tmds_fault_test
