#include "rtl/bus_arbiter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "datapath/arbitration/arbitration_table.h"
#include "datapath/segment.h"
#include "rtl/wires.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "support/scenarios.h"

// The datapath's unit tests check the policies against independent code. These tests check that the arbiter's pins
// follow the policy, at the clock that its header states.
namespace metabuffer::test::bus_arbiter_test {
namespace {

using rtl::BusArbiter;
using rtl::FrontTable;

constexpr int kLines = 4;
constexpr Size kRaster{64, 64};

/// A: 30 pixels a row at multiple 1, needed late. B: 10 pixels, needed first. C: 10 pixels in between.
ViewportTable three_rows() {
    return {table_row(1, {0, 0}, {30, 1}, {0, 50}), table_row(2, {0, 0}, {10, 1}, {0, 0}),
            table_row(3, {0, 0}, {10, 1}, {0, 20})};
}

std::vector<std::uint64_t> first_needs(const ViewportTable& rows) {
    std::vector<std::uint64_t> needs;
    for (const ViewportRow& row : rows) {
        needs.push_back(static_cast<std::uint64_t>(Segment(row, kRaster.width, kRaster.height).first_use(0)));
    }
    return needs;
}

/// The arbiter's inputs before an edge, and the answer that it must have given by then.
struct Clock {
    std::vector<bool> ready;
    int row = -1;  ///< granted
    bool lost = false;
    int recovered = 0;
    bool take = true;
    std::vector<bool> pending = {true, true, true};
};

struct ArbiterBench {
    static constexpr int kStart = 2;           ///< the clock of start_i
    static constexpr int kFirst = kStart + 1;  ///< the first clock of the frame's answers

    Arbitration policy;
    FrontTable front;
    ClockDomain& core;
    sc_core::sc_signal<bool> start;
    sc_core::sc_signal<FrontTable> table;
    sc_core::sc_signal<bool> take;
    rtl::SignalBank<bool> pending;
    rtl::SignalBank<bool> ready;
    rtl::SignalBank<std::uint64_t> deadline;
    rtl::SignalBank<bool> grant;
    sc_core::sc_signal<bool> grant_valid;
    sc_core::sc_signal<bool> search;
    sc_core::sc_signal<bool> lost;
    sc_core::sc_signal<std::uint16_t> recovered;
    sc_core::sc_signal<std::uint16_t> slot;
    BusArbiter dut;
    std::vector<const Recording<bool>*> grants;
    const Recording<bool>& valid;
    const Recording<bool>& searches;
    const Recording<bool>& lost_slots;
    const Recording<std::uint16_t>& recovered_slots;
    const Recording<std::uint16_t>& slots;

    ArbiterBench(ClockedTestbench& bench, Arbitration arbitration, int grant_cycles = 0,
                 SlotTableMaker maker = SlotTableMaker::kHost)
        : policy(arbitration),
          core(bench.core),
          pending(kLines, name_of(arbitration, "pending")),
          ready(kLines, name_of(arbitration, "ready")),
          deadline(goes_by_deadlines(arbitration) ? kLines : 0, name_of(arbitration, "deadline")),
          grant(kLines, name_of(arbitration, "grant")),
          dut(("arbiter_" + std::to_string(static_cast<int>(arbitration))).c_str(),
              config_of(arbitration, grant_cycles, maker), kLines),
          valid(core.record_sampled(grant_valid)),
          searches(core.record_sampled(search)),
          lost_slots(core.record_sampled(lost)),
          recovered_slots(core.record_sampled(recovered)),
          slots(core.record_sampled(slot)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.start_i(start);
        dut.table_i(table);
        dut.take_i(take);
        for (std::size_t line = 0; line < kLines; ++line) {
            dut.pending_i[line](pending[line]);
            dut.ready_i[line](ready[line]);
            if (deadline.size() > 0) dut.deadline_i[line](deadline[line]);
            dut.grant_o[line](grant[line]);
            grants.push_back(&core.record_sampled(grant[line]));
        }
        dut.grant_valid_o(grant_valid);
        dut.search_o(search);
        dut.lost_o(lost);
        dut.recovered_o(recovered);
        dut.slot_o(slot);
        bench.trace(dut);
    }

    static std::function<std::string(std::size_t)> name_of(Arbitration arbitration, const char* stem) {
        return [=](std::size_t line) {
            return std::string(stem) + std::to_string(static_cast<int>(arbitration)) + "_" +
                   std::to_string(line);
        };
    }

