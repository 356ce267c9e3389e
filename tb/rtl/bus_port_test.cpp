#include "rtl/bus_port.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/wires.h"
#include "rtl/write_buffer.h"
#include "support/images.h"
#include "support/rows.h"
#include "support/scenarios.h"
#include "support/traced_values.h"

// The input framebuffer's tests check at its pins what the bus carries at which clock. These tests check what the port
// asks of arbiter and memory; the test plays both.
namespace metabuffer::test::bus_port_test {
namespace {

using rtl::BusBeat;
using rtl::BusPort;
using rtl::FrontTable;
using rtl::MemoryCommand;
using rtl::MemoryData;
using Command = MemoryCommand::Kind;

constexpr int kWidth = 16;  ///< of the image
constexpr int kDisplays = 2;

struct PortBench {
    Scenario scenario;
    ClockDomain& core;
    sc_core::sc_signal<bool> request, answer, fresh, start, take, grant_valid, search, lost;
    sc_core::sc_signal<FrontTable> table;
    sc_core::sc_signal<BusBeat> bus;
    rtl::SignalBank<bool> busready, tableready, pending, ready, grant;
    rtl::SignalBank<std::uint64_t> deadline;
    sc_core::sc_signal<std::uint16_t> recovered;
    sc_core::sc_signal<MemoryCommand> command;
    sc_core::sc_signal<MemoryData> data;
    sc_core::sc_signal<bool> front, drain;
    rtl::SignalBank<bool> write_full{rtl::WriteBuffer::kHalves, rtl::Wires::name_of("write_full")};
    rtl::SignalBank<rtl::WriteBlock> write_block{rtl::WriteBuffer::kHalves,
                                                 rtl::Wires::name_of("write_block")};
    std::vector<bool> starts;  ///< for each frame start, whether its pair is fresh
    BusCounters counters;
    BusPort dut;
    const Recording<MemoryCommand>& commands;
    const Recording<bool>& takes;
    const Recording<bool>& requests;
    const Recording<BusBeat>& beats;
    std::vector<const Recording<bool>*> pendings, readies;
    std::vector<const Recording<std::uint64_t>*> deadlines;

