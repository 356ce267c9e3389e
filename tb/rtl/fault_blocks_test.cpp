#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/bus_fault.h"
#include "rtl/fault_tally.h"
#include "rtl/handshake_fault.h"
#include "rtl/link_clock.h"
#include "support/scenarios.h"

namespace metabuffer::test::fault_blocks_test {
namespace {

using rtl::BusBeat;
using rtl::BusFault;
using rtl::FaultTally;
using rtl::Handshake;
using rtl::HandshakeFault;
using rtl::LinkClock;
using rtl::SwapLockFault;

constexpr int kPageMiss = 4;

/// Core cycles count the edges in reset, clocks of a testbench do not.
int core_cycle(const ClockedTestbench& bench, int clock) { return clock + bench.core.reset_clocks(); }
constexpr int kResetClocks = 2;

Scenario fault_scenario(FaultKind kind, int from_clock, std::optional<int> clocks) {
    Scenario scenario = small_scenario(4, 4, 2);
    scenario.clocks.core_mhz = 1e6 / ClockedTestbench::kCorePeriodPicoseconds;
    scenario.memory.page_miss_cycles = kPageMiss;
    scenario.bus.width_bits = 64;
    Fault fault;
    fault.kind = kind;
    fault.display = 2;
    fault.from_cycle = from_clock + kResetClocks;
    if (clocks) fault.cycles = *clocks;
    scenario.faults.push_back(fault);
    return scenario;
}

/// A register: what it holds after edge n is what edge n has read.
class Register final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_in<bool> wire_i{"wire_i"};
    sc_core::sc_signal<bool> held;

    explicit Register(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
        SC_METHOD(clock_edge);
        sensitive << clk_i.pos();
        dont_initialize();
    }
    SC_HAS_PROCESS(Register);

  private:
    void clock_edge() { held.write(wire_i.read()); }
};

/// A wire that the test raises, behind a fault.
struct WireBench {
    Scenario scenario;
    FaultTally tally{1};
    sc_core::sc_signal<bool> raised;
    sc_core::sc_signal<bool> wire;
    HandshakeFault fault;
    Register reader;
    const Recording<bool>& wires;