    static BusConfig config_of(Arbitration arbitration, int grant_cycles, SlotTableMaker maker) {
        BusConfig bus;
        bus.arbitration = arbitration;
        bus.grant_cycles = grant_cycles;
        bus.slot_table = maker;
        return bus;
    }

    /// start_i is high at edge `clock`.
    void start_at(int clock, const ViewportTable& rows) {
        core.drive(table, clock, FrontTable{rows, slots_of(policy, rows)});
        core.pulse(start, clock);
        const std::vector<std::uint64_t> needs = first_needs(rows);
        for (std::size_t line = 0; line < deadline.size() && line < needs.size(); ++line) {
            core.drive(deadline[line], clock, needs[line]);
        }
    }
    /// Drives the lines that edge `clock` samples.
    void drive(int clock, const Clock& now) {
        for (std::size_t line = 0; line < kLines; ++line) {
            core.drive(pending[line], clock, line < now.pending.size() && now.pending[line]);
            core.drive(ready[line], clock, line < now.ready.size() && now.ready[line]);
        }
        core.drive(take, clock, now.take);
    }
    /// The row whose grant line edge `clock` samples high; at most one line is high.
    int granted_at(int clock) const {
        int row = -1;
        for (int line = 0; line < kLines; ++line) {
            if (!grants[static_cast<std::size_t>(line)]->at(clock)) continue;
            REQUIRE(row == -1);
            row = line;
        }
        REQUIRE(valid.at(clock) == (row >= 0));
        return row;
    }
    void check(int clock, const Clock& wanted) const {
        INFO(arbitration_row(policy).name << ", clock " << clock);
        CHECK(granted_at(clock) == wanted.row);
        CHECK(lost_slots.at(clock) == wanted.lost);
        CHECK(recovered_slots.at(clock) == wanted.recovered);
    }
};

/// Plays clocks from the frame's first on and checks each.
void play(Arbitration policy, const ViewportTable& rows, const std::vector<Clock>& clocks) {
    ClockedTestbench bench;
    ArbiterBench dut(bench, policy);
    dut.start_at(ArbiterBench::kStart, rows);
    int clock = ArbiterBench::kFirst;
    for (const Clock& now : clocks) dut.drive(clock++, now);
    bench.run_through(clock + 1);
    clock = ArbiterBench::kFirst;
    for (const Clock& wanted : clocks) dut.check(clock++, wanted);
}

TEST_CASE("bus arbiter: round-robin grants within the clock, one line at a time, and recovers idle slots") {
    play(Arbitration::kRoundRobin, three_rows(),
         {{{true, true, true}, 0},
          {{true, true, true}, 1},
          {{true, true, true}, 2},
          {{true, false, true}, 0},
          {{true, false, true}, 2, false, 1},
          {{false, false, false}, -1},  // a poll does not move the pointer
          {{true, true, true}, 0},
          {{true, false, false}, 0, false, 2}});
}

TEST_CASE("bus arbiter: an answer that is not taken does not move the slot pointer") {
    play(Arbitration::kRoundRobin, three_rows(),
         {{{true, true, true}, 0, false, 0, false},
          {{true, true, true}, 0, false, 0, false},
          {{false, true, true}, 1, false, 1, false},
          {{true, true, true}, 0},
          {{true, true, true}, 1, false, 0, false},
          {{true, true, true}, 1}});
}

TEST_CASE("bus arbiter: a row without pixels left is granted nothing, even if its composer is ready") {
    play(Arbitration::kRoundRobin, three_rows(),
         {{{true, true, true}, 1, false, 1, true, {false, true, true}},
          {{true, true, true}, 2, false, 0, true, {false, true, true}},
          {{true, true, true}, 2, false, 2, true, {false, false, true}},
          {{true, true, true}, -1, false, 0, true, {false, false, false}}});
}

TEST_CASE("bus arbiter: slot-allocation reports a lost slot and goes on to the next one") {
    const ViewportTable rows{table_row(1, {0, 0}, {10, 1}, {0, 50}), table_row(2, {0, 0}, {20, 1}, {0, 0})};
    REQUIRE(slots_of(Arbitration::kSlotAllocation, rows) == std::vector<int>{1, 0, 1});
    play(Arbitration::kSlotAllocation, rows,
         {{{true, true}, 1},
          {{false, true}, -1, true},
          {{false, true}, 1},
          {{true, false}, -1, true, 0, false},
          {{true, false}, -1, true},
          {{true, false}, 0}});
}

TEST_CASE("bus arbiter: edf grants the row whose deadline line shows the earliest position") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kEdf);
    dut.start_at(ArbiterBench::kStart, three_rows());
    const std::vector<Clock> clocks{{{true, true, true}, 1},
                                    {{true, false, true}, 2},
                                    {{true, false, false}, 0},
                                    {{true, true, true}, 0}};
    int clock = ArbiterBench::kFirst;
    for (const Clock& now : clocks) dut.drive(clock++, now);
    dut.core.drive(dut.deadline[0], ArbiterBench::kFirst + 3, 0U);
    dut.core.drive(dut.deadline[1], ArbiterBench::kFirst + 3, 1U);
    bench.run_through(clock + 1);
    clock = ArbiterBench::kFirst;
    for (const Clock& wanted : clocks) dut.check(clock++, wanted);
}