    explicit PortBench(ClockedTestbench& bench, Arbitration arbitration = Arbitration::kRoundRobin,
                       int page_miss = 3, int width_bits = 128, int banks = 1, int precharge = 0,
                       int refresh_interval = 0, int refresh = 0)
        : PortBench(bench,
                    make(arbitration, page_miss, width_bits, banks, precharge, refresh_interval, refresh)) {}
    PortBench(ClockedTestbench& bench, Scenario made)
        : scenario(std::move(made)),
          core(bench.core),
          busready(kDisplays, rtl::Wires::name_of("busready"), true),
          tableready(kDisplays, rtl::Wires::name_of("tableready"), true),
          pending(kDisplays, rtl::Wires::name_of("pending")),
          ready(kDisplays, rtl::Wires::name_of("ready")),
          grant(kDisplays, rtl::Wires::name_of("grant")),
          deadline(scenario.bus.arbitration == Arbitration::kEdf ? kDisplays : 0,
                   rtl::Wires::name_of("deadline")),
          dut(
              "bus_port", scenario, scenario.renderers[0],
              [this](bool fresh_now) { starts.push_back(fresh_now); }, counters),
          commands(core.record_sampled(command)),
          takes(core.record_sampled(take)),
          requests(core.record(request)),
          beats(core.record(bus)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.request_o(request);
        dut.answer_i(answer);
        dut.fresh_i(fresh);
        dut.table_i(table);
        dut.bus_o(bus);
        dut.start_o(start);
        dut.take_o(take);
        dut.grant_valid_i(grant_valid);
        dut.search_i(search);
        dut.lost_i(lost);
        dut.recovered_i(recovered);
        dut.command_o(command);
        dut.data_i(data);
        for (auto& port : dut.front_i) port(front);
        for (auto& port : dut.drain_o) port(drain);
        for (std::size_t half = 0; half < dut.write_full_i.size(); ++half) {
            dut.write_full_i[half](write_full[half]);
            dut.write_block_i[half](write_block[half]);
        }
        for (std::size_t line = 0; line < kDisplays; ++line) {
            dut.busready_i[line](busready[line]);
            dut.tableready_i[line](tableready[line]);
            dut.pending_o[line](pending[line]);
            dut.ready_o[line](ready[line]);
            dut.grant_i[line](grant[line]);
            pendings.push_back(&core.record_sampled(pending[line]));
            readies.push_back(&core.record_sampled(ready[line]));
            if (deadline.size() > 0) {
                dut.deadline_o[line](deadline[line]);
                deadlines.push_back(&core.record_sampled(deadline[line]));
            }
        }
        bench.trace(dut);
    }
    static Scenario make(Arbitration arbitration, int page_miss, int width_bits, int banks, int precharge,
                         int refresh_interval, int refresh) {
        Scenario scenario = small_scenario(64, 64, kDisplays);
        scenario.bus.arbitration = arbitration;
        scenario.bus.width_bits = width_bits;
        scenario.bus.burst_pixels = 8;
        scenario.memory.words_per_cycle = 2;
        scenario.memory.page_words = 32;
        scenario.memory.page_miss_cycles = page_miss;
        scenario.memory.banks = banks;
        scenario.memory.precharge_cycles = precharge;
        scenario.memory.refresh_interval_cycles = refresh_interval;
        scenario.memory.refresh_cycles = refresh;
        scenario.composer.ready_space_pixels = 8;
        scenario.renderers.push_back(renderer_of({PixelImage(kWidth, 8)}));
        return scenario;
    }
    /// The answer to the first question is seen at edge kAnswer. The frame's first grant may be taken at edge kSend.
    static constexpr int kAnswer = 6;
    static constexpr int kSend = kAnswer + 1 + 1 + 2;  // frame start, two rows
    /// The same on a bus on which a row of the table takes more than a clock.
    static constexpr int send_at(int width_bits) { return kSend + 2 * (128 / width_bits - 1); }
    void begin(const ViewportTable& rows) {
        core.drive(table, 1, FrontTable{rows, {}});
        core.drive(fresh, kAnswer - 1, true);
        core.drive(answer, kAnswer - 1, true);  // captured there, seen at the next edge
    }
    /// Row `row` (none: -1) has the grant from edge `clock` on.
    void give(int clock, int row) {
        for (std::size_t line = 0; line < kDisplays; ++line) {
            core.drive(grant[line], clock, static_cast<int>(line) == row);
        }
        core.drive(grant_valid, clock, row >= 0);
    }
    /// The memory's command, clocks from the first grant on.
    Command kind_at(int clock) const { return commands.at(kSend + clock).kind; }
    std::vector<int> clocks_of(Command kind, int last) const {
        std::vector<int> clocks;
        for (int clock = 0; clock <= last; ++clock) {
            if (commands.at(clock).kind == kind) clocks.push_back(clock);
        }
        return clocks;
    }
    std::vector<std::uint32_t> columns_at(int clock) const {
        const MemoryCommand& sent = commands.at(clock);
        return {sent.columns.begin(), sent.columns.begin() + sent.count};
    }
};

using Columns = std::vector<std::uint32_t>;

/// A: the image's left part, 5 pixels a row. B: two whole rows further down.
ViewportTable two_rows() {
    return {table_row(1, {0, 0}, {5, 3}, {0, 0}), table_row(2, {0, 4}, {kWidth, 2}, {0, 0})};
}

TEST_CASE("bus port: a page is activated in the clock of its grant, and read when the page miss is over") {
    ClockedTestbench bench;
    PortBench dut(bench);
    dut.begin(two_rows());
    dut.give(PortBench::kSend + 2, 1);
    bench.run_through(PortBench::kSend + 14);
    const int granted = PortBench::kSend + 2;
    CHECK(dut.requests.rises() == std::vector<int>{0});
    CHECK(dut.starts == std::vector<bool>{true});
    // Asked at edge 0: a frame finds no page open.
    CHECK(dut.commands.at(1).kind == Command::kPrechargeAll);
    for (int clock = 2; clock < granted; ++clock) {
        CHECK(dut.commands.at(clock).kind == Command::kNone);
    }
    CHECK(dut.commands.at(granted).kind == Command::kActivate);
    CHECK(dut.commands.at(granted).row == 2);  // word 64 in pages of 32
    CHECK(dut.commands.at(granted + 1).kind == Command::kNone);
    CHECK(dut.commands.at(granted + 2).kind == Command::kNone);
    for (int beat = 0; beat < 4; ++beat) {
        CHECK(dut.commands.at(granted + 3 + beat).kind == Command::kRead);
        CHECK(dut.columns_at(granted + 3 + beat) ==
              Columns{2U * static_cast<unsigned>(beat), 2U * static_cast<unsigned>(beat) + 1});
    }
    // The burst of 8 is over, and the same row has the grant again: the page is open.
    CHECK(dut.columns_at(granted + 7) == Columns{8, 9});
}

TEST_CASE("bus port: a beat continues past the source row's end, and stops at the page's end") {
    ClockedTestbench bench;
    PortBench dut(bench);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 0);
    bench.run_through(PortBench::kSend + 16);
    const int read = PortBench::kSend + 3;
    CHECK(dut.columns_at(read) == Columns{0, 1});
    CHECK(dut.columns_at(read + 2) == Columns{4, 16});  // 5 pixels a row, 16 to the next one
    CHECK(dut.columns_at(read + 3) == Columns{17, 18});
    CHECK(dut.columns_at(read + 4) == Columns{19, 20});           // the second burst
    CHECK(dut.commands.at(read + 5).kind == Command::kActivate);  // word 32 is the next page's
    CHECK(dut.commands.at(read + 5).row == 1);
}

TEST_CASE("bus port: a bank with a page open is precharged, then activated, then read") {
    ClockedTestbench bench;
    PortBench dut(bench, Arbitration::kRoundRobin, 5, 128, 2,
                  2);  // 2 banks; 2 clocks to close a page, 3 to open one
    dut.begin({table_row(1, {0, 0}, {kWidth, 1}, {0, 0}), table_row(2, {0, 4}, {kWidth, 1}, {0, 0})});
    dut.give(PortBench::kSend, 0);      // page 0, in bank 0, a burst of 4 beats
    dut.give(PortBench::kSend + 1, 1);  // page 2, in bank 0 as well
    bench.run_through(PortBench::kSend + 8);
    CHECK(shows(dut.dut, "precharging[1]=1"));
    bench.run_through(PortBench::kSend + 9);
    CHECK(shows(dut.dut, "precharging[1]=0"));
    bench.run_through(PortBench::kSend + 16);
    CHECK(dut.kind_at(0) == Command::kActivate);  // the bank was closed
    CHECK(dut.kind_at(1) == Command::kNone);
    CHECK(dut.kind_at(2) == Command::kNone);
    for (int clock = 3; clock < 7; ++clock) CHECK(dut.kind_at(clock) == Command::kRead);
    CHECK(dut.kind_at(7) == Command::kPrecharge);
    CHECK(dut.kind_at(8) == Command::kNone);
    CHECK(dut.kind_at(9) == Command::kActivate);
    CHECK(dut.commands.at(PortBench::kSend + 9).row == 2);
    CHECK(dut.commands.at(PortBench::kSend + 9).bank == 0);
    CHECK(dut.kind_at(10) == Command::kNone);
    CHECK(dut.kind_at(11) == Command::kNone);
    CHECK(dut.kind_at(12) == Command::kRead);
    CHECK(dut.counters.page_misses == 2);
    CHECK(dut.counters.page_miss_cycles == 3 + 5);
}

/// BUSREADY stops a burst at a clock from the first grant on. Row 1's fourth burst goes from page 2 to page 3 after its
/// first beat; row 0, which has the grant then, lies in page 3.
struct StoppedPortBench : PortBench {
    StoppedPortBench(ClockedTestbench& bench, int precharge, int stopped_at)
        : PortBench(bench, Arbitration::kRoundRobin, 5, 128, 1, precharge) {
        begin({table_row(1, {0, 6}, {kWidth, 1}, {0, 0}), table_row(2, {2, 4}, {13, 3}, {0, 0})});
        give(kSend, 1);
        core.drive(busready[1], kSend + stopped_at, false);
        give(kSend + stopped_at, 0);
    }
};

TEST_CASE("bus port: a page whose opening was broken off in its precharge is not open for the next burst") {
    ClockedTestbench bench;
    StoppedPortBench dut(bench, 2, 17);
    bench.run_through(PortBench::kSend + 26);
    CHECK(dut.kind_at(15) == Command::kRead);
    CHECK(dut.columns_at(PortBench::kSend + 15) == Columns{29, 30});
    CHECK(dut.kind_at(16) == Command::kPrecharge);
    CHECK(dut.takes.at(PortBench::kSend + 17));  // BUSREADY is low: the burst is over, the grant taken
    CHECK(dut.kind_at(17) == Command::kPrecharge);
    CHECK(dut.kind_at(18) == Command::kNone);
    CHECK(dut.kind_at(19) == Command::kActivate);
    CHECK(dut.commands.at(PortBench::kSend + 19).row == 3);
    CHECK(dut.kind_at(22) == Command::kRead);
    CHECK(dut.columns_at(PortBench::kSend + 22) == Columns{0, 1});
}

TEST_CASE(
    "bus port: a page whose opening was broken off in its activation must be opened anew, if banks are "
    "timed") {
    ClockedTestbench bench;
    StoppedPortBench dut(bench, 2, 20);
    bench.run_through(PortBench::kSend + 30);
    CHECK(dut.kind_at(16) == Command::kPrecharge);
    CHECK(dut.kind_at(18) == Command::kActivate);
    CHECK(dut.takes.at(PortBench::kSend + 20));
    CHECK(dut.kind_at(20) == Command::kPrecharge);
    CHECK(dut.kind_at(22) == Command::kActivate);
    CHECK(dut.commands.at(PortBench::kSend + 22).row == 3);
    CHECK(dut.kind_at(24) == Command::kNone);
    CHECK(dut.kind_at(25) == Command::kRead);
    CHECK(dut.columns_at(PortBench::kSend + 25) == Columns{0, 1});
}

TEST_CASE("bus port: without precharge_cycles a page whose opening was broken off counts as open") {
    ClockedTestbench bench;
    StoppedPortBench dut(bench, 0, 20);
    bench.run_through(PortBench::kSend + 30);
    CHECK(dut.kind_at(18) == Command::kActivate);
    CHECK(dut.takes.at(PortBench::kSend + 20));
    CHECK(dut.kind_at(20) == Command::kRead);
    CHECK(dut.columns_at(PortBench::kSend + 20) == Columns{0, 1});
}

TEST_CASE("bus port: clocks in which the arbiter builds its table are counted as its own, not as polls") {
    ClockedTestbench bench;
    PortBench dut(bench);
    constexpr int kBuildClocks = 30;
    dut.begin(two_rows());
    bench.core.drive(dut.search, PortBench::kSend, true);
    bench.core.drive(dut.search, PortBench::kSend + kBuildClocks, false);
    dut.give(PortBench::kSend + kBuildClocks + 5, 0);
    bench.run_through(PortBench::kSend + kBuildClocks + 8);
    CHECK(dut.counters.grant_cycles == kBuildClocks);
    CHECK(dut.counters.poll_cycles == 5);
}

TEST_CASE("bus port: the register of an open page is no wider than the number of the image's last page") {
    ClockedTestbench bench;
    PortBench dut(bench);  // 128 words in pages of 32
    CHECK(shows(dut.dut, "bank_0_page[2]=0"));
}

TEST_CASE("bus port: it has registers for as many rows and composers as there are displays") {
    ClockedTestbench bench;
    PortBench dut(bench);
    CHECK(shows(dut.dut, "row_2_left[8]=0"));
    CHECK(shows(dut.dut, "uncounted_2[1]=0"));
    CHECK_FALSE(shows(dut.dut, "row_3_left[8]=0"));
    CHECK_FALSE(shows(dut.dut, "uncounted_3[1]=0"));
}

TEST_CASE("bus port: a lost slot and a grant are seen after any number of polls") {
    ClockedTestbench bench;
    Scenario scenario = PortBench::make(Arbitration::kSlotAllocation, 3, 128, 1, 0, 0, 0);
    scenario.bus.burst_pixels = 2;  // a lost slot takes a clock
    PortBench dut(bench, scenario);
    dut.begin(two_rows());
    constexpr int kLost = PortBench::kSend + 20;
    constexpr int kGrant = kLost + 60;
    bench.core.drive(dut.lost, kLost, true);
    bench.core.drive(dut.lost, kLost + 30, false);
    dut.give(kGrant, 1);
    bench.run_through(kGrant + 1);
    CHECK(dut.counters.lost_cycles == 30);
    CHECK(dut.counters.poll_cycles == 20 + 30);
    CHECK(dut.clocks_of(Command::kActivate, kGrant + 1) == std::vector<int>{kGrant});
}

TEST_CASE("bus port: a beat of a narrow bus carries the words that stood at its read's edge alone") {
    ClockedTestbench bench;
    PortBench dut(bench, Arbitration::kRoundRobin, 0, 16);  // four clocks a beat
    dut.begin(two_rows());
    const int first = PortBench::send_at(16);
    dut.give(first, 1);
    MemoryData words;
    words.count = 1;
    words.words[0] = 77;
    dut.core.drive(dut.data, first, words);
    dut.core.drive(dut.data, first + 1, MemoryData{});
    bench.run_through(first + 3);
    CHECK(dut.beats.at(first + 2).kind == BusBeat::Kind::kNone);
    CHECK(dut.beats.at(first + 3).kind == BusBeat::Kind::kPixels);
    CHECK(dut.beats.at(first + 3).words[0] == 77);
}

TEST_CASE("bus port: after a burst that was stopped in a beat its row is not ready for a clock, once") {
    ClockedTestbench bench;
    PortBench dut(bench, Arbitration::kRoundRobin, 0, 32);  // two clocks a beat
    dut.begin(two_rows());
    const int first = PortBench::send_at(32);
    dut.give(first, 1);
    // Edge 5 moves the second half of the third beat.
    dut.core.drive(dut.busready[1], first + 5, false);
    dut.core.drive(dut.busready[1], first + 6, true);
    bench.run_through(first + 23);
    CHECK(dut.beats.at(first + 5).remaining == 0);
    CHECK_FALSE(dut.readies[1]->at(first + 6));
    // Eight beats of the next burst follow, then a third burst.
    for (int clock = first + 7; clock <= first + 23; ++clock) CHECK(dut.readies[1]->at(clock));
    CHECK(dut.counters.bursts == 3);
}

TEST_CASE("bus port: no row asks for the bus after a reset, and the first pair is requested again") {
    ClockedTestbench bench;
    PortBench dut(bench);
    dut.begin(two_rows());
    bench.core.pulse(bench.reset, PortBench::kSend + 4);
    bench.run_through(PortBench::kSend + 8);
    CHECK(dut.requests.falls() == std::vector<int>{PortBench::kSend + 4});
    CHECK(dut.requests.rises() == std::vector<int>{0, PortBench::kSend + 5});
    for (const Recording<bool>* pending : dut.pendings) {
        CHECK_FALSE(pending->at(2));  // power-up, and nothing yet
        CHECK(pending->at(PortBench::kSend + 2));
        CHECK_FALSE(pending->at(PortBench::kSend + 6));
    }
}

TEST_CASE("bus port: a reset wakes a port that polls, and no row asks any more") {
    ClockedTestbench bench;
    PortBench dut(bench);
    for (std::size_t line = 0; line < kDisplays; ++line) bench.core.drive(dut.busready[line], 2, false);
    dut.begin(two_rows());
    const int reset = PortBench::kSend + 40;
    bench.core.pulse(bench.reset, reset);
    bench.run_through(reset + 4);
    for (const Recording<bool>* pending : dut.pendings) {
        CHECK(pending->at(reset - 1));
        CHECK_FALSE(pending->at(reset + 2));
    }
}

/// A memory that is refreshed every 14 clocks, for four of them.
struct RefreshedPortBench : PortBench {
    explicit RefreshedPortBench(ClockedTestbench& bench)
        : PortBench(bench, Arbitration::kRoundRobin, 3, 128, 1, 0, 14, 4) {}
};

using Clocks = std::vector<int>;

TEST_CASE("bus port: a refresh is sent when it is due, whatever the bus does") {
    ClockedTestbench bench;
    RefreshedPortBench dut(bench);
    bench.run_through(60);  // it waits for its first pair
    CHECK(dut.clocks_of(Command::kRefresh, 60) == Clocks{14, 28, 42, 56});
    CHECK(shows(dut.dut, "precharging[1]=0"));
    CHECK(dut.counters.refresh_cycles == 0);
    CHECK(dut.counters.idle_cycles == 61 + 2);  // and those of reset
}

TEST_CASE("bus port: a burst waits for a refresh, and opens its page after it") {
    ClockedTestbench bench;
    RefreshedPortBench dut(bench);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);
    bench.run_through(24);
    CHECK(dut.clocks_of(Command::kActivate, 24) == Clocks{10, 18});
    CHECK(dut.clocks_of(Command::kRefresh, 24) == Clocks{14});
    CHECK(dut.clocks_of(Command::kRead, 24) == Clocks{13, 21, 22, 23, 24});
    CHECK(dut.counters.refresh_cycles == 4);
    CHECK(dut.counters.page_misses == 2);
    CHECK(dut.counters.page_miss_cycles == 6);
}

