#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "pixel_beat.h"
#include "rtl/bus_fault.h"
#include "rtl/fault_tally.h"
#include "rtl/handshake_fault.h"
#include "rtl/mixed_bits.h"
#include "support/scenarios.h"

namespace metabuffer::test::fault_blocks_test {
namespace {

using rtl::BusBeat;
using rtl::BusFault;
using rtl::FaultTally;
using rtl::Handshake;
using rtl::HandshakeFault;
using rtl::SwapLockFault;

constexpr int kFirstCoreCycle = 2;  // at clock 0 of a bench
constexpr std::size_t kDisplay = 1;

/// A scenario with faults, and what they have done.
struct FaultyMachine {
    Scenario scenario = small_scenario(4, 4, 2);
    std::deque<FaultTally> tallies{};

    explicit FaultyMachine(std::vector<Fault> faults) {
        scenario.clocks.core_mhz = 100.0;  // as the bench's
        scenario.bus.width_bits = 64;
        scenario.bus.grant_cycles = 1;
        scenario.memory.page_miss_cycles = 1;
        scenario.faults = std::move(faults);
    }
    std::vector<std::size_t> all() const {
        std::vector<std::size_t> indices(scenario.faults.size());
        for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i;
        return indices;
    }
    FaultTally& new_tally() { return tallies.emplace_back(scenario.faults.size()); }
    /// Of the module made last.
    std::vector<std::int64_t> counts() const {
        std::vector<std::int64_t> counts;
        for (const std::size_t fault : all()) counts.push_back(tallies.back().count(fault));
        return counts;
    }
};

/// A fault that holds a wire at these clocks of a bench; for ever if there is no last one.
Fault hold(int first, std::optional<int> last) {
    Fault fault;
    fault.kind = FaultKind::kBusreadyLow;
    fault.from_cycle = first + kFirstCoreCycle;
    if (last) fault.cycles = *last - first + 1;
    return fault;
}

/// Holds one after another, some of which overlap, from the very first edge on.
std::vector<Fault> random_holds(Random& random, int clocks) {
    std::vector<Fault> faults{hold(-kFirstCoreCycle, random.between(-kFirstCoreCycle, 0))};
    for (int clock = 0; clock < clocks; clock += random.between(1, 60)) {
        faults.push_back(hold(clock, clock + random.between(0, random.one_in(3) ? 40 : 4)));
    }
    return faults;
}

/// What of its scenario's faults holds a wire at an edge, and which of them it has changed.
class Holds {
  public:
    explicit Holds(const FaultyMachine& machine)
        : machine_(machine), took_effect_(machine.scenario.faults.size(), 0) {}

    bool at(int clock) const {
        const auto& faults = machine_.scenario.faults;
        return std::any_of(faults.begin(), faults.end(),
                           [clock](const Fault& fault) { return lasts(fault, clock); });
    }
    void take_effect(int clock) {
        for (std::size_t i = 0; i < took_effect_.size(); ++i) {
            if (lasts(machine_.scenario.faults[i], clock)) took_effect_[i] = 1;
        }
    }
    void check_counts() const { CHECK(machine_.counts() == took_effect_); }

  private:
    static bool lasts(const Fault& fault, int clock) {
        const int cycle = clock + kFirstCoreCycle;
        return fault.from_cycle <= cycle && (!fault.cycles || cycle < fault.from_cycle + *fault.cycles);
    }

    const FaultyMachine& machine_;
    std::vector<std::int64_t> took_effect_;
};

Lockstep<HandshakeFault>::Factory held_wire(FaultyMachine& machine, Handshake handshake) {
    return [&machine, handshake](const char* name, rtl::ClockGating) {
        return std::make_unique<HandshakeFault>(name, machine.scenario,
                                                rtl::HeldWire{handshake, 0, kDisplay, "WIRE"}, machine.all(),
                                                machine.new_tally());
    };
}
Lockstep<BusFault>::Factory lossy_bus(FaultyMachine& machine) {
    return [&machine](const char* name, rtl::ClockGating) {
        return std::make_unique<BusFault>(name, machine.scenario, kDisplay, machine.all(),
                                          machine.new_tally());
    };
}

class HeldWire final : public Lockstep<HandshakeFault> {
  public:
    HeldWire(LockstepBench& bench, FaultyMachine& machine, Handshake handshake, const std::string& name)
        : Lockstep(bench, name, held_wire(machine, handshake)),
          machine_(machine),
          handshake_(handshake),
          holds_(machine) {
        wires_.add(wire_in_, handshake == Handshake::kBusready ? 40 : 5);
    }

