#include "monitors/arbiter_monitor.h"

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/wires.h"
#include "support/scenarios.h"
#include "violations.h"

namespace metabuffer::test::arbiter_monitor_test {

// An arbiter, played by the test, breaks each rule of docs/monitors.md once, and no other rule before it.
namespace {

constexpr int kRows = 3;
constexpr int kEnd = 40;
constexpr int kStart = 10;  ///< the edge that sees the frame's start
constexpr int kAsk = 12;    ///< the first at which the bus asks

/// The lines at an edge.
struct Lines {
    bool take = false;
    std::vector<bool> usable{true, true, true};  ///< ready; pixels are always left
    int grant = -1;                              ///< the row, from 0
    bool search = false;
    bool lost = false;
    int recovered = 0;
    int slot = 0;
    std::vector<std::uint64_t> deadlines{30, 20, 10};
};

Scenario scenario_of(Arbitration arbitration, int grant_cycles, SlotTableMaker maker) {
    Scenario scenario = small_scenario(8, 4, kRows);
    scenario.bus.arbitration = arbitration;
    scenario.bus.grant_cycles = grant_cycles;
    scenario.bus.slot_table = maker;
    scenario.renderers.push_back(renderer_of({PixelImage(8, 4)}));
    return scenario;
}

struct ArbiterBench {
    ClockedTestbench bench;
    Scenario scenario;
    Violations violations{bench.core};
    sc_core::sc_signal<bool> start, take, grant_valid, search, lost;
    sc_core::sc_signal<rtl::FrontTable> table;
    sc_core::sc_signal<std::uint16_t> recovered, slot;
    rtl::SignalBank<bool> pending, ready, grant;
    rtl::SignalBank<std::uint64_t> deadline;
    monitors::ArbiterMonitor monitor;
    std::map<int, Lines> lines;
    std::map<int, bool> pending_low;  ///< edges at which no row has pixels left
    bool extra_grant = false;         ///< GRANT_VALID stays low

    explicit ArbiterBench(Arbitration arbitration = Arbitration::kIrsa, int grant_cycles = 0,
                          SlotTableMaker maker = SlotTableMaker::kHost)
        : scenario(scenario_of(arbitration, grant_cycles, maker)),
          pending(kRows, rtl::Wires::name_of("pending")),
          ready(kRows, rtl::Wires::name_of("ready")),
          grant(kRows, rtl::Wires::name_of("grant")),
          deadline(kRows, rtl::Wires::name_of("deadline")),
          monitor("monitor", scenario, 0, violations.log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.start_i(start);
        monitor.table_i(table);
        monitor.take_i(take);
        monitor.grant_valid_i(grant_valid);
        monitor.search_i(search);
        monitor.lost_i(lost);
        monitor.recovered_i(recovered);
        monitor.slot_i(slot);
        for (std::size_t row = 0; row < kRows; ++row) {
            monitor.pending_i[row](pending[row]);
            monitor.ready_i[row](ready[row]);
            monitor.grant_i[row](grant[row]);
            if (monitor.deadline_i.size() > 0) monitor.deadline_i[row](deadline[row]);
        }
        rtl::FrontTable rows;
        for (int display = 1; display <= kRows; ++display)
            rows.rows.push_back(table_row(display, {0, 0}, {1, 1}, {0, 0}));
        if (arbitration != Arbitration::kEdf) rows.slots = {0, 1, 0, 2};
        bench.core.each_clock([this, rows](int clock) {
            const auto found = lines.find(clock);
            drive(found == lines.end() ? Lines{} : found->second);
            start.write(clock == kStart);
            table.write(rows);
            for (std::size_t row = 0; row < kRows; ++row) pending[row].write(pending_low.count(clock) == 0);
        });
    }