TEST_CASE("bus arbiter: irsa gives slots in proportion to need") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kIrsa);
    dut.start_at(ArbiterBench::kStart, three_rows());
    constexpr int kClocks = 50;
    for (int i = 0; i < kClocks; ++i) dut.drive(ArbiterBench::kFirst + i, {{true, true, true}});
    bench.run_through(ArbiterBench::kFirst + kClocks);
    std::vector<int> granted(3, 0);
    for (int i = 0; i < kClocks; ++i) {
        ++granted.at(static_cast<std::size_t>(dut.granted_at(ArbiterBench::kFirst + i)));
    }
    CHECK(granted == std::vector<int>{30, 10, 10});
}

TEST_CASE("bus arbiter: a new frame's table is used from its start on, beginning with the first slot") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kRoundRobin);
    dut.start_at(ArbiterBench::kStart, three_rows());
    constexpr int kSecond = ArbiterBench::kFirst + 3;
    for (int i = 0; i < 2; ++i) dut.drive(ArbiterBench::kFirst + i, {{true, true, true}});
    dut.drive(kSecond - 1, {{true, true, true}, -1, false, 0, false});
    dut.start_at(kSecond, {three_rows()[2], three_rows()[0]});
    for (int i = 1; i < 5; ++i) dut.drive(kSecond + i, {{true, true}, -1, false, 0, true, {true, true}});
    bench.run_through(kSecond + 6);
    CHECK(dut.granted_at(kSecond) == 2);  // still the old frame's pointer
    for (int i = 1; i < 5; ++i) CHECK(dut.granted_at(kSecond + i) == (i - 1) % 2);
    CHECK(dut.slots.at(kSecond + 1) == 0);
    CHECK(dut.slots.at(kSecond + 2) == 1);
}

TEST_CASE(
    "bus arbiter: a grant that takes clocks stands after that many edges, whatever the lines do meanwhile") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kRoundRobin, 3);
    dut.start_at(ArbiterBench::kStart, three_rows());
    constexpr int kAsked = ArbiterBench::kFirst + 2;
    // Polls cost nothing; row 1 alone is ready at kAsked, row 0 from the next clock on.
    for (int clock = ArbiterBench::kFirst; clock < kAsked; ++clock) dut.drive(clock, {{false, false, false}});
    dut.drive(kAsked, {{false, true, false}});
    for (int clock = kAsked + 1; clock < kAsked + 12; ++clock) dut.drive(clock, {{true, false, false}});
    bench.run_through(kAsked + 12);
    for (int clock = ArbiterBench::kFirst; clock < kAsked; ++clock) CHECK_FALSE(dut.searches.at(clock));
    for (int clock = kAsked; clock < kAsked + 3; ++clock) {
        CHECK(dut.granted_at(clock) == -1);
        CHECK(dut.searches.at(clock));
    }
    CHECK(dut.granted_at(kAsked + 3) == 1);
    CHECK(dut.recovered_slots.at(kAsked + 3) == 1);
    CHECK_FALSE(dut.searches.at(kAsked + 3));
    // The search for the next answer begins in the clock after the one in which this answer was taken.
    for (int clock = kAsked + 4; clock < kAsked + 7; ++clock) CHECK(dut.granted_at(clock) == -1);
    CHECK(dut.granted_at(kAsked + 7) == 0);
    CHECK(dut.slots.at(kAsked + 4) == 2);
}

