#include "monitors/arbiter_monitor.h"

#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "rtl/wires.h"
#include "rule_table.h"
#include "support/scenarios.h"

namespace metabuffer::test::arbiter_monitor_test {

// An arbiter, played by the test, breaks each rule of docs/monitors.md once, and no other rule.
namespace {

constexpr int kRows = 3;
constexpr int kEnd = 40;
constexpr int kStart = 10;  ///< the edge that sees the frame's start
constexpr int kAsk = 12;    ///< the first at which the bus asks

constexpr int kNobody = -1;

enum class Special : std::uint8_t { kNone, kSearch, kLost, kWithoutGrantValid, kNotAsked };

/// The lines at an edge at which the bus asks.
struct Lines {
    int grant = kNobody;           ///< the row, from 0
    int slot = 0;                  ///< the pointer
    int passed = 0;                ///< slots recovered
    const char* requests = "+++";  ///< of the rows: -: its composer takes no slot, 0: it has no pixels left
    Special special = Special::kNone;
};
Lines searching(const char* requests = "+++") { return {kNobody, 0, 0, requests, Special::kSearch}; }

Scenario scenario_of(Arbitration arbitration, int grant_cycles, SlotTableMaker maker) {
    Scenario scenario = small_scenario(8, 4, kRows);
    scenario.bus.arbitration = arbitration;
    scenario.bus.grant_cycles = grant_cycles;
    scenario.bus.slot_table = maker;
    scenario.renderers.push_back(renderer_of({PixelImage(8, 4)}));
    return scenario;
}

struct ArbiterBench : ClockedRuleBench {
    Scenario scenario;
    sc_core::sc_signal<bool> start, take, grant_valid, search, lost;
    sc_core::sc_signal<rtl::FrontTable> table;
    sc_core::sc_signal<std::uint16_t> recovered, slot;
    rtl::SignalArray<bool> pending, ready, grant;
    rtl::SignalArray<std::uint64_t> deadline;
    monitors::ArbiterMonitor monitor;
    std::map<int, Lines> lines;

    ArbiterBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench,
                 Arbitration arbitration = Arbitration::kIrsa, int grant_cycles = 0,
                 SlotTableMaker maker = SlotTableMaker::kHost)
        : ClockedRuleBench(name, testbench),
          scenario(scenario_of(arbitration, grant_cycles, maker)),
          pending(kRows, rtl::Wires::name_of("pending")),
          ready(kRows, rtl::Wires::name_of("ready")),
          grant(kRows, rtl::Wires::name_of("grant")),
          deadline(kRows, rtl::Wires::name_of("deadline")),
          monitor("monitor", scenario, 0, log) {
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
            const Lines now = found == lines.end() ? Lines{} : found->second;
            take.write(found != lines.end() && now.special != Special::kNotAsked);
            search.write(now.special == Special::kSearch);
            lost.write(now.special == Special::kLost);
            grant_valid.write(now.grant != kNobody && now.special != Special::kWithoutGrantValid);
            recovered.write(static_cast<std::uint16_t>(now.passed));
            slot.write(static_cast<std::uint16_t>(now.slot));
            start.write(clock == kStart);
            table.write(rows);
            for (std::size_t row = 0; row < kRows; ++row) {
                pending[row].write(now.requests[row] != '0');
                ready[row].write(now.requests[row] != '-');
                grant[row].write(static_cast<int>(row) == now.grant);
                deadline[row].write(30 - 10 * row);
            }
        });
    }
};

/// The lines by edge.
std::function<void(ArbiterBench&)> shows(const std::map<int, Lines>& lines) {
    return [lines](ArbiterBench& bench) { bench.lines = lines; };
}

const std::string kGrant = "bus_arbiter_1.grant";
const std::string kSearch = "bus_arbiter_1.search";

}  // namespace