    WireBench(ClockedTestbench& bench, const std::string& name, Handshake handshake, Scenario with,
              std::size_t display = 1)
        : scenario(std::move(with)),
          fault(name.c_str(), scenario, {handshake, 0, display, "WIRE"}, {0}, tally),
          reader((name + "_reader").c_str()),
          wires(bench.core.record(reader.held)) {
        reader.clk_i(bench.core.clk);
        reader.wire_i(wire);
        fault.clk_i(bench.core.clk);
        fault.wire_i(raised);
        fault.wire_o(wire);
        bench.trace(fault);
    }
};

std::vector<int> read_high(const WireBench& dut) { return dut.wires.high(); }

std::vector<int> both(std::vector<int> one, const std::vector<int>& other) {
    one.insert(one.end(), other.begin(), other.end());
    return one;
}

TEST_CASE(
    "handshake fault: TABLEREADY is read low at the clocks of the fault and follows its wire at all others") {
    ClockedTestbench bench;
    WireBench dut(bench, "dut", Handshake::kTableready, fault_scenario(FaultKind::kBusreadyLow, 20, 5));
    bench.core.drive(dut.raised, 10, true);
    bench.core.drive(dut.raised, 15, false);
    bench.core.drive(dut.raised, 18, true);
    bench.core.drive(dut.raised, 30, false);
    bench.run_through(40);
    REQUIRE(core_cycle(bench, 0) == kResetClocks);
    CHECK(read_high(dut) == both(both(clock_range(10, 15), clock_range(18, 20)), clock_range(25, 30)));
    CHECK(dut.tally.count(0) == 1);
}

TEST_CASE("handshake fault: a PIPEREADY that is high is not lowered, its next rise waits") {
    ClockedTestbench bench;
    WireBench dut(bench, "dut", Handshake::kPipeready, fault_scenario(FaultKind::kPipereadyLow, 20, 30));
    bench.core.drive(dut.raised, 10, true);
    bench.core.drive(dut.raised, 28, false);  // STARTFRAME has come
    bench.core.drive(dut.raised, 33, true);
    bench.run_through(70);
    CHECK(read_high(dut) == both(clock_range(10, 28), clock_range(50, 71)));
    CHECK(dut.tally.count(0) == 1);
}

TEST_CASE("handshake fault: a FRAMEDONE that is high is not lowered, its next rise waits") {
    ClockedTestbench bench;
    WireBench dut(bench, "dut", Handshake::kFramedone, fault_scenario(FaultKind::kPipereadyLow, 20, 30));
    bench.core.drive(dut.raised, 10, true);
    bench.core.drive(dut.raised, 28, false);  // the swap has come back
    bench.core.drive(dut.raised, 33, true);
    bench.core.drive(dut.raised, 60, false);
    bench.run_through(70);
    CHECK(read_high(dut) == both(clock_range(10, 28), clock_range(50, 60)));
    CHECK(dut.tally.count(0) == 1);
}

TEST_CASE(
    "handshake fault: STALL is read high at the clocks of the fault and follows its wire at all others") {
    ClockedTestbench bench;
    WireBench dut(bench, "dut", Handshake::kStall, fault_scenario(FaultKind::kBusreadyLow, 20, 5));
    bench.core.drive(dut.raised, 10, true);
    bench.core.drive(dut.raised, 12, false);
    bench.core.drive(dut.raised, 18, true);
    bench.core.drive(dut.raised, 22, false);
    bench.core.drive(dut.raised, 30, true);
    bench.core.drive(dut.raised, 33, false);
    bench.run_through(19);
    CHECK(dut.tally.count(0) == 0);
    bench.run_through(40);
    CHECK(read_high(dut) == both(both(clock_range(10, 12), clock_range(18, 25)), clock_range(30, 33)));
    CHECK(dut.tally.count(0) == 1);
}

TEST_CASE("handshake fault: a STALL that is high anyway is not counted as an effect of the fault") {
    ClockedTestbench bench;
    WireBench dut(bench, "dut", Handshake::kStall, fault_scenario(FaultKind::kBusreadyLow, 20, 5));
    bench.core.drive(dut.raised, 18, true);
    bench.core.drive(dut.raised, 30, false);
    bench.run_through(22);
    CHECK(dut.fault.waiting_for().empty());
    bench.run_through(40);
    CHECK(read_high(dut) == clock_range(18, 30));
    CHECK(dut.tally.count(0) == 0);
}

TEST_CASE(
    "handshake fault: a fault that finds its wire low, or PIPEREADY already high, has not taken effect") {
    ClockedTestbench bench;
    WireBench low(bench, "low", Handshake::kTableready, fault_scenario(FaultKind::kBusreadyLow, 20, 5));
    WireBench standing(bench, "standing", Handshake::kPipeready,
                       fault_scenario(FaultKind::kPipereadyLow, 20, 5));
    bench.core.drive(standing.raised, 19, true);
    bench.run_through(40);
    CHECK(low.tally.count(0) == 0);
    CHECK(standing.tally.count(0) == 0);
    CHECK(low.fault.waiting_for().empty());
}

TEST_CASE(
    "handshake fault: a BUSREADY that the fault lowers stays low until its composer knows that its burst is "
    "over") {
    ClockedTestbench bench;
    const Scenario one_clock = fault_scenario(FaultKind::kBusreadyLow, 20, 1);
    WireBench kept(bench, "kept", Handshake::kBusready, one_clock);
    WireBench lowered(bench, "lowered", Handshake::kBusready, one_clock);
    WireBench long_fault(bench, "long_fault", Handshake::kBusready,
                         fault_scenario(FaultKind::kBusreadyLow, 20, 20));
    Scenario slow_beats = one_clock;
    slow_beats.bus.width_bits = 16;
    WireBench narrow(bench, "narrow", Handshake::kBusready, slow_beats);
    Scenario long_way = one_clock;
    long_way.bus.grant_cycles = 5;
    long_way.memory.read_latency_cycles = 3;
    long_way.bus.register_stages = 1;
    WireBench delayed(bench, "delayed", Handshake::kBusready, long_way);
    for (WireBench* dut : {&kept, &lowered, &long_fault, &narrow, &delayed}) {
        bench.core.drive(dut->raised, 10, true);
    }
    // The wire itself is low, as edge 22 reads it.
    bench.core.drive(lowered.raised, 22, false);
    bench.core.drive(lowered.raised, 23, true);
    bench.run_through(60);
    // Two page misses, three beats and two clocks.
    constexpr int kLow = 2 * kPageMiss + 3 * 1 + 2;
    constexpr int kLowAtFourClocksABeat = 2 * kPageMiss + 3 * 4 + 2;
    // Besides, the grant, and read latency and registers there and back.
    constexpr int kLowOfALongWay = kLow + 5 + 2 * (3 + 2 * 1);
    CHECK(read_high(kept) == both(clock_range(10, 20), clock_range(20 + kLow, 61)));
    CHECK(read_high(narrow) == both(clock_range(10, 20), clock_range(20 + kLowAtFourClocksABeat, 61)));
    CHECK(read_high(delayed) == both(clock_range(10, 20), clock_range(20 + kLowOfALongWay, 61)));
    CHECK(read_high(lowered) == both(clock_range(10, 20), clock_range(23, 61)));
    CHECK(read_high(long_fault) == both(clock_range(10, 20), clock_range(40, 61)));
}

TEST_CASE("handshake fault: a wire that is held for ever is reported") {
    ClockedTestbench bench;
    WireBench dut(bench, "dut", Handshake::kBusready,
                  fault_scenario(FaultKind::kBusreadyLow, -kResetClocks, std::nullopt));
    bench.core.drive(dut.raised, 3, true);
    bench.run_through(40);
    CHECK(dut.wires.high().empty());
    CHECK(dut.fault.waiting_for() == "holds WIRE low");
}

TEST_CASE("handshake fault: a STALL that is held for ever is reported") {
    ClockedTestbench bench;
    WireBench dut(bench, "dut", Handshake::kStall,
                  fault_scenario(FaultKind::kBusreadyLow, -kResetClocks, std::nullopt));
    bench.run_through(10);
    CHECK(read_high(dut) == clock_range(0, 11));
    CHECK(dut.fault.waiting_for() == "holds WIRE high");
}

TEST_CASE(
    "handshake fault: one in the first clocks holds the wire at the edge of its own clock, and is counted") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<WireBench>> wires;
    for (int clock = -kResetClocks; clock <= 1; ++clock) {
        wires.push_back(std::make_unique<WireBench>(bench, "dut_" + std::to_string(wires.size()),
                                                    Handshake::kStall,
                                                    fault_scenario(FaultKind::kBusreadyLow, clock, 1)));
    }
    bench.run_through(4);
    for (int first = -kResetClocks; first <= 1; ++first) {
        const WireBench& dut = *wires[static_cast<std::size_t>(first + kResetClocks)];
        INFO("fault at clock " << first);
        for (int clock = -kResetClocks; clock <= 4; ++clock) CHECK(dut.wires.at(clock) == (clock == first));
        CHECK(dut.tally.count(0) == 1);
    }
}