TEST_CASE("bus arbiter: it sees a frame's start after any number of idle clocks, if no other line changes") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kRoundRobin);
    Clock standing{{true, true, true}};
    standing.take = false;
    dut.drive(0, standing);
    constexpr int kLateStart = 40;
    dut.start_at(kLateStart, three_rows());
    bench.run_through(kLateStart + 2);
    CHECK(dut.granted_at(kLateStart) == -1);
    CHECK(dut.granted_at(kLateStart + 1) == 0);
}

TEST_CASE("bus arbiter: the answer follows each line in its own clock, after any number of idle clocks") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kEdf);
    const auto stand = [&dut](int clock, const std::vector<bool>& ready, const std::vector<bool>& pending) {
        dut.drive(clock, {ready, -1, false, 0, false, pending});
    };
    dut.start_at(ArbiterBench::kStart, three_rows());
    stand(ArbiterBench::kFirst, {true, true, true}, {true, true, true});
    stand(40, {true, true, true}, {true, false, true});
    stand(80, {true, true, false}, {true, false, true});
    stand(120, {true, true, false}, {true, true, true});
    dut.core.drive(dut.deadline[0], 160, 0U);
    dut.core.drive(dut.deadline[1], 160, 1U);
    bench.run_through(170);
    const std::vector<int> granted{1, 2, 0, 1, 0};
    for (int clock = ArbiterBench::kFirst; clock < 170; ++clock) {
        INFO("clock " << clock);
        CHECK(dut.granted_at(clock) == granted.at(static_cast<std::size_t>(clock / 40)));
    }
}

TEST_CASE("bus arbiter: a lost slot takes as many clocks as an answer") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kSlotAllocation, 2);
    dut.start_at(ArbiterBench::kStart, three_rows());
    for (int i = 0; i < 8; ++i) dut.drive(ArbiterBench::kFirst + i, {{false, false, false}});
    bench.run_through(ArbiterBench::kFirst + 8);
    for (int i = 0; i < 8; ++i) CHECK(dut.lost_slots.at(ArbiterBench::kFirst + i) == (i % 3 == 2));
}

TEST_CASE("bus arbiter: building a slot table takes one clock per slot, and nothing is granted before") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kIrsa, 0, SlotTableMaker::kBuilt);
    dut.start_at(ArbiterBench::kStart, three_rows());
    const auto slots = static_cast<int>(slots_of(Arbitration::kIrsa, three_rows()).size());
    REQUIRE(slots > 2);
    for (int i = 0; i < slots + 3; ++i) dut.drive(ArbiterBench::kFirst + i, {{true, true, true}});
    bench.run_through(ArbiterBench::kFirst + slots + 3);
    for (int i = 0; i < slots; ++i) {
        CHECK(dut.granted_at(ArbiterBench::kFirst + i) == -1);
        CHECK(dut.searches.at(ArbiterBench::kFirst + i));
    }
    CHECK(dut.granted_at(ArbiterBench::kFirst + slots) == slots_of(Arbitration::kIrsa, three_rows())[0]);
    CHECK(dut.granted_at(ArbiterBench::kFirst + slots + 1) >= 0);
    CHECK_FALSE(dut.searches.at(ArbiterBench::kFirst + slots));
}

void check_reset_at(int reset_at) {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kRoundRobin, 5, SlotTableMaker::kBuilt);
    dut.start_at(ArbiterBench::kStart, three_rows());
    constexpr int kSecond = 20;
    for (int clock = ArbiterBench::kFirst; clock < kSecond + 14; ++clock)
        dut.drive(clock, {{true, true, true}});
    bench.core.pulse(bench.reset, reset_at);
    dut.start_at(kSecond, three_rows());
    bench.run_through(kSecond + 14);
    for (int clock = reset_at + 1; clock <= kSecond; ++clock) {
        CHECK_FALSE(dut.searches.at(clock));
        CHECK(dut.granted_at(clock) == -1);
    }
    // Three clocks build the slots, then five clocks search.
    for (int clock = kSecond + 1; clock < kSecond + 9; ++clock) CHECK(dut.granted_at(clock) == -1);
    CHECK(dut.granted_at(kSecond + 9) == 0);
}

TEST_CASE("bus arbiter: a reset ends the building of a slot table") {
    check_reset_at(ArbiterBench::kFirst + 1);
}
TEST_CASE("bus arbiter: a reset ends a search") { check_reset_at(ArbiterBench::kFirst + 6); }