    void stimulate() override { wires_.stimulate(bench_); }
    void expect() override {
        const bool held = holds_.at(bench_.clock());
        switch (handshake_) {
            case Handshake::kStall:
                wire_ = wire_in_ || held;
                break;
            case Handshake::kPipeready:
            case Handshake::kFramedone:
                wire_ = wire_in_ && (was_high_ || !held);
                break;
            case Handshake::kBusready:
                if (held && was_high_) taken_away_at_ = bench_.clock();
                if (!was_raised_) taken_away_at_.reset();
                wire_ = wire_in_ && !held &&
                        !(taken_away_at_ && bench_.clock() < *taken_away_at_ + least_low_clocks());
                bench_.happened["BUSREADY low for as long as it must be"] +=
                    wire_ && taken_away_at_ == bench_.clock() - least_low_clocks() ? 1 : 0;
                break;
            default:
                wire_ = wire_in_ && !held;
                break;
        }
    }
    void edge() override {
        if (wire_in_ != wire_) holds_.take_effect(bench_.clock());
        const std::string report = handshake_ == Handshake::kStall ? "holds WIRE high" : "holds WIRE low";
        wrong_reports_ += dut().waiting_for() == (wire_in_ != wire_ ? report : "") ? 0 : 1;
        was_raised_ = wire_in_;
        was_high_ = wire_;
    }
    void reset() override { edge(); }
    void check_counts() const {
        holds_.check_counts();
        CHECK(wrong_reports_ == 0);
    }

  private:
    /// A burst that has just been granted opens a page, sends until the answer is back, and stops, and the composer
    /// waits for the longest gap.
    int least_low_clocks() const {
        const Scenario& scenario = machine_.scenario;
        const int beat = 64 / scenario.bus.width_bits;
        const int longest_gap = scenario.memory.page_miss_cycles + beat;
        const int loop = scenario.memory.read_latency_cycles + 2 * scenario.bus.register_stages;
        return scenario.bus.grant_cycles + 2 * longest_gap + beat + 2 + 2 * loop;
    }