TEST_CASE("bus port: a page that is being opened when a refresh begins is opened again") {
    ClockedTestbench bench;
    RefreshedPortBench dut(bench);
    dut.begin(two_rows());
    dut.give(11, 1);
    bench.run_through(22);
    CHECK(dut.clocks_of(Command::kActivate, 22) == Clocks{11, 18});
    CHECK(dut.clocks_of(Command::kRead, 22) == Clocks{21, 22});
    CHECK(dut.counters.refresh_cycles == 4);
    CHECK(dut.counters.page_misses == 2);
    CHECK(dut.counters.page_miss_cycles == 3 + 3);
}

TEST_CASE("bus port: a grant in a refresh is taken at once and waits") {
    ClockedTestbench bench;
    RefreshedPortBench dut(bench);
    dut.begin(two_rows());
    dut.give(16, 1);
    bench.run_through(22);
    CHECK(dut.counters.poll_cycles == 16 - PortBench::kSend);
    CHECK(dut.counters.refresh_cycles == 2);
    CHECK(dut.clocks_of(Command::kActivate, 22) == Clocks{18});
    CHECK(dut.counters.page_misses == 1);
    CHECK(dut.counters.page_miss_cycles == 3);
}

// ---- shared ports ----

/// The image has pages 0 to 3, the other image pages 4 to 7. A page takes three clocks to open; two words are moved in
/// a clock.
struct SharedPortBench : PortBench {
    const Recording<bool>& drains;