void check_reset(Arbitration policy) {
    ClockedTestbench bench;
    ArbiterBench dut(bench, policy);
    dut.start_at(ArbiterBench::kStart, three_rows());
    for (int clock = ArbiterBench::kFirst; clock < 20; ++clock) dut.drive(clock, {{true, true, true}});
    bench.core.pulse(bench.reset, 8);
    dut.start_at(12, three_rows());
    bench.run_through(20);
    CHECK(dut.granted_at(8) >= 0);
    for (int clock = 9; clock <= 12; ++clock) {
        CHECK(dut.granted_at(clock) == -1);
        CHECK_FALSE(dut.lost_slots.at(clock));
        CHECK(dut.slots.at(clock) == 0);
    }
    for (int i = 0; i < 5; ++i) CHECK(dut.granted_at(13 + i) == dut.granted_at(ArbiterBench::kFirst + i));
}

TEST_CASE("bus arbiter: a reset wakes a block that sleeps, and clears its table") {
    ClockedTestbench bench;
    ArbiterBench dut(bench, Arbitration::kIrsa);
    dut.start_at(ArbiterBench::kStart, three_rows());
    bench.core.pulse(bench.reset, 40);
    for (int clock = 50; clock < 60; ++clock) dut.drive(clock, {{true, true, true}});
    bench.run_through(60);
    for (int clock = 50; clock < 60; ++clock) CHECK(dut.granted_at(clock) == -1);
}

TEST_CASE("bus arbiter: a reset clears the table, and the next frame begins at its first slot") {
    check_reset(Arbitration::kIrsa);
}
TEST_CASE("bus arbiter: a reset clears slot-allocation's table too, so that no slot is lost") {
    check_reset(Arbitration::kSlotAllocation);
}
TEST_CASE("bus arbiter: a reset clears edf's rows") { check_reset(Arbitration::kEdf); }

/// Asks the policy itself in each clock, and compares its answer with the pins.
void check_against_policy(Arbitration policy) {
    Random random(random_seed(181));
    ClockedTestbench bench;
    ArbiterBench dut(bench, policy);
    constexpr int kClocks = 600;
    std::vector<Clock> clocks(kClocks);
    const auto judge = make_policy(policy);
    ViewportTable rows;
    bool asleep = false;  // so that the clock gate closes now and then
    constexpr int kNotLookedAt = -2;
    for (int clock = 0; clock < kClocks; ++clock) {
        Clock& now = clocks[static_cast<std::size_t>(clock)];
        if (clock == 0 || random.one_in(50)) {
            rows = random_valid_rows(random, random.between(1, kLines), kRaster, 5);
            judge->start_frame(slots_of(policy, rows), rows.size());
            dut.start_at(clock, rows);
            now = Clock{{}, kNotLookedAt, false, 0, false, {}};
            dut.drive(clock, now);
            continue;
        }
        if (random.one_in(20)) asleep = !asleep;
        now.pending.clear();
        std::vector<BusRequest> requests(rows.size());
        const std::vector<std::uint64_t> needs = first_needs(rows);
        for (std::size_t row = 0; row < rows.size(); ++row) {
            now.ready.push_back(!asleep && random.one_in(2));
            now.pending.push_back(asleep || !random.one_in(4));
            requests[row] = {now.pending[row], now.ready[row], static_cast<std::int64_t>(needs[row])};
        }
        now.take = !asleep && random.one_in(2);
        const BusGrant answer = judge->grant(requests);
        now.row = answer.kind == BusGrant::Kind::kBurst ? answer.row : -1;
        now.lost = answer.kind == BusGrant::Kind::kLost;
        now.recovered = answer.recovered_slots;
        if (now.take) judge->take(answer);
        dut.drive(clock, now);
    }
    bench.run_through(kClocks);
    for (int clock = 0; clock < kClocks; ++clock) {
        const Clock& wanted = clocks[static_cast<std::size_t>(clock)];
        if (wanted.row != kNotLookedAt) dut.check(clock, wanted);
    }
}

TEST_CASE("bus arbiter: irsa's pins say what the policy says, over random frames") {
    check_against_policy(Arbitration::kIrsa);
}
TEST_CASE("bus arbiter: slot-allocation's pins say what the policy says, over random frames") {
    check_against_policy(Arbitration::kSlotAllocation);
}
TEST_CASE("bus arbiter: round-robin's pins say what the policy says, over random frames") {
    check_against_policy(Arbitration::kRoundRobin);
}
TEST_CASE("bus arbiter: edf's pins say what the policy says, over random frames") {
    check_against_policy(Arbitration::kEdf);
}

}  // namespace
}  // namespace metabuffer::test::bus_arbiter_test
