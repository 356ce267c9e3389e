#include "rtl/tmds_fault.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "rtl/fault_tally.h"
#include "support/scenarios.h"

namespace metabuffer::test::tmds_fault_test {
namespace {

using rtl::FaultTally;
using rtl::TmdsFault;
using rtl::TmdsLink;

constexpr int kFirstCoreCycle = 2;  // at clock 0 of a bench
constexpr int kBillion = 1'000'000'000;

/// A link with faults that flip bits at a rate.
struct NoisyLink {
    Scenario scenario = small_scenario(4, 4);
    std::deque<FaultTally> tallies{};

    explicit NoisyLink(std::vector<Fault> noise = {}) {
        scenario.clocks.core_mhz = 100.0;  // as the bench's
        scenario.faults = std::move(noise);
    }
    std::unique_ptr<TmdsFault> make(const char* name) {
        std::vector<std::size_t> indices;
        for (std::size_t i = 0; i < scenario.faults.size(); ++i) indices.push_back(i);
        return std::make_unique<TmdsFault>(name, scenario, indices,
                                           tallies.emplace_back(scenario.faults.size()));
    }
};

Fault noise(int per_billion, std::int64_t from_cycle = 0) {
    Fault fault;
    fault.kind = FaultKind::kTmdsNoise;
    fault.per_billion = per_billion;
    fault.from_cycle = from_cycle;
    return fault;
}

/// A wire of random characters, and what faults do to it. Its noise flips every bit while it lasts.
class Wire final : public Lockstep<TmdsFault> {
  public:
    Wire(LockstepBench& bench, NoisyLink& link)
        : Lockstep(bench, "wire", [&link](const char* dut, rtl::ClockGating) { return link.make(dut); }),
          link_(link),
          noisy_characters_(link.scenario.faults.size(), 0) {}

    void stimulate() override {
        Random& random = bench_.random;
        TmdsLink tmds;
        TmdsDisturbance disturbance = disturbance_in_;
        for (std::size_t channel = 0; channel < 3; ++channel) {
            tmds.channels.at(channel) = static_cast<TmdsCharacter>(random.between(0, 0x3FF));
            disturbance.flips.at(channel) =
                static_cast<TmdsCharacter>(random.one_in(8) ? random.between(0, 0x3FF) : 0);
            if (random.one_in(20)) {
                disturbance.late_bits.at(channel) = static_cast<std::uint8_t>(random.between(0, 9));
            }
            if (random.one_in(20)) {
                disturbance.late_characters.at(channel) = static_cast<std::uint8_t>(random.between(0, 4));
            }
        }
        if (!random.one_in(4)) tmds_in_ = tmds;
        disturbance_in_ = disturbance;
    }
    void expect() override {
        TmdsLink late;
        for (std::size_t channel = 0; channel < 3; ++channel) {
            std::deque<bool> bits = bits_.at(channel);
            add(bits, tmds_in_->channels.at(channel) ^ disturbance_.flips.at(channel));
            const std::size_t late_bits = disturbance_.late_bits.at(channel) +
                                          std::size_t{10} * disturbance_.late_characters.at(channel);
            unsigned word = 0;
            for (std::size_t i = 0; i < 10; ++i) {
                word |= (bits.at(bits.size() - 10 - late_bits + i) ? 1U : 0U) << i;
            }
            late.channels.at(channel) = static_cast<TmdsCharacter>(word);
        }
        tmds_ = late;
    }
    void edge() override {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            add(bits_.at(channel), tmds_in_->channels.at(channel) ^ disturbance_.flips.at(channel));
        }
        disturbance_ = disturbance_in_;
        for (std::size_t i = 0; i < noisy_characters_.size(); ++i) {
            const Fault& fault = link_.scenario.faults[i];
            const int cycle = bench_.clock() + kFirstCoreCycle;
            if (cycle < fault.from_cycle || cycle >= fault.from_cycle + *fault.cycles) continue;
            for (TmdsCharacter& flips : disturbance_.flips) flips ^= 0x3FFU;
            noisy_characters_[i] += 3;
        }
    }
    void reset() override {
        disturbance_ = {};
        bits_ = {};
        for (auto& bits : bits_) {
            for (int i = 0; i < 5; ++i) add(bits, 0b1101010100);  // the control character of no syncs
        }
    }
    void check_counts() const {
        for (std::size_t i = 0; i < noisy_characters_.size(); ++i) {
            CHECK(link_.tallies.front().count(i) == noisy_characters_[i]);
        }
    }

  private:
    static void add(std::deque<bool>& bits, unsigned character) {
        for (unsigned i = 0; i < 10; ++i) bits.push_back((character >> i & 1U) != 0);
        if (bits.size() > 60) bits.erase(bits.begin(), bits.begin() + 10);
    }