    explicit SharedPortBench(ClockedTestbench& bench, int banks = 1, int refresh_interval = 0)
        : SharedPortBench(bench, shared(banks, refresh_interval)) {}
    SharedPortBench(ClockedTestbench& bench, Scenario made)
        : PortBench(bench, std::move(made)), drains(core.record(drain)) {}
    static Scenario shared(int banks, int refresh_interval) {
        Scenario scenario =
            make(Arbitration::kRoundRobin, 3, 128, banks, 0, refresh_interval, refresh_interval > 0 ? 4 : 0);
        scenario.memory.ports = MemoryPorts::kShared;
        scenario.memory.write_block_words = 16;
        return scenario;
    }
    /// Fills a half with a block. The block's first command may go out at edge `clock`: the edge before sees the half
    /// full.
    void fill(int clock, std::size_t half, int address, int words, bool full = true) {
        core.drive(write_block[half], clock - 2,
                   rtl::WriteBlock{static_cast<std::uint64_t>(address), static_cast<std::uint32_t>(words),
                                   rtl::MemoryWrite::kColourBytes});
        core.drive(write_full[half], clock - 2, full);
    }
};

TEST_CASE("bus port: a full half is written at once while no burst is under way, words_per_cycle a clock") {
    ClockedTestbench bench;
    SharedPortBench dut(bench);
    dut.fill(10, 0, 32 * 5 + 16, 5);
    bench.run_through(20);  // it waits for its first pair
    CHECK(dut.clocks_of(Command::kActivate, 20) == Clocks{10});
    CHECK(dut.commands.at(10).row == 5);
    CHECK(dut.clocks_of(Command::kWrite, 20) == Clocks{13, 14, 15});
    CHECK(dut.commands.at(13).row == 5);
    CHECK(dut.commands.at(13).byte_mask == rtl::MemoryWrite::kColourBytes);
    CHECK(dut.columns_at(13) == Columns{16, 17});
    CHECK(dut.columns_at(14) == Columns{18, 19});
    CHECK(dut.columns_at(15) == Columns{20});
    CHECK(dut.drains.rises() == Clocks{15});
    CHECK(dut.counters.write_cycles == 0);
    CHECK(dut.counters.idle_cycles == 21 + 2);
}