TEST_CASE("handshake fault: random stalls hold in their share of the clocks, as seed and wire determine") {
    constexpr int kClocks = 100'000;
    ClockedTestbench bench;
    const auto scenario = [](int percent, std::uint64_t seed) {
        Scenario with = fault_scenario(FaultKind::kRandomStalls, 0, std::nullopt);
        with.faults[0].percent = percent;
        with.faults[0].seed = seed;
        return with;
    };
    WireBench few(bench, "few", Handshake::kTableready, scenario(5, 1));
    WireBench many(bench, "many", Handshake::kTableready, scenario(80, 1));
    WireBench same(bench, "same", Handshake::kTableready, scenario(80, 1));
    WireBench other_seed(bench, "other_seed", Handshake::kTableready, scenario(80, 2));
    WireBench other_wire(bench, "other_wire", Handshake::kPairRequest, scenario(80, 1));
    WireBench other_display(bench, "other_display", Handshake::kTableready, scenario(80, 1), 2);
    WireBench stall(bench, "stall", Handshake::kStall, scenario(80, 1));
    for (WireBench* dut : {&few, &many, &same, &other_seed, &other_wire, &other_display}) {
        bench.core.drive(dut->raised, 0, true);
    }
    bench.run_through(kClocks - 1);
    // Half a percent is four times the deviation that chance gives.
    CHECK(std::abs(static_cast<int>(few.wires.high().size()) - kClocks * 95 / 100) < kClocks / 200);
    CHECK(std::abs(static_cast<int>(many.wires.high().size()) - kClocks * 20 / 100) < kClocks / 200);
    CHECK(many.wires.high() == same.wires.high());
    CHECK(many.wires.high() != other_seed.wires.high());
    CHECK(many.wires.high() != other_wire.wires.high());
    CHECK(many.wires.high() != other_display.wires.high());
    CHECK(std::abs(static_cast<int>(stall.wires.high().size()) - kClocks * 80 / 100) < kClocks / 50);
}