    void drive(const Lines& now) {
        take.write(now.take);
        search.write(now.search);
        lost.write(now.lost);
        grant_valid.write(now.grant >= 0 && !extra_grant);
        recovered.write(static_cast<std::uint16_t>(now.recovered));
        slot.write(static_cast<std::uint16_t>(now.slot));
        for (std::size_t row = 0; row < kRows; ++row) {
            ready[row].write(now.usable[row]);
            grant[row].write(static_cast<int>(row) == now.grant);
            deadline[row].write(now.deadlines[row]);
        }
    }
    Lines& at(int clock) {
        lines[clock].take = true;
        return lines[clock];
    }
    /// The bus asks at an edge, and a row has the grant.
    Lines& grants(int clock, int row, int slot_pointer, int passed = 0) {
        Lines& now = at(clock);
        now.grant = row;
        now.slot = slot_pointer;
        now.recovered = passed;
        return now;
    }
    void run() { bench.run_through(kEnd); }
};

}  // namespace

TEST_CASE("arbiter monitor: grants by the slot table break no rule", "[monitors]") {
    ArbiterBench bench;
    bench.grants(kAsk, 0, 0);
    bench.grants(kAsk + 1, 1, 1);
    bench.grants(kAsk + 6, 2, 2, 1).usable = {false, false, true};
    bench.at(kAsk + 7).usable = {false, false, false};
    bench.grants(kAsk + 8, 1, 0, 1).usable = {false, true, true};
    bench.grants(kAsk + 9, 0, 2);
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.grants() == 5);
    CHECK(bench.monitor.recovered_slots() == 2);
    CHECK(bench.monitor.lost_slots() == 0);
}

TEST_CASE("arbiter monitor: lines do not matter while the bus does not ask", "[monitors]") {
    ArbiterBench bench;
    bench.lines[kAsk].grant = 2;
    bench.lines[kAsk].recovered = 7;
    bench.grants(kAsk + 1, 0, 0);
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("arbiter monitor: a grant line without GRANT_VALID", "[monitors]") {
    ArbiterBench bench;
    bench.extra_grant = true;
    bench.grants(kAsk, 0, 0);
    bench.run();
    bench.violations.check_only("arbiter/one-hot", "bus_arbiter_1.grant", kAsk, 0);
}

TEST_CASE("arbiter monitor: a grant to a row whose composer takes no slot", "[monitors]") {
    ArbiterBench bench;
    bench.grants(kAsk, 0, 0).usable = {false, true, true};
    bench.run();
    bench.violations.check_only("arbiter/request", "bus_arbiter_1.grant", kAsk, 0);
}

TEST_CASE("arbiter monitor: a grant to a row that has no pixels left", "[monitors]") {
    ArbiterBench bench;
    bench.pending_low[kAsk] = true;
    bench.grants(kAsk, 0, 0);
    bench.run();
    bench.violations.check_only("arbiter/request", "bus_arbiter_1.grant", kAsk, 0);
}

TEST_CASE("arbiter monitor: a slot out of order", "[monitors]") {
    ArbiterBench bench;
    bench.grants(kAsk, 0, 0);
    bench.grants(kAsk + 1, 2, 1, 2);
    bench.run();
    bench.violations.check_only("arbiter/order", "bus_arbiter_1.grant", kAsk + 1, 0);
}

TEST_CASE("arbiter monitor: nobody is granted while somebody is ready", "[monitors]") {
    ArbiterBench bench;
    bench.at(kAsk).usable = {false, false, true};
    bench.run();
    bench.violations.check_only("arbiter/order", "bus_arbiter_1.grant", kAsk, 0);
}

TEST_CASE("arbiter monitor: a wrong number of recovered slots", "[monitors]") {
    ArbiterBench bench;
    bench.grants(kAsk, 1, 0, 0).usable = {false, true, true};
    bench.run();
    bench.violations.check_only("arbiter/recovered", "bus_arbiter_1.recovered", kAsk, 0);
}

TEST_CASE("arbiter monitor: a slot pointer that has not moved", "[monitors]") {
    ArbiterBench bench;
    bench.grants(kAsk, 0, 0);
    bench.grants(kAsk + 1, 1, 0);
    bench.run();
    bench.violations.check_only("arbiter/slot", "bus_arbiter_1.slot", kAsk + 1, 0);
}

TEST_CASE("arbiter monitor: without recovery a slot that its owner cannot use is lost", "[monitors]") {
    ArbiterBench bench(Arbitration::kSlotAllocation);
    bench.grants(kAsk, 0, 0);
    Lines& lost = bench.at(kAsk + 1);
    lost.usable = {true, false, true};
    lost.lost = true;
    lost.slot = 1;
    bench.grants(kAsk + 9, 0, 2);
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.lost_slots() == 1);
}