TEST_CASE("bus port: halves are written in turn, and the second block finds the first one's page open") {
    ClockedTestbench bench;
    SharedPortBench dut(bench);
    dut.fill(10, 0, 128, 4);
    dut.fill(11, 1, 132, 4);
    dut.fill(20, 0, 160, 2, false);  // the change, not the level, says that it is full
    bench.run_through(28);
    CHECK(dut.clocks_of(Command::kActivate, 28) == Clocks{10, 20});
    CHECK(dut.clocks_of(Command::kWrite, 28) == Clocks{13, 14, 15, 16, 23});
    CHECK(dut.columns_at(15) == Columns{4, 5});
    CHECK(dut.drains.rises() == Clocks{14, 23});
    CHECK(dut.drains.falls() == Clocks{16});
}

TEST_CASE("bus port: for a block of another page its bank is precharged, then activated once, then written") {
    ClockedTestbench bench;
    Scenario scenario = SharedPortBench::shared(1, 0);
    scenario.memory.page_miss_cycles = 6;
    scenario.memory.precharge_cycles = 3;
    SharedPortBench dut(bench, scenario);
    dut.fill(10, 0, 128, 2);  // the bank is closed: three clocks
    dut.fill(20, 1, 160, 2);
    bench.run_through(22);
    CHECK(shows(dut.dut, "write_precharging[1]=1"));
    bench.run_through(23);
    CHECK(shows(dut.dut, "write_precharging[1]=0"));
    bench.run_through(30);
    CHECK(dut.clocks_of(Command::kActivate, 30) == Clocks{10, 23});
    CHECK(dut.clocks_of(Command::kPrecharge, 30) == Clocks{20});
    CHECK(dut.clocks_of(Command::kWrite, 30) == Clocks{13, 26});
    CHECK(dut.commands.at(23).row == 5);
}