    const FaultyMachine& machine_;
    Handshake handshake_;
    Holds holds_;
    Input<bool>& wire_in_ = in(&HandshakeFault::wire_i);
    Output<bool>& wire_ = out(&HandshakeFault::wire_o);
    FreeWires wires_;
    // As the last edge has sampled them.
    bool was_raised_ = false, was_high_ = false;
    std::optional<int> taken_away_at_;
    int wrong_reports_ = 0;
};

TEST_CASE("handshake fault: in lockstep with its reference") {
    constexpr int kClocks = 10'000;
    LockstepBench bench(3303);
    bench.clocks_to_reset = bench.clocks_to_pause = 0;  // they have no reset and do not sleep
    std::deque<FaultyMachine> machines;
    std::deque<HeldWire> wires;
    for (const Handshake handshake : {Handshake::kTableready, Handshake::kPairRequest, Handshake::kStall,
                                      Handshake::kPipeready, Handshake::kFramedone, Handshake::kBusready}) {
        machines.emplace_back(random_holds(bench.random, kClocks));
        wires.emplace_back(bench, machines.back(), handshake, "wire_" + std::to_string(wires.size()));
    }
    machines.emplace_back(random_holds(bench.random, kClocks));
    machines.back().scenario.bus.width_bits = 16;
    machines.back().scenario.bus.grant_cycles = 5;
    machines.back().scenario.bus.register_stages = 1;
    machines.back().scenario.memory.read_latency_cycles = 3;
    wires.emplace_back(bench, machines.back(), Handshake::kBusready, "far_busready");
    for (const int first : {-kFirstCoreCycle, 1 - kFirstCoreCycle}) {
        machines.emplace_back(std::vector<Fault>{hold(first, first)});
        wires.emplace_back(bench, machines.back(), Handshake::kStall,
                           "stall_" + std::to_string(wires.size()));
    }
    machines.emplace_back(std::vector<Fault>{hold(kClocks / 2, std::nullopt)});
    wires.emplace_back(bench, machines.back(), Handshake::kTableready, "held_for_ever");
    bench.run(kClocks, {{"BUSREADY low for as long as it must be", 50}});
    for (const HeldWire& wire : wires) wire.check_counts();
}

TEST_CASE("handshake fault: random stalls hold each wire in their share of the edges and each at others") {
    CHECK(rtl::mixed_bits(0) == 0xE220'A839'7B1D'CDAFU);  // the first number of SplitMix64
    constexpr int kEdges = 100'000;
    std::set<std::vector<bool>> sequences;
    std::size_t wires = 0;
    const auto hold_wire = [&](int percent, std::uint64_t seed, const rtl::HeldWire& wire) {
        FaultyMachine machine({random_stalls(0, percent)});
        machine.scenario.faults[0].seed = seed;
        FaultTally& tally = machine.new_tally();
        rtl::WireHolds holds(machine.scenario, wire, machine.all(), tally);
        std::vector<bool> sequence{holds.at_first_edge()};
        while (sequence.size() < kEdges && !(percent == 50 && sequence.size() == 64)) {
            const bool held = sequence.back();
            const bool counted = tally.count(0) > 0;
            sequence.push_back(holds.at_next_edge(true));
            // It has taken effect if it held the wire, and else it has not.
            REQUIRE((tally.count(0) > 0) == (held || counted));
        }
        return sequence;
    };
    for (const int percent : {5, 80}) {
        const std::vector<bool> sequence = hold_wire(percent, 1, {Handshake::kTableready, 0, 1, "WIRE"});
        const auto held = std::count(sequence.begin(), sequence.end(), true);
        // Half a percent is four times the deviation that chance gives.
        CHECK(std::abs(held - kEdges * percent / 100) < kEdges / 200);
        CHECK(sequence == hold_wire(percent, 1, {Handshake::kTableready, 0, 1, "WIRE"}));
    }
    for (const std::uint64_t seed : {1U, 2U, 7U}) {
        for (const Handshake handshake : {Handshake::kBusready, Handshake::kTableready, Handshake::kStall}) {
            for (std::size_t index = 0; index < 64; ++index, ++wires) {
                sequences.insert(hold_wire(50, seed, {handshake, index / 8, index % 8, "WIRE"}));
            }
        }
    }
    CHECK(sequences.size() == wires);
}

// clang-format off
TEST_CASE("handshake fault: timing: a wire that no fault holds or that a fault lets go to its reader") {
    FaultyMachine machine({hold(6, 8)});
    LockstepBench bench;
    WaveformCase<HandshakeFault> dut(bench, "dut", held_wire(machine, Handshake::kTableready));
    dut.drive("_--__--------_", &HandshakeFault::wire_i);
    dut.check("_--__-___----_", &HandshakeFault::wire_o);
    dut.run();
}
TEST_CASE("handshake fault: timing: BUSREADY that was taken away at least") {
    FaultyMachine machine({hold(2, 2)});
    LockstepBench bench;
    WaveformCase<HandshakeFault> dut(bench, "dut", held_wire(machine, Handshake::kBusready));
    // A grant of one clock, two gaps of a page miss of one and a beat of one, a beat and two more.
    dut.drive("------------", &HandshakeFault::wire_i);
    dut.check("--________--", &HandshakeFault::wire_o);
    dut.run();
}
// clang-format on

/// What a swap lock drives, before output framebuffers that swap late.
class SwapWires final : public Lockstep<SwapLockFault> {
  public:
    SwapWires(LockstepBench& bench, FaultyMachine& machine)
        : Lockstep(bench, "swap_wires",
                   [&machine](const char* dut, rtl::ClockGating) {
                       return std::make_unique<SwapLockFault>(dut, machine.scenario, machine.all(),
                                                              machine.new_tally());
                   }),
          holds_(machine) {
        wires_.add(lock_in_, 5);
        wires_.add(skip_in_, 5);
    }

    void stimulate() override { wires_.stimulate(bench_); }
    void expect() override {
        const bool held = holds_.at(bench_.clock());
        lock_ = lock_in_ && (was_locked_ || !held);
        skip_ = skip_in_ && (was_locked_ || was_skipped_ || !held);
    }
    void edge() override {
        if (lock_in_ != lock_ || skip_in_ != skip_) holds_.take_effect(bench_.clock());
        bench_.happened["SWAPSKIP alone was delayed"] += skip_in_ != skip_ && !lock_in_ ? 1 : 0;
        wrong_reports_ += dut().waiting_for() == (lock_in_ != lock_ ? "holds SWAPLOCK low" : "") ? 0 : 1;
        was_locked_ = lock_;
        was_skipped_ = skip_;
    }
    void reset() override { edge(); }
    void check_counts() const {
        holds_.check_counts();
        CHECK(wrong_reports_ == 0);
    }

  private:
    Holds holds_;
    Input<bool>& lock_in_ = in(&SwapLockFault::swaplock_i);
    Input<bool>& skip_in_ = in(&SwapLockFault::swapskip_i);
    Output<bool>& lock_ = out(&SwapLockFault::swaplock_o);
    Output<bool>& skip_ = out(&SwapLockFault::swapskip_o);
    FreeWires wires_;
    // As the last edge has sampled them.
    bool was_locked_ = false, was_skipped_ = false;
    int wrong_reports_ = 0;
};

TEST_CASE("swap lock fault: in lockstep with its reference") {
    constexpr int kClocks = 20'000;
    LockstepBench bench(3304);
    bench.clocks_to_reset = 0;
    FaultyMachine machine(random_holds(bench.random, kClocks));
    machine.scenario.renderers.resize(1);
    const SwapWires wires(bench, machine);
    bench.run(kClocks, {{"SWAPSKIP alone was delayed", 50}});
    wires.check_counts();
}

// ---- beats ----

BusBeat pixels(int destination, std::uint32_t first, int count = 3) {
    return pixel_beat(0, destination, first, count, 0, [](std::int64_t) { return std::uint64_t{0}; });
}

/// The bus before composer 2 of two, with beats of every kind.
class LossyBus final : public Lockstep<BusFault> {
  public:
    LossyBus(LockstepBench& bench, FaultyMachine& machine)
        : Lockstep(bench, "lossy_bus", lossy_bus(machine)),
          machine_(machine),
          lost_(machine.scenario.faults.size(), 0) {}

    void stimulate() override {
        if (bench_.pausing()) {
            sent_ = BusBeat{};
            return;
        }
        Random& random = bench_.random;
        const auto index = static_cast<std::uint32_t>(bench_.clock());  // no two beats are the same
        switch (random.between(0, 5)) {
            case 0:
                sent_ = BusBeat{};
                break;
            case 1:
                sent_ = BusBeat::frame_start(index, random.one_in(2));
                break;
            case 2:
                sent_ = BusBeat::table_row(1, index, segment_row({2, 3}), random.one_in(2));
                break;
            default:
                sent_ = pixels(random.between(1, 2), index, random.between(1, 8));
                break;
        }
    }
    void expect() override {
        seen_ = sent_;
        for (std::size_t i = 0; i < lost_.size(); ++i) {
            const Fault& fault = machine_.scenario.faults[i];
            const bool due = bench_.clock() + kFirstCoreCycle >= fault.from_cycle && lost_[i] < fault.beats;
            const bool for_it = sent_->kind == BusBeat::Kind::kPixels && sent_->destination == kDisplay + 1;
            const bool table =
                sent_->kind == BusBeat::Kind::kFrameStart || sent_->kind == BusBeat::Kind::kTableRow;
            const bool hit = fault.of == LostBeats::kPixels  ? for_it
                             : fault.of == LostBeats::kTable ? table
                                                             : sent_->kind != BusBeat::Kind::kNone;
            if (!due || !hit) continue;
            ++lost_[i];
            ++lost_beats_;
            lost_pixels_ += for_it ? sent_->count : 0;
            seen_ = BusBeat{};
            break;  // one fault loses it
        }
        std::string report;
        if (lost_beats_ > 0)
            report = "has lost " + std::to_string(lost_beats_) + (lost_beats_ == 1 ? " beat" : " beats");
        wrong_reports_ += dut().waiting_for() == report && dut().lost_pixels() == lost_pixels_ ? 0 : 1;
    }
    void check_counts() const {
        CHECK(machine_.counts() == lost_);
        CHECK(wrong_reports_ == 0);
    }

  private:
    const FaultyMachine& machine_;
    Input<BusBeat>& sent_ = in(&BusFault::bus_i);
    Output<BusBeat>& seen_ = out(&BusFault::bus_o);
    std::vector<std::int64_t> lost_;  ///< beats, by fault
    std::int64_t lost_beats_ = 0, lost_pixels_ = 0;
    int wrong_reports_ = 0;
};

TEST_CASE("bus fault: in lockstep with its reference") {
    constexpr int kClocks = 20'000;
    constexpr std::array kLosses{LostBeats::kPixels, LostBeats::kTable, LostBeats::kAny};
    LockstepBench bench(3305);
    bench.clocks_to_reset = 0;
    std::vector<Fault> faults;
    for (int clock = 0; clock < kClocks; clock += bench.random.between(1, 100)) {
        Fault fault = hold(clock, std::nullopt);
        fault.kind = FaultKind::kLostBeat;
        fault.of = one_of(bench.random, kLosses);
        fault.beats = bench.random.between(1, 5);
        faults.push_back(fault);
    }
    FaultyMachine machine(faults);
    const LossyBus bus(bench, machine);
    bench.run(kClocks);
    bus.check_counts();
}

// clang-format off
TEST_CASE("bus fault: timing: a beat that is not lost") {
    Fault fault = hold(4, std::nullopt);
    fault.kind = FaultKind::kLostBeat;
    FaultyMachine machine({fault});
    LockstepBench bench;
    WaveformCase<BusFault> dut(bench, "dut", lossy_bus(machine));
    const std::map<char, BusBeat> beats{{'a', pixels(2, 0)}, {'b', pixels(2, 3)}, {'1', pixels(1, 6)},
                                        {'c', pixels(2, 6)}, {'d', pixels(2, 9)}};
    dut.drive("..ab1c.d..", &BusFault::bus_i, beats);
    dut.check("..ab1..d..", &BusFault::bus_o, beats);
    dut.run();
}
// clang-format on

}  // namespace
}  // namespace metabuffer::test::fault_blocks_test