TEST_CASE("handshake fault: a random stall has taken effect if it held the wire, and else it has not") {
    int held = 0;
    constexpr int kSeeds = 200;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        Scenario scenario = fault_scenario(FaultKind::kRandomStalls, 1 - kResetClocks, std::nullopt);
        scenario.faults[0].percent = 50;
        scenario.faults[0].seed = seed;
        FaultTally tally{1};
        rtl::WireHolds holds(scenario, {Handshake::kTableready, 1, 1, "WIRE"}, {0}, tally);
        const bool hold = holds.at_next_edge(false);
        holds.at_next_edge(true);
        INFO("seed " << seed);
        CHECK(tally.count(0) == (hold ? 1 : 0));
        held += hold ? 1 : 0;
    }
    CHECK((held > kSeeds / 4 && held < kSeeds * 3 / 4));
}

TEST_CASE("handshake fault: random stalls hold each wire at different clocks, under each seed") {
    constexpr int kEdges = 64;
    constexpr std::size_t kPlaces = 8;
    std::set<std::vector<bool>> sequences;
    std::size_t wires = 0;
    for (const std::uint64_t seed : {1U, 2U, 7U}) {
        Scenario scenario = fault_scenario(FaultKind::kRandomStalls, -kResetClocks, std::nullopt);
        scenario.faults[0].percent = 50;
        scenario.faults[0].seed = seed;
        FaultTally tally{1};
        for (const Handshake handshake : {Handshake::kBusready, Handshake::kTableready, Handshake::kStall}) {
            for (std::size_t renderer = 0; renderer < kPlaces; ++renderer) {
                for (std::size_t display = 0; display < kPlaces; ++display) {
                    rtl::WireHolds holds(scenario, {handshake, renderer, display, "WIRE"}, {0}, tally);
                    std::vector<bool> sequence{holds.at_first_edge()};
                    while (sequence.size() < kEdges) sequence.push_back(holds.at_next_edge(false));
                    sequences.insert(sequence);
                    ++wires;
                }
            }
        }
    }
    CHECK(sequences.size() == wires);
}

TEST_CASE(
    "handshake fault: random stalls delay the rise of FRAMEDONE as long as they say, and never its fall") {
    constexpr int kClocks = 3000;
    constexpr int kLow = 8;
    constexpr int kHigh = 12;
    ClockedTestbench bench;
    Scenario scenario = fault_scenario(FaultKind::kRandomStalls, 0, std::nullopt);
    scenario.faults[0].percent = 50;
    WireBench dut(bench, "dut", Handshake::kFramedone, scenario);
    bench.core.each_clock([&dut](int clock) { dut.raised.write(clock % (kLow + kHigh) >= kLow); });
    const auto& raised = bench.core.record(dut.raised);
    bench.run_through(kClocks);
    int delays[3] = {};  // by clocks; the last for all longer ones
    int delay = 0;
    for (int clock = 1; clock < kClocks; ++clock) {
        INFO("clock " << clock);
        if (!raised.at(clock)) {
            CHECK_FALSE(dut.wires.at(clock));
            delay = 0;
        } else if (!dut.wires.at(clock)) {
            CHECK((!dut.wires.at(clock - 1) || !raised.at(clock - 1)));
            ++delay;
        } else if (!dut.wires.at(clock - 1)) {
            ++delays[std::min(delay, 2)];
        }
    }
    for (const int count : delays) CHECK(count > 10);
    CHECK(delays[0] > delays[1]);
    CHECK(dut.tally.count(0) == 1);
}

namespace {

/// The wires of a swap lock, which the test drives, behind a fault.
struct SwapBench {
    Scenario scenario;
    FaultTally tally{1};
    sc_core::sc_signal<bool> swaplock;
    sc_core::sc_signal<bool> swapskip;
    sc_core::sc_signal<bool> seen_swaplock;
    sc_core::sc_signal<bool> seen_swapskip;
    SwapLockFault fault;
    Register lock_reader;
    Register skip_reader;
    const Recording<bool>& locks;
    const Recording<bool>& skips;