TEST_CASE("bus port: a burst waits while a block is written, and opens its page again if it was closed") {
    ClockedTestbench bench;
    SharedPortBench dut(bench);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);              // page 2: opened from clock 10 on, read from 13
    dut.fill(PortBench::kSend + 4, 0, 128, 4);  // page 4, in the one bank there is
    bench.run_through(PortBench::kSend + 14);
    CHECK(dut.clocks_of(Command::kRead, 24) == Clocks{13, 22, 23, 24});
    CHECK(dut.clocks_of(Command::kWrite, 24) == Clocks{17, 18});
    CHECK(dut.clocks_of(Command::kActivate, 24) == Clocks{10, 14, 19});
    CHECK(dut.columns_at(22) == Columns{2, 3});
    CHECK(dut.counters.write_cycles == 3 + 2);
    CHECK(dut.counters.page_misses == 2);
    CHECK(dut.counters.page_miss_cycles == 3 + 3);
}

TEST_CASE("bus port: a block of another bank leaves the burst's page open") {
    ClockedTestbench bench;
    SharedPortBench dut(bench, 2);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);              // page 2, in bank 0
    dut.fill(PortBench::kSend + 4, 0, 160, 4);  // page 5, in bank 1
    bench.run_through(PortBench::kSend + 14);
    CHECK(dut.clocks_of(Command::kRead, 24) == Clocks{13, 19, 20, 21, 22, 23, 24});
    CHECK(dut.commands.at(14).bank == 1);
    CHECK(dut.counters.write_cycles == 3 + 2);
    CHECK(dut.counters.page_misses == 1);
}

TEST_CASE("bus port: a block waits for a page that is being opened") {
    ClockedTestbench bench;
    SharedPortBench dut(bench, 2);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);
    dut.fill(PortBench::kSend + 1, 0, 160, 4);
    bench.run_through(PortBench::kSend + 10);
    CHECK(dut.clocks_of(Command::kActivate, 20) == Clocks{10, 13});
    CHECK(dut.clocks_of(Command::kWrite, 20) == Clocks{16, 17});
    CHECK(dut.clocks_of(Command::kRead, 20) == Clocks{18, 19, 20});
}

TEST_CASE("bus port: a block that would not be done before a refresh is written after it") {
    ClockedTestbench bench;
    SharedPortBench dut(bench, 1, 40);
    dut.fill(34, 0, 128, 8);  // 3 + 4 clocks: 34 to 40
    bench.run_through(52);
    CHECK(dut.clocks_of(Command::kRefresh, 52) == Clocks{40});
    CHECK(dut.clocks_of(Command::kActivate, 52) == Clocks{44});
    CHECK(dut.clocks_of(Command::kWrite, 52) == Clocks{47, 48, 49, 50});
}

TEST_CASE("bus port: a block that is just done before a refresh is written before it") {
    ClockedTestbench bench;
    SharedPortBench dut(bench, 1, 40);
    dut.fill(33, 0, 128, 8);
    bench.run_through(42);
    CHECK(dut.clocks_of(Command::kWrite, 42) == Clocks{36, 37, 38, 39});
    CHECK(dut.clocks_of(Command::kRefresh, 42) == Clocks{40});
}

TEST_CASE("bus port: the front image's words are read, and its pages stay open from frame to frame") {
    ClockedTestbench bench;
    SharedPortBench dut(bench);
    dut.core.drive(dut.front, 1, true);
    dut.begin({table_row(2, {0, 4}, {2, 1}, {0, 0})});
    dut.give(PortBench::kSend - 1, 1);
    dut.give(PortBench::kSend - 1, 0);
    bench.run_through(PortBench::kSend + 8);
    CHECK(dut.clocks_of(Command::kActivate, 18) == Clocks{9});
    CHECK(dut.commands.at(9).row == 4 + 2);
    CHECK(dut.clocks_of(Command::kRead, 18) == Clocks{12});
    CHECK(dut.commands.at(12).row == 4 + 2);
    CHECK(dut.clocks_of(Command::kPrechargeAll, 18).empty());
}

TEST_CASE("bus port: if a page miss takes no clocks, a grant's words are read in its own clock") {
    ClockedTestbench bench;
    PortBench dut(bench, Arbitration::kRoundRobin, 0);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);
    bench.run_through(PortBench::kSend + 3);
    CHECK(dut.commands.at(PortBench::kSend).kind == Command::kRead);
    CHECK(dut.columns_at(PortBench::kSend) == Columns{0, 1});
}

TEST_CASE("bus port: the bus carries the words that stand at a read's edge") {
    ClockedTestbench bench;
    PortBench dut(bench);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);
    MemoryData words;
    words.count = 2;
    words.words[0] = 77;
    words.words[1] = 78;
    dut.core.drive(dut.data, PortBench::kSend + 4, words);
    bench.run_through(PortBench::kSend + 6);
    const BusBeat& beat = dut.beats.at(PortBench::kSend + 4);
    CHECK(beat.kind == BusBeat::Kind::kPixels);
    CHECK(beat.destination == 2);
    CHECK(beat.first == 2);
    CHECK(beat.remaining == 4);
    CHECK(beat.words[0] == 77);
    CHECK(beat.words[1] == 78);
}

TEST_CASE("bus port: the arbiter's answer is taken in each clock without a burst, and in no other") {
    ClockedTestbench bench;
    PortBench dut(bench);
    dut.begin(two_rows());
    constexpr int kGrant = PortBench::kSend + 3;
    dut.give(kGrant, 1);
    dut.give(kGrant + 1, -1);
    bench.run_through(kGrant + 12);
    CHECK(dut.takes.rises().front() == PortBench::kSend);
    for (int clock = PortBench::kSend; clock <= kGrant; ++clock) CHECK(dut.takes.at(clock));
    // Three clocks for the page and four beats, the first of which was the grant's.
    for (int clock = kGrant + 1; clock < kGrant + 7; ++clock) CHECK_FALSE(dut.takes.at(clock));
    for (int clock = kGrant + 7; clock < kGrant + 12; ++clock) CHECK(dut.takes.at(clock));
    CHECK(dut.counters.poll_cycles >= 3);
}