TEST_CASE("arbiter monitor: without recovery a slot is not given to another", "[monitors]") {
    ArbiterBench bench(Arbitration::kSlotAllocation);
    bench.grants(kAsk, 1, 0, 1).usable = {false, true, true};
    bench.run();
    bench.violations.check_only("arbiter/order", "bus_arbiter_1.grant", kAsk, 0);
}

TEST_CASE("arbiter monitor: the earliest deadline of those that are ready goes first", "[monitors]") {
    ArbiterBench bench(Arbitration::kEdf);
    bench.grants(kAsk, 2, 0);
    bench.grants(kAsk + 1, 1, 0).usable = {true, true, false};
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("arbiter monitor: a later deadline is granted", "[monitors]") {
    ArbiterBench bench(Arbitration::kEdf);
    bench.grants(kAsk, 0, 0);
    bench.run();
    bench.violations.check_only("arbiter/order", "bus_arbiter_1.grant", kAsk, 0);
}

TEST_CASE("arbiter monitor: a slow arbiter answers by the requests that it decided on", "[monitors]") {
    ArbiterBench bench(Arbitration::kIrsa, 2);
    bench.at(kAsk).usable = {false, false, false};
    bench.at(kAsk + 1).usable = {false, true, false};  // decides
    bench.at(kAsk + 1).search = true;
    bench.at(kAsk + 2).search = true;
    bench.grants(kAsk + 3, 1, 0, 1).usable = {true, false, true};
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("arbiter monitor: a slow arbiter that answers a clock too early", "[monitors]") {
    ArbiterBench bench(Arbitration::kIrsa, 2);
    bench.at(kAsk).search = true;
    bench.grants(kAsk + 1, 0, 0);
    bench.run();
    bench.violations.check_only("arbiter/search", "bus_arbiter_1.search", kAsk + 1, 0);
}

TEST_CASE("arbiter monitor: a slow arbiter that answers a clock too late", "[monitors]") {
    ArbiterBench bench(Arbitration::kIrsa, 2);
    for (int clock = kAsk; clock < kAsk + 3; ++clock) bench.at(clock).search = true;
    bench.run();
    bench.violations.check_only("arbiter/search", "bus_arbiter_1.search", kAsk + 2, 0);
}

TEST_CASE("arbiter monitor: no answer before the slot table is built", "[monitors]") {
    // Four slots, a clock each after the edge that samples the start.
    ArbiterBench bench(Arbitration::kIrsa, 0, SlotTableMaker::kBuilt);
    for (int clock = kAsk; clock < kStart + 1 + 4; ++clock) bench.at(clock).search = true;
    bench.grants(kStart + 1 + 4, 0, 0);
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("arbiter monitor: a grant before the slot table is built", "[monitors]") {
    ArbiterBench bench(Arbitration::kIrsa, 0, SlotTableMaker::kBuilt);
    bench.at(kAsk).search = true;
    bench.grants(kAsk + 1, 0, 0);
    bench.run();
    bench.violations.check_only("arbiter/search", "bus_arbiter_1.search", kAsk + 1, 0);
}

}  // namespace metabuffer::test::arbiter_monitor_test