    SwapBench(ClockedTestbench& bench, const std::string& name, Scenario with)
        : scenario(std::move(with)),
          fault(name.c_str(), scenario, {0}, tally),
          lock_reader((name + "_lock_reader").c_str()),
          skip_reader((name + "_skip_reader").c_str()),
          locks(bench.core.record(lock_reader.held)),
          skips(bench.core.record(skip_reader.held)) {
        fault.clk_i(bench.core.clk);
        fault.swaplock_i(swaplock);
        fault.swapskip_i(swapskip);
        fault.swaplock_o(seen_swaplock);
        fault.swapskip_o(seen_swapskip);
        lock_reader.clk_i(bench.core.clk);
        lock_reader.wire_i(seen_swaplock);
        skip_reader.clk_i(bench.core.clk);
        skip_reader.wire_i(seen_swapskip);
        bench.trace(fault);
    }
};

}  // namespace

TEST_CASE("swap lock fault: SWAPLOCK rises later, SWAPSKIP with it, and neither is lowered") {
    ClockedTestbench bench;
    SwapBench dut(bench, "dut", fault_scenario(FaultKind::kPipereadyLow, 20, 30));
    // One swap is over before the fault ends, one is delayed by the fault, and one comes after it.
    bench.core.drive(dut.swaplock, 10, true);
    bench.core.drive(dut.swapskip, 5, true);
    bench.core.drive(dut.swaplock, 25, false);
    bench.core.drive(dut.swapskip, 25, false);
    bench.core.drive(dut.swapskip, 30, true);
    bench.core.drive(dut.swaplock, 35, true);
    bench.core.drive(dut.swaplock, 60, false);
    bench.core.drive(dut.swapskip, 60, false);
    bench.core.drive(dut.swaplock, 65, true);
    bench.run_through(40);
    CHECK(dut.fault.waiting_for() == "holds SWAPLOCK low");
    bench.run_through(70);
    CHECK(dut.locks.high() == both(both(clock_range(10, 25), clock_range(50, 60)), clock_range(65, 71)));
    CHECK(dut.skips.high() == both(clock_range(5, 25), clock_range(50, 60)));
    CHECK(dut.tally.count(0) == 1);
    CHECK(dut.fault.waiting_for().empty());
}

TEST_CASE("swap lock fault: a SWAPSKIP that is high when the fault begins stays high, SWAPLOCK waits") {
    ClockedTestbench bench;
    SwapBench dut(bench, "dut", fault_scenario(FaultKind::kPipereadyLow, 20, 10));
    bench.core.drive(dut.swapskip, 15, true);
    bench.core.drive(dut.swaplock, 22, true);
    bench.run_through(40);
    CHECK(dut.skips.high() == clock_range(15, 41));
    CHECK(dut.locks.high() == clock_range(30, 41));
    CHECK(dut.tally.count(0) == 1);
}

TEST_CASE("swap lock fault: a fault that delays SWAPSKIP alone has taken effect") {
    ClockedTestbench bench;
    SwapBench dut(bench, "dut", fault_scenario(FaultKind::kPipereadyLow, 20, 10));
    bench.core.drive(dut.swapskip, 22, true);
    bench.core.drive(dut.swaplock, 35, true);
    bench.run_through(40);
    CHECK(dut.skips.high() == clock_range(30, 41));
    CHECK(dut.locks.high() == clock_range(35, 41));
    CHECK(dut.tally.count(0) == 1);
}

TEST_CASE("swap lock fault: a fault that finds both wires low, or both high, has not taken effect") {
    ClockedTestbench bench;
    SwapBench low(bench, "low", fault_scenario(FaultKind::kPipereadyLow, 20, 10));
    SwapBench standing(bench, "standing", fault_scenario(FaultKind::kPipereadyLow, 20, 10));
    bench.core.drive(low.swaplock, 35, true);
    bench.core.drive(standing.swaplock, 15, true);
    bench.core.drive(standing.swapskip, 15, true);
    bench.run_through(40);
    CHECK(low.locks.high() == clock_range(35, 41));
    CHECK(low.tally.count(0) == 0);
    CHECK(standing.locks.high() == clock_range(15, 41));
    CHECK(standing.tally.count(0) == 0);
}