TEST_CASE("arbiter monitor: its rules in a table", "[monitors]") {
    ClockedRuleTable<ArbiterBench> rules;
    rules.of();
    rules.row("grants by the slot table", {},
              shows({{kAsk, {0, 0}},
                     {kAsk + 1, {1, 1}},
                     {kAsk + 6, {2, 2, 1, "--+"}},
                     {kAsk + 7, {kNobody, 0, 0, "---"}},
                     {kAsk + 8, {1, 0, 1, "-++"}},
                     {kAsk + 9, {0, 2}}}),
              [](const auto& bench) {
                  CHECK(bench.monitor.grants() == 5);
                  CHECK(bench.monitor.recovered_slots() == 2);
                  CHECK(bench.monitor.lost_slots() == 0);
              });
    rules.row("the lines do not matter while the bus does not ask", {},
              shows({{kAsk, {2, 0, 7, "+++", Special::kNotAsked}}, {kAsk + 1, {0, 0}}}));
    rules.row("a grant line without GRANT_VALID", {{"arbiter/one-hot", kGrant, kAsk, 0}},
              shows({{kAsk, {0, 0, 0, "+++", Special::kWithoutGrantValid}}}));
    rules.row("a grant to a row whose composer takes no slot", {{"arbiter/request", kGrant, kAsk, 0}},
              shows({{kAsk, {0, 0, 0, "-++"}}}));
    rules.row("a grant to a row that has no pixels left", {{"arbiter/request", kGrant, kAsk, 0}},
              shows({{kAsk, {0, 0, 0, "000"}}}));
    rules.row("a slot out of order", {{"arbiter/order", kGrant, kAsk + 1, 0}},
              shows({{kAsk, {0, 0}}, {kAsk + 1, {2, 1, 2}}}));
    rules.row("nobody is granted while somebody is ready", {{"arbiter/order", kGrant, kAsk, 0}},
              shows({{kAsk, {kNobody, 0, 0, "--+"}}}));
    rules.row("a wrong number of recovered slots",
              {{"arbiter/recovered", "bus_arbiter_1.recovered", kAsk, 0}}, shows({{kAsk, {1, 0, 0, "-++"}}}));
    rules.row("a slot pointer that has not moved", {{"arbiter/slot", "bus_arbiter_1.slot", kAsk + 1, 0}},
              shows({{kAsk, {0, 0}}, {kAsk + 1, {1, 0}}}));

    rules.of(Arbitration::kSlotAllocation);
    rules.row("without recovery a slot that its owner cannot use is lost", {},
              shows({{kAsk, {0, 0}}, {kAsk + 1, {kNobody, 1, 0, "+-+", Special::kLost}}, {kAsk + 9, {0, 2}}}),
              [](const auto& bench) { CHECK(bench.monitor.lost_slots() == 1); });
    rules.row("without recovery a slot is given to another", {{"arbiter/order", kGrant, kAsk, 0}},
              shows({{kAsk, {1, 0, 1, "-++"}}}));

    rules.of(Arbitration::kEdf);
    rules.row("the earliest deadline of those that are ready goes first", {},
              shows({{kAsk, {2, 0}}, {kAsk + 1, {1, 0, 0, "++-"}}}));
    rules.row("a later deadline is granted", {{"arbiter/order", kGrant, kAsk, 0}}, shows({{kAsk, {0, 0}}}));

    rules.of(Arbitration::kIrsa, 2);
    rules.row("a slow arbiter answers by the requests that it decided on, at the second clock", {},
              shows({{kAsk, {kNobody, 0, 0, "---"}},
                     {kAsk + 1, searching("-+-")},
                     {kAsk + 2, searching()},
                     {kAsk + 3, {1, 0, 1, "+-+"}}}));
    rules.row("a slow arbiter answers a clock too early", {{"arbiter/search", kSearch, kAsk + 1, 0}},
              shows({{kAsk, searching()}, {kAsk + 1, {0, 0}}}));
    rules.row("a slow arbiter answers a clock too late", {{"arbiter/search", kSearch, kAsk + 2, 0}},
              shows({{kAsk, searching()}, {kAsk + 1, searching()}, {kAsk + 2, searching()}}));

    // The table is built in four clocks, one a slot, after the edge that samples the start.
    rules.of(Arbitration::kIrsa, 0, SlotTableMaker::kBuilt);
    rules.row(
        "the first answer comes when the slot table is built", {},
        shows({{kAsk, searching()}, {kAsk + 1, searching()}, {kAsk + 2, searching()}, {kStart + 5, {0, 0}}}));
    rules.row("a grant before the slot table is built", {{"arbiter/search", kSearch, kAsk + 1, 0}},
              shows({{kAsk, searching()}, {kAsk + 1, {0, 0}}}));
    rules.run_and_check(kEnd);
}

}  // namespace metabuffer::test::arbiter_monitor_test