    const NoisyLink& link_;
    Input<TmdsDisturbance>& disturbance_in_ = in(&TmdsFault::disturbance_i);
    Input<TmdsLink>& tmds_in_ = in(&TmdsFault::tmds_i);
    Output<TmdsLink>& tmds_ = out(&TmdsFault::tmds_o);
    TmdsDisturbance disturbance_;                 ///< of the characters that come next
    std::array<std::deque<bool>, 3> bits_;        ///< before them, disturbed
    std::vector<std::int64_t> noisy_characters_;  ///< by fault
};

TEST_CASE("tmds fault: in lockstep with its reference") {
    constexpr int kClocks = 15'000;
    LockstepBench bench(3308);
    std::vector<Fault> faults;
    for (int clock = 0; clock < kClocks; clock += bench.random.between(1, 600)) {
        faults.push_back(noise(kBillion, clock));
        faults.back().cycles = bench.random.between(1, 300);
    }
    NoisyLink link(faults);
    const Wire wire(bench, link);
    bench.run(kClocks);
    wire.check_counts();
}

TEST_CASE("tmds fault: noise has its rate and every seed, link, channel and clock has noise of its own") {
    constexpr int kClocks = 1000;
    constexpr int kPerMille = 200;
    LockstepBench bench;
    std::deque<NoisyLink> links;
    /// Flipped bits of a link, by channel and clock.
    class Watch final : public Lockstep<TmdsFault> {
      public:
        Watch(LockstepBench& bench, NoisyLink& link, const std::string& name)
            : Lockstep(bench, name, [&link](const char* dut, rtl::ClockGating) { return link.make(dut); }) {}
        void expect() override { tmds_.ignore(); }
        void edge() override {
            for (std::size_t channel = 0; channel < 3; ++channel) {
                flips.at(channel).push_back(tmds_.seen().channels.at(channel) ^
                                            tmds_in_->channels.at(channel));
            }
        }
        std::array<std::vector<unsigned>, 3> flips;

      private:
        Input<TmdsDisturbance>& disturbance_in_ = in(&TmdsFault::disturbance_i);
        Input<TmdsLink>& tmds_in_ = in(&TmdsFault::tmds_i);
        Output<TmdsLink>& tmds_ = out(&TmdsFault::tmds_o);
    };
    std::deque<Watch> watches;
    for (const std::uint64_t seed : {5U, 6U}) {
        for (int renderer = 0; renderer < 4; ++renderer) {
            links.emplace_back(std::vector<Fault>{noise(kPerMille * (kBillion / 1000))});
            links.back().scenario.faults[0].seed = seed;
            links.back().scenario.faults[0].renderer = renderer;
            watches.emplace_back(bench, links.back(), "wire_" + std::to_string(watches.size()));
        }
    }
    bench.run(kClocks);
    std::vector<std::vector<unsigned>> streams;
    for (std::size_t i = 0; i < watches.size(); ++i) {
        int characters = 0;
        for (const std::vector<unsigned>& stream : watches[i].flips) {
            int bits = 0;
            for (unsigned flips : stream) {
                characters += flips != 0 ? 1 : 0;
                for (; flips != 0; flips &= flips - 1) ++bits;
            }
            // Four times the deviation that chance gives.
            CHECK(std::abs(bits - 10 * kClocks * kPerMille / 1000) < 160);
            streams.push_back(stream);
        }
        // Noise of the last edge has not been seen yet.
        CHECK(std::abs(links[i].tallies.front().count(0) - characters) <= 3);
    }
    const auto differing = [](const std::vector<unsigned>& a, const std::vector<unsigned>& b,
                              std::size_t later) {
        int count = 0;
        for (std::size_t i = 0; i + later < a.size(); ++i) count += a[i] != b[i + later] ? 1 : 0;
        return count;
    };
    for (std::size_t i = 0; i < streams.size(); ++i) {
        CHECK(differing(streams[i], streams[i], 1) > kClocks / 2);
        for (std::size_t other = 0; other < i; ++other)
            CHECK(differing(streams[i], streams[other], 0) > kClocks / 2);
    }
}

TEST_CASE("tmds fault: timing: characters that are not disturbed") {
    NoisyLink link;
    LockstepBench bench;
    WaveformCase<TmdsFault> dut(bench, "wire",
                                [&link](const char* name, rtl::ClockGating) { return link.make(name); });
    const TmdsLink a{{0x001, 0x002, 0x003}}, b{{0x011, 0x012, 0x013}}, wrong{{0x010, 0x012, 0x013}};
    dut.drive("..ab.b.", &TmdsFault::tmds_i, {{'a', a}, {'b', b}});
    dut.drive("....f..", &TmdsFault::disturbance_i, {{'f', {{0x001, 0, 0}, {}, {}}}});
    dut.check("..ab.w.", &TmdsFault::tmds_o, {{'a', a}, {'b', b}, {'w', wrong}});
    dut.run();
}

}  // namespace
}  // namespace metabuffer::test::tmds_fault_test