TEST_CASE(
    "swap lock fault: under random stalls SWAPSKIP is high while SWAPLOCK is, and the seed determines the "
    "delays") {
    constexpr int kPeriod = 24;
    constexpr int kSwaps = 160;
    constexpr int kClocks = kSwaps * kPeriod;
    ClockedTestbench bench;
    const auto scenario = [](std::uint64_t seed) {
        Scenario with = fault_scenario(FaultKind::kRandomStalls, 0, std::nullopt);
        with.faults[0].percent = 60;
        with.faults[0].seed = seed;
        return with;
    };
    SwapBench dut(bench, "dut", scenario(3));
    SwapBench same(bench, "same", scenario(3));
    SwapBench other(bench, "other", scenario(4));
    // Every other swap is skipped; SWAPSKIP rises 0 to 7 clocks before SWAPLOCK and falls with it.
    const auto locked = [](int clock) { return clock % kPeriod >= 10; };
    const auto skipped = [](int clock) {
        const int swap = clock / kPeriod;
        return swap % 2 == 1 && clock % kPeriod >= 10 - swap / 2 % 8;
    };
    bench.core.each_clock([&](int clock) {
        for (SwapBench* bench_of : {&dut, &same, &other}) {
            bench_of->swaplock.write(locked(clock));
            bench_of->swapskip.write(skipped(clock));
        }
    });
    bench.run_through(kClocks - 1);
    int locks_delayed = 0;
    int skips_delayed = 0;
    int skips_first = 0;
    for (int clock = 1; clock < kClocks; ++clock) {
        INFO("clock " << clock);
        const bool lock = dut.locks.at(clock);
        const bool skip = dut.skips.at(clock);
        if (lock) CHECK(skip == skipped(clock));
        CHECK((!lock || locked(clock)));
        CHECK((!skip || skipped(clock)));
        if (locked(clock) && dut.locks.at(clock - 1) && locked(clock - 1)) CHECK(lock);
        if (skipped(clock) && dut.skips.at(clock - 1) && skipped(clock - 1)) CHECK(skip);
        locks_delayed += locked(clock) && !lock ? 1 : 0;
        skips_delayed += skipped(clock) && !skip ? 1 : 0;
        skips_first += skip && !lock && !locked(clock) ? 1 : 0;
    }
    CHECK(locks_delayed > kClocks / 50);
    CHECK(skips_delayed > kClocks / 100);
    CHECK(skips_first > kClocks / 100);
    CHECK(dut.locks.high() == same.locks.high());
    CHECK(dut.skips.high() == same.skips.high());
    CHECK(dut.locks.high() != other.locks.high());
    CHECK(dut.locks.rises().size() == std::size_t{kSwaps});
}

/// The clocks whose beats a fault of this kind loses, from cycle 20 on. All else must be seen in the same clock.
std::vector<int> lost_clocks(LostBeats of, int beats, std::int64_t pixels_lost) {
    ClockedTestbench bench;
    Scenario scenario = fault_scenario(FaultKind::kLostBeat, 20, std::nullopt);
    scenario.faults[0].beats = beats;
    scenario.faults[0].of = of;
    FaultTally tally{1};
    sc_core::sc_signal<BusBeat> sent;
    sc_core::sc_signal<BusBeat> seen;
    BusFault dut("dut", scenario, 1, {0}, tally);
    dut.bus_i(sent);
    dut.bus_o(seen);
    bench.trace(dut);
    const auto& sent_beats = bench.core.record(sent);
    const auto& seen_beats = bench.core.record(seen);
    const auto pixels = [](int destination, int first) {
        BusBeat beat;
        beat.kind = BusBeat::Kind::kPixels;
        beat.destination = static_cast<std::uint16_t>(destination);
        beat.count = 3;
        beat.first = static_cast<std::uint32_t>(first);
        return beat;
    };
    // One a clock: edge 19 reads the last one before the fault.
    bench.core.drive(sent, 18, pixels(2, 0));
    bench.core.drive(sent, 19, pixels(2, 3));
    bench.core.drive(sent, 20, pixels(2, 6));
    bench.core.drive(sent, 21, BusBeat::frame_start(1, false));
    bench.core.drive(sent, 22, pixels(1, 6));
    bench.core.drive(sent, 23, pixels(2, 9));
    bench.core.drive(sent, 24, pixels(2, 12));
    bench.core.drive(sent, 25, BusBeat::table_row(1, 0, table_row(1, {0, 0}, {1, 1}, {0, 0}), false));
    bench.core.drive(sent, 26, BusBeat::table_row(1, 1, table_row(2, {0, 0}, {1, 1}, {0, 0}), true));
    bench.core.drive(sent, 27, BusBeat{});
    bench.core.drive(sent, 28, BusBeat::frame_start(2, true));
    bench.core.drive(sent, 29, BusBeat{});
    bench.run_through(17);
    CHECK(dut.waiting_for().empty());
    bench.run_through(35);
    std::vector<int> lost;
    for (int clock = 0; clock <= 35; ++clock) {
        INFO("clock " << clock);
        const bool is_lost = sent_beats.at(clock).kind != seen_beats.at(clock).kind;
        CHECK(seen_beats.at(clock) == (is_lost ? BusBeat{} : sent_beats.at(clock)));
        if (is_lost) lost.push_back(clock);
    }
    CHECK(dut.lost_pixels() == pixels_lost);
    CHECK(tally.count(0) == static_cast<std::int64_t>(lost.size()));
    CHECK(dut.waiting_for() == "has lost " + std::to_string(lost.size()) + " beats");
    return lost;
}