TEST_CASE("bus port: a row asks as long as it has pixels, and is ready with its composer's BUSREADY") {
    ClockedTestbench bench;
    PortBench dut(bench, Arbitration::kRoundRobin, 0);
    dut.begin(two_rows());
    constexpr int kFirst = PortBench::kSend;
    dut.give(kFirst, 0);  // 15 pixels: bursts of 4 beats
    dut.give(kFirst + 8, -1);
    dut.core.drive(dut.busready[1], kFirst + 2, false);
    dut.core.drive(dut.busready[1], kFirst + 4, true);
    bench.run_through(kFirst + 12);
    CHECK(dut.pendings[0]->at(kFirst));
    CHECK(dut.pendings[0]->at(kFirst + 7));
    CHECK_FALSE(dut.pendings[0]->at(kFirst + 8));
    CHECK(dut.pendings[1]->at(kFirst + 11));
    CHECK(dut.readies[1]->at(kFirst + 1));
    CHECK_FALSE(dut.readies[1]->at(kFirst + 2));
    CHECK_FALSE(dut.readies[1]->at(kFirst + 3));
    CHECK(dut.readies[1]->at(kFirst + 4));
}

TEST_CASE("bus port: after a burst of one beat its row is not ready for a clock") {
    ClockedTestbench bench;
    PortBench dut(bench, Arbitration::kRoundRobin, 0);
    ViewportTable rows = two_rows();
    rows[0] = table_row(1, {0, 0}, {1, 2}, {0, 0});  // words 0 and 16
    dut.begin(rows);
    constexpr int kFirst = PortBench::kSend;
    dut.give(kFirst, 1);
    bench.run_through(kFirst + 20);
    // Two rows of 16 are four bursts of four beats: always more than one.
    for (int clock = kFirst; clock < kFirst + 16; ++clock) CHECK(dut.readies[1]->at(clock));
    CHECK(dut.readies[0]->at(kFirst));
    CHECK(dut.pendings[0]->at(kFirst + 20));
}

TEST_CASE("bus port: the deadline lines show the first raster position that needs each row's next pixel") {
    ClockedTestbench bench;
    PortBench dut(bench, Arbitration::kEdf, 0);
    ViewportTable rows = two_rows();
    rows[0] = table_row(1, {0, 0}, {5, 3}, {10, 7}, 2);
    dut.begin(rows);
    constexpr int kFirst = PortBench::kSend;
    dut.give(kFirst, 0);
    bench.run_through(kFirst + 4);
    const auto raster_width = static_cast<std::uint64_t>(dut.scenario.displays.raster_width_pixels());
    CHECK(dut.deadlines[0]->at(kFirst) == 7 * raster_width + 10);
    CHECK(dut.deadlines[1]->at(kFirst) == 0);
    CHECK(dut.deadlines[0]->at(kFirst + 1) == 7 * raster_width + 10 + 4);  // two source pixels further
    CHECK(dut.deadlines[0]->at(kFirst + 3) ==
          9 * raster_width + 10 + 2);  // pixel 6, in the second source row
}

// ---- read latency and registers on the bus ----

/// A memory that answers `latency` clocks later, played by the test. Word w of the image is 1000 + w.
struct DelayedPortBench : PortBench {
    DelayedPortBench(ClockedTestbench& bench, int latency, int stages, int page_miss = 0)
        : PortBench(bench, with_delays(latency, stages, page_miss)) {
        core.each_clock([this, latency](int next) {
            // The edge before has sampled the newest command; the words belong to the command `latency` edges before
            // theirs.
            MemoryData put_out;
            if (const int read = next - latency; latency > 0 && read >= 0 && read < commands.end_clock()) {
                const MemoryCommand& sent = commands.at(read);
                for (int word = 0; sent.kind == Command::kRead && word < sent.count; ++word) {
                    const auto lane = static_cast<std::size_t>(word);
                    put_out.words[lane] = 1000 + sent.row * 32 + sent.columns[lane];
                    put_out.count = sent.count;
                }
            }
            data.write(put_out);
        });
    }
    static Scenario with_delays(int latency, int stages, int page_miss) {
        Scenario scenario = make(Arbitration::kRoundRobin, page_miss, 128, 1, 0, 0, 0);
        scenario.memory.read_latency_cycles = latency;
        scenario.bus.register_stages = stages;
        scenario.composer.ready_space_pixels = in_flight_pixels(scenario.bus, scenario.memory);
        return scenario;
    }
    /// The edges after which beats of pixels stand on the bus.
    Clocks pixel_clocks() const {
        return beats.clocks_where([](const BusBeat& beat) { return beat.kind == BusBeat::Kind::kPixels; });
    }
    Clocks read_clocks() const {
        return commands.clocks_where(
            [](const MemoryCommand& command) { return command.kind == Command::kRead; });
    }
};