TEST_CASE("bus fault: the next beats of pixels for its composer vanish, all else is seen in the same clock") {
    CHECK(lost_clocks(LostBeats::kPixels, 2, 6) == std::vector<int>{20, 23});
}

TEST_CASE("bus fault: the next beats of tables vanish, whomever their rows are for") {
    CHECK(lost_clocks(LostBeats::kTable, 3, 0) == std::vector<int>{21, 25, 26});
}

TEST_CASE("bus fault: the next beats vanish, whatever they are") {
    CHECK(lost_clocks(LostBeats::kAny, 6, 9) == clock_range(20, 26));
}

TEST_CASE("bus fault: a clock without a beat loses none") {
    CHECK(lost_clocks(LostBeats::kAny, 8, 9) == std::vector<int>{20, 21, 22, 23, 24, 25, 26, 28});
}

TEST_CASE("link clock: nominal until a drift is set, then off by that many millionths, exact on average") {
    constexpr std::int64_t kPeriod = 9'999;
    struct Count final : sc_core::sc_module {
        sc_core::sc_in<bool> clk_i{"clk_i"};
        std::int64_t edges = 0;
        sc_core::sc_time last;
        explicit Count(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
            SC_METHOD(edge);
            sensitive << clk_i.pos();
            dont_initialize();
        }
        SC_HAS_PROCESS(Count);
        void edge() {
            ++edges;
            last = sc_core::sc_time_stamp();
        }
    };
    constexpr int kPpm = 37;
    sc_core::sc_signal<int> told{"told"};
    sc_core::sc_signal<bool> clk{"clk"};
    LinkClock dut("dut", kPeriod);
    dut.clock_ppm_i(told);
    dut.clk_o(clk);
    Count count("count");
    count.clk_i(clk);
    const auto run_to = [](std::int64_t time) {
        const auto now = static_cast<std::int64_t>(sc_core::sc_time_stamp().value());
        sc_core::sc_start(sc_core::sc_time(static_cast<double>(time - now), sc_core::SC_PS));
    };
    run_to(1'000 * kPeriod - 1);
    CHECK(count.edges == 1'000);  // the first at time 0
    CHECK(count.last == sc_core::sc_time(999.0 * kPeriod, sc_core::SC_PS));
    told.write(kPpm);
    // The edge at 1000 periods reads the drift. From there a million and ppm periods take as long as a million nominal
    // ones.
    run_to(1'000 * kPeriod + 1'000'000 * kPeriod + 1);
    CHECK(count.edges == 1'000 + 1 + 1'000'000 + kPpm);
    CHECK(count.last == sc_core::sc_time(1'001'000.0 * kPeriod, sc_core::SC_PS));
    told.write(0);
    run_to(1'001'000 * kPeriod + 5'000 * kPeriod + 1);
    CHECK(count.edges == 1'000 + 1 + 1'000'000 + kPpm + 5'000);
}

}  // namespace
}  // namespace metabuffer::test::fault_blocks_test