TEST_CASE(
    "bus port: with read latency reads follow each other, and every beat goes out that many clocks later") {
    constexpr int kLatency = 3;
    ClockedTestbench bench;
    DelayedPortBench dut(bench, kLatency, 0);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);
    dut.give(PortBench::kSend + 4, -1);
    bench.run_through(PortBench::kSend + 4 + kLatency);
    const int send = PortBench::kSend;
    CHECK(dut.read_clocks() == Clocks{send, send + 1, send + 2, send + 3});
    CHECK(dut.pixel_clocks() ==
          Clocks{send + kLatency, send + kLatency + 1, send + kLatency + 2, send + kLatency + 3});
    for (int beat = 0; beat < 4; ++beat) {
        const BusBeat& sent = dut.beats.at(send + kLatency + beat);
        CHECK(sent.words[0] == 1000U + 64 + 2 * static_cast<unsigned>(beat));
        CHECK(sent.words[1] == 1000U + 65 + 2 * static_cast<unsigned>(beat));
        CHECK(sent.remaining == 6U - 2 * static_cast<unsigned>(beat));
    }
    // The table still comes before the pixels.
    CHECK(dut.beats.at(PortBench::kAnswer + 1 + kLatency).kind == BusBeat::Kind::kFrameStart);
    CHECK(dut.beats.at(PortBench::kAnswer + 2 + kLatency).kind == BusBeat::Kind::kTableRow);
    CHECK(dut.beats.at(PortBench::kAnswer + 3 + kLatency).kind == BusBeat::Kind::kTableRow);
    CHECK(dut.counters.table_cycles == 3);
    CHECK(dut.counters.busy_cycles == 4);
}

void check_passed_over(int latency, int stages) {
    ClockedTestbench bench;
    DelayedPortBench dut(bench, latency, stages);
    const int loop = latency + 2 * stages;
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);
    dut.give(PortBench::kSend + 4, -1);
    bench.run_through(PortBench::kSend + 8 + loop);
    const int last_beat = PortBench::kSend + 3;
    for (int clock = PortBench::kSend; clock < last_beat + 5 + loop; ++clock) {
        INFO("clock " << clock << ", last beat decided on at " << last_beat << ", loop " << loop);
        const bool counts = clock <= last_beat || clock >= last_beat + 2 + loop;
        CHECK(dut.readies[1]->at(clock) == (loop == 0 || counts));
        CHECK(dut.readies[0]->at(clock));
    }
    const std::string bits = std::to_string(rtl::bits_for(1 + loop));
    for (const char* counter : {"uncounted_cycles", "uncounted_1", "uncounted_2"}) {
        CHECK(shows(dut.dut, std::string(counter) + "[" + bits + "]=0"));
    }
}

TEST_CASE("bus port: without a loop no composer is passed over after a burst of several beats") {
    check_passed_over(0, 0);
}

TEST_CASE("bus port: with read latency a composer is passed over until BUSREADY counts a burst's last beat") {
    check_passed_over(2, 0);
}

TEST_CASE(
    "bus port: with bus registers a composer is passed over until BUSREADY counts a burst's last beat") {
    check_passed_over(0, 3);
}

TEST_CASE("bus port: with the longest loop a composer is passed over until BUSREADY counts the last beat") {
    check_passed_over(8, 4);
}

TEST_CASE("bus port: a low BUSREADY stops the burst whose beat it answers, and no other") {
    constexpr int kLatency = 2;
    constexpr int kLoop = kLatency + 2;
    ClockedTestbench bench;
    DelayedPortBench dut(bench, kLatency, 1);
    dut.begin(two_rows());
    dut.give(PortBench::kSend, 1);
    const int send = PortBench::kSend;
    dut.scenario.bus.burst_pixels = 16;  // read as a burst starts
    dut.give(send + 1, -1);
    // BUSREADY is low before any beat of the burst can have been answered, and again once its first beat has.
    dut.core.drive(dut.busready[1], send + 1, false);
    dut.core.drive(dut.busready[1], send + 1 + kLoop, true);
    dut.core.drive(dut.busready[1], send + 2 + kLoop, false);
    bench.run_through(send + 12 + kLoop);
    CHECK(dut.read_clocks() == clock_range(send, send + 2 + kLoop));
    CHECK(dut.counters.bursts == 1);
    // The beats that had been decided on go out.
    CHECK(dut.pixel_clocks() == clock_range(send + kLatency, send + kLatency + 2 + kLoop));
}

TEST_CASE("bus port: a burst is not judged by what the burst before it announced") {
    constexpr int kLoop = 2 + 2;
    ClockedTestbench bench;
    DelayedPortBench dut(bench, 2, 1);
    dut.begin(two_rows());
    const int send = PortBench::kSend;
    const int next = send + 4;
    dut.give(send, 1);
    dut.give(next, 0);
    dut.give(next + 1, -1);
    // BUSREADY is low until the burst's own first beat has been answered.
    dut.core.drive(dut.busready[0], next + 1, false);
    dut.core.drive(dut.busready[0], next + 1 + kLoop, true);
    bench.run_through(next);
    for (const char* stage : {"", "_1", "_2", "_3", "_4"}) {
        CHECK(shows(dut.dut, std::string("announced_before") + stage + "[4]=0"));
    }
    bench.run_through(next + 4 + kLoop);
    CHECK(dut.read_clocks() == clock_range(send, next + 4));
}

TEST_CASE("bus port: a frame starts no earlier than TABLEREADY counts the one before") {
    constexpr int kLatency = 8;
    constexpr int kStages = 4;
    ClockedTestbench bench;
    DelayedPortBench dut(bench, kLatency, kStages);
    dut.scenario.frames = 2;
    dut.begin({});  // a frame without rows is over at once
    dut.core.drive(dut.answer, PortBench::kAnswer + 4, false);
    bench.run_through(60);
    const Clocks starts =
        dut.beats.clocks_where([](const BusBeat& beat) { return beat.kind == BusBeat::Kind::kFrameStart; });
    CHECK(starts == Clocks{PortBench::kAnswer + 1 + kLatency,
                           PortBench::kAnswer + 1 + kLatency + 2 + kLatency + 2 * kStages});
}

}  // namespace
}  // namespace metabuffer::test::bus_port_test
