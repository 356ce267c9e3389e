#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "rtl/bus_arbiter.h"
#include "rtl/bus_port.h"
#include "rtl/memory_controller.h"
#include "support/images.h"
#include "support/rows.h"
#include "support/scenarios.h"

// The lines of docs/design.md's timing table that say what an input framebuffer does at which clock, each at the pins of
// the block inside that decides it.
namespace metabuffer::test::input_framebuffer_timing_test {
namespace {

using rtl::BusArbiter;
using rtl::BusBeat;
using rtl::BusPort;
using rtl::FrontTable;
using rtl::MemoryCommand;
using rtl::MemoryController;

constexpr int kWidth = 16;  ///< of the image, which has 128 words
constexpr int kDisplays = 2;

Scenario port_scenario() {
    Scenario scenario = small_scenario(64, 64, kDisplays);
    scenario.bus.arbitration = Arbitration::kRoundRobin;
    scenario.bus.width_bits = 128;
    scenario.bus.burst_pixels = 8;
    scenario.memory.words_per_cycle = 2;
    scenario.memory.page_words = 32;
    scenario.memory.page_miss_cycles = 0;
    scenario.renderers.push_back(renderer_of({PixelImage(kWidth, 8)}));
    return scenario;
}

/// Row 1 is in the image's first page, row 2 in its third.
ViewportTable two_rows() {
    return {table_row(1, {0, 0}, {kWidth, 1}, {0, 0}), table_row(2, {0, 4}, {kWidth, 1}, {0, 0})};
}

struct PortParts {
    Scenario scenario;
    BusCounters counters;
};

/// A bus port with its memory controller.
struct BusSide final : rtl::Block {
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_in<bool> reset_i{"reset_i"};
    BusPort port;
    MemoryController controller;
    rtl::Wire<rtl::MemoryRequest> request{"request"};
    rtl::Wire<rtl::MemoryAnswer> answer{"answer"};

    BusSide(const sc_core::sc_module_name& name, const Scenario& scenario, BusCounters& counters)
        : Block(name),
          port(
              "port", scenario, scenario.renderers[0], [](bool) {}, counters),
          controller("controller", scenario.memory, scenario.renderers[0].image_words()) {
        port.clk_i(clk_i);
        port.reset_i(reset_i);
        controller.clk_i(clk_i);
        controller.reset_i(reset_i);
        port.memory_o(request);
        controller.request_i(request);
        controller.answer_o(answer);
        port.memory_i(answer);
    }
    void trace(sc_core::sc_trace_file* file) const override {
        port.trace(file);
        controller.trace(file);
    }
};

/// A bus side whose inputs are written as strings, a letter a clock from the first one after reset on; the last letter
/// stands. What its outputs show at each edge comes out as strings. Words are of no interest here.
class PortWaves final : private PortParts, public Lockstep<BusSide> {
  public:
    // `_` and `-`: low and high. Low at clock 0 and high from then on, the answer is read at edge 2.
    std::string answer = "_-", tableready = "-", busready_1 = "-", busready_2 = "-", lost = "_", full = "_";
    std::string grant = "_";  ///< the row that has the grant, 1 or 2
    FrontTable table{two_rows(), {}};
    rtl::WriteBlock block;
    // What came out.
    std::string request, start, take, ready_1;
    std::string command;  ///< Activate, read, Precharge, Close all, Refresh, write
    std::string bus;      ///< Frame start, Table row, or the display that pixels go to

    PortWaves(LockstepBench& bench, const Scenario& made, const std::string& name = "port")
        : PortParts{made, {}}, Lockstep(bench, name, [this](const char* dut, rtl::ClockGating) {
              return std::make_unique<BusSide>(dut, scenario, counters);
          }) {
        if (scenario.memory.shared()) {
            in_part<bool>([](BusSide & dut) -> auto& { return dut.port.front_i[0]; });
            out_part<bool>([](BusSide & dut) -> auto& { return dut.controller.drain_o[0]; });
            for (std::size_t half = 0; half < full_.size(); ++half) {
                full_[half] = &in_part<bool>([half](BusSide & dut) -> auto& {
                    return dut.controller.write_full_i[half];
                });
                block_[half] = &in_part<rtl::WriteBlock>([half](BusSide & dut) -> auto& {
                    return dut.controller.write_block_i[half];
                });
            }
        }
        for (std::size_t line = 0; line < kDisplays; ++line) {
            busready_[line] = &port_in(&BusPort::busready_i, line);
            tableready_[line] = &port_in(&BusPort::tableready_i, line);
            grant_[line] = &port_in(&BusPort::grant_i, line);
            ready_[line] = &port_out(&BusPort::ready_o, line);
            port_out(&BusPort::pending_o, line);
        }
    }

    void stimulate() override {
        const auto at = [clock = bench_.clock()](const std::string& wave) {
            return wave[static_cast<std::size_t>(std::clamp(clock, 0, static_cast<int>(wave.size()) - 1))];
        };
        answer_ = at(answer) == '-';
        table_ = table;
        lost_ = at(lost) == '-';
        for (Input<bool>* const wire : tableready_) *wire = at(tableready) == '-';
        *busready_[0] = at(busready_1) == '-';
        *busready_[1] = at(busready_2) == '-';
        *grant_[0] = at(grant) == '1';
        *grant_[1] = at(grant) == '2';
        grant_valid_ = at(grant) != '_';
        if (full_[0] == nullptr) return;
        *full_[0] = at(full) == '-';
        *block_[0] = block;
    }
    void expect() override {}
    void edge() override {
        const auto letter = [](bool level) { return level ? '-' : '_'; };
        request += letter(request_.seen());
        start += letter(start_.seen());
        take += letter(take_.seen());
        ready_1 += letter(ready_[0]->seen());
        command += ".ArPCRw"[static_cast<std::size_t>(command_.seen().kind)];
        const BusBeat& beat = bus_.seen();
        bus += beat.kind == BusBeat::Kind::kPixels ? static_cast<char>('0' + beat.destination)
                                                   : ".FT"[static_cast<std::size_t>(beat.kind)];
    }

  private:
    template <typename Value>
    Input<Value>& port_in(rtl::In<Value> BusPort::*pin) {
        return in_part<Value>([pin](BusSide & dut) -> auto& { return dut.port.*pin; });
    }
    template <typename Value>
    Output<Value>& port_out(rtl::Out<Value> BusPort::*pin) {
        return out_part<Value>([pin](BusSide & dut) -> auto& { return dut.port.*pin; });
    }
    Input<bool>& port_in(rtl::PinVector<rtl::In<bool>> BusPort::*pins, std::size_t index) {
        return in_part<bool>([ pins, index ](BusSide & dut) -> auto& { return (dut.port.*pins)[index]; });
    }
    Output<bool>& port_out(rtl::PinVector<rtl::Out<bool>> BusPort::*pins, std::size_t index) {
        return out_part<bool>([ pins, index ](BusSide & dut) -> auto& { return (dut.port.*pins)[index]; });
    }

    Output<bool>& request_ = port_out(&BusPort::request_o);
    Input<bool>& answer_ = port_in(&BusPort::answer_i);
    Input<bool>& fresh_ = port_in(&BusPort::fresh_i);
    Input<FrontTable>& table_ = port_in(&BusPort::table_i);
    std::array<Input<bool>*, 2> full_{};
    std::array<Input<rtl::WriteBlock>*, 2> block_{};
    Output<BusBeat>& bus_ = port_out(&BusPort::bus_o);
    std::array<Input<bool>*, kDisplays> busready_{}, tableready_{}, grant_{};
    std::array<Output<bool>*, kDisplays> ready_{};
    Output<bool>& start_ = port_out(&BusPort::start_o);
    Output<bool>& take_ = port_out(&BusPort::take_o);
    Input<bool>& grant_valid_ = port_in(&BusPort::grant_valid_i);
    Input<bool>& search_ = port_in(&BusPort::search_i);
    Input<bool>& lost_ = port_in(&BusPort::lost_i);
    Input<std::uint16_t>& recovered_ = port_in(&BusPort::recovered_i);
    Output<MemoryCommand>& command_ =
        out_part<MemoryCommand>([](BusSide & dut) -> auto& { return dut.controller.command_o; });
    Input<rtl::MemoryData>& data_ = port_in(&BusPort::data_i);
};

// ---- a frame's beginning ----

TEST_CASE("input framebuffer: timing: an answer read to the frame-start beat all TABLEREADY high") {
    LockstepBench bench;
    PortWaves at_once(bench, port_scenario(), "at_once");
    PortWaves late(bench, port_scenario(), "late");
    late.tableready = "_____-";
    bench.run(9);
    CHECK(at_once.start == "___-_____");  // edge 2 has read the answer
    CHECK(at_once.bus == "....FTT..");    // edge 3 has driven the beat
    CHECK(late.bus == "......FTT");
}

TEST_CASE("input framebuffer: timing: frame-start beat a table row") {
    LockstepBench bench;
    std::array<std::unique_ptr<PortWaves>, 4> ports;
    const std::array<int, 4> widths{32, 64, 128, 256};
    for (std::size_t i = 0; i < ports.size(); ++i) {
        Scenario scenario = port_scenario();
        scenario.bus.width_bits = widths[i];
        ports[i] = std::make_unique<PortWaves>(bench, scenario, "port_" + std::to_string(widths[i]));
    }
    bench.run(14);
    CHECK(ports[0]->bus == "....F...T...T.");
    CHECK(ports[1]->bus == "....F.T.T.....");
    CHECK(ports[2]->bus == "....FTT.......");
    CHECK(ports[3]->bus == "....FTT.......");
}

TEST_CASE("input framebuffer: timing: last table beat to first arbitration") {
    LockstepBench bench;
    PortWaves port(bench, port_scenario());
    bench.run(9);
    CHECK(port.bus == "....FTT..");  // edge 5 has driven the last one
    CHECK(port.take == "______---");
}

TEST_CASE(
    "input framebuffer: timing: frame-start beat to the first sample of TABLEREADY for the next with a "
    "loop") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.frames = 2;
    scenario.bus.register_stages = 4;
    PortWaves port(bench, scenario);
    PortWaves late(bench, scenario, "late");
    for (PortWaves* const one : {&port, &late}) {
        one->table = {};         // the frame is over at once
        one->answer = "_----_";  // and the next one's pair is there at edge 6
    }
    port.tableready = "-----________-";
    late.tableready = "-------------_-";
    bench.run(17);
    CHECK(port.bus == "....F.........F..");  // edge 13 samples, 10 after edge 3
    CHECK(late.bus == "....F..........F.");
}

// ---- the arbiter ----

struct ArbiterWaves {
    int grant_cycles = 0;
    SlotTableMaker slot_table = SlotTableMaker::kHost;
    std::string start, ready_0, ready_1, grant_0, grant_1, search;
};

/// Two rows that always have pixels left, slot 0 being row 0's, and a bus that takes every answer.
void check_arbiter(const std::vector<ArbiterWaves>& cases) {
    LockstepBench bench;
    std::vector<std::unique_ptr<WaveformCase<BusArbiter>>> duts;
    for (const ArbiterWaves& waves : cases) {
        BusConfig bus;
        bus.arbitration = Arbitration::kRoundRobin;
        bus.grant_cycles = waves.grant_cycles;
        bus.slot_table = waves.slot_table;
        duts.push_back(std::make_unique<WaveformCase<BusArbiter>>(
            bench, "arbiter_" + std::to_string(waves.grant_cycles),
            [&bus](const char* name, rtl::ClockGating) {
                return std::make_unique<BusArbiter>(name, bus, kDisplays);
            }));
        WaveformCase<BusArbiter>& dut = *duts.back();
        const std::string high(waves.start.size(), '-');
        const std::string any(waves.start.size(), '?');
        dut.drive(waves.start, &BusArbiter::start_i);
        dut.drive(std::string(high.size(), 'T'), &BusArbiter::table_i,
                  {{'T', FrontTable{two_rows(), {0, 1, 0}}}});
        dut.drive(high, &BusArbiter::take_i);
        dut.drive(high, &BusArbiter::pending_i, 0);
        dut.drive(high, &BusArbiter::pending_i, 1);
        dut.drive(waves.ready_0, &BusArbiter::ready_i, 0);
        dut.drive(waves.ready_1, &BusArbiter::ready_i, 1);
        dut.check(waves.grant_0, &BusArbiter::grant_o, 0);
        dut.check(waves.grant_1, &BusArbiter::grant_o, 1);
        dut.check(waves.search, &BusArbiter::search_o);
        dut.check(any, &BusArbiter::grant_valid_o);
        dut.check(any, &BusArbiter::lost_o);
        dut.check(any, &BusArbiter::recovered_o);
        dut.check(any, &BusArbiter::slot_o);
    }
    duts.front()->run();
}

// Row 0's slot is recovered for row 1, after polls.
TEST_CASE("input framebuffer: timing: arbitration recovered slots a poll") {
    const std::string start = "_-________";
    const std::string ready = "____-_____";
    const std::string never = "__________";
    check_arbiter({{0, SlotTableMaker::kHost, start, never, ready, never, ready, never},
                   {3, SlotTableMaker::kHost, start, never, ready, never, "_______-__", "____---___"}});
}

TEST_CASE("input framebuffer: timing: an answer read to the first arbitration if the slot table is built") {
    const std::string start = "_-______";  // edge 0 has read the answer, edges 2 to 4 build three slots
    check_arbiter(
        {{0, SlotTableMaker::kBuilt, start, "------__", "--------", "_____-__", "______--", "__---___"}});
}

// ---- bursts and pages ----

TEST_CASE(
    "input framebuffer: timing: answer of the arbiter to first beat on an open page beat to beat on an open "
    "page") {
    LockstepBench bench;
    PortWaves port(bench, port_scenario());
    port.grant = "________1111";
    bench.run(16);
    CHECK(port.command == ".C......rrrrrrrr");
    CHECK(port.bus == "....FTT..1111111");
}

TEST_CASE("input framebuffer: timing: a beat below 64 bits on the bus in its last clock") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.bus.width_bits = 16;
    PortWaves port(bench, scenario);
    port.grant = "____________________1";
    bench.run(30);
    CHECK(port.command == ".C..................r...r...r.");
    CHECK(port.bus == "....F.......T.......T...1...1.");
}

TEST_CASE("input framebuffer: timing: first word of another page of a bank") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.memory.page_miss_cycles = 4;
    scenario.memory.precharge_cycles = 2;
    PortWaves port(bench, scenario);
    port.grant = "______1_____2";
    bench.run(18);
    CHECK(port.command == ".C....A.rrrrP.A.rr");
    CHECK(port.bus == "....FTT..1111....2");
}

TEST_CASE("input framebuffer: timing: first word of a page of a bank with none open") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.memory.page_miss_cycles = 5;
    scenario.memory.precharge_cycles = 2;
    PortWaves port(bench, scenario);
    port.grant = "_______1";
    bench.run(12);
    CHECK(port.command == ".C.....A..rr");
    CHECK(port.bus == "....FTT....1");
}

TEST_CASE("input framebuffer: timing: first word of a page that another bank has open") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.memory.page_miss_cycles = 3;
    scenario.memory.banks = 2;
    PortWaves port(bench, scenario);
    // Row 2 opens page 1. Row 1's words 27 to 31 are in page 0, its words 43 to 47 in page 1.
    port.table.rows = {table_row(1, {11, 1}, {5, 2}, {0, 0}), table_row(2, {0, 2}, {2, 1}, {0, 0})};
    port.grant = "______2___1";
    bench.run(19);
    CHECK(port.command == ".C....A..rA..rrrrrr");
    CHECK(port.bus == "....FTT...2...11111");  // beats of 2, 2 and 1 words, then of 2 and 1
}

Scenario refreshed_scenario() {
    Scenario scenario = port_scenario();
    scenario.memory.page_miss_cycles = 3;
    scenario.memory.refresh_interval_cycles = 10;
    scenario.memory.refresh_cycles = 4;
    return scenario;
}

TEST_CASE("input framebuffer: timing: first word wanted in a refresh") {
    LockstepBench bench;
    PortWaves port(bench, refreshed_scenario());
    port.grant = "____________1";
    bench.run(19);
    CHECK(port.command == ".C........R...A..rr");
    CHECK(port.bus == "....FTT...........1");
}

TEST_CASE("input framebuffer: timing: a page that is being opened when a refresh begins") {
    LockstepBench bench;
    PortWaves port(bench, refreshed_scenario());
    port.grant = "________1";
    bench.run(19);
    CHECK(port.command == ".C......A.R...A..rr");
    CHECK(port.bus == "....FTT...........1");
}

TEST_CASE("input framebuffer: timing: shared ports a block is written") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.memory.page_miss_cycles = 3;
    scenario.memory.ports = MemoryPorts::kShared;
    PortWaves port(bench, scenario);
    port.answer = "_";
    port.full = "____-";
    port.block = {32 * 5 + 16, 5, rtl::MemoryWrite::kColourBytes};
    bench.run(14);
    CHECK(port.command == "......A..www..");
}

TEST_CASE("input framebuffer: timing: a lost slot") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.bus.arbitration = Arbitration::kSlotAllocation;
    PortWaves port(bench, scenario);
    port.lost = "_______-";
    bench.run(17);
    CHECK(port.take == "______--___-___-_");
}

TEST_CASE("input framebuffer: timing: a beat decided on to that beat on the bus") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.memory.read_latency_cycles = 3;
    PortWaves port(bench, scenario);
    port.grant = "______1_";
    bench.run(15);
    CHECK(port.command == ".C....rrrr.....");
    CHECK(port.bus == ".......FTT1111.");
}

// ---- BUSREADY ----

TEST_CASE(
    "input framebuffer: timing: BUSREADY low in a burst read one clock after it is written next grant at "
    "that edge") {
    LockstepBench bench;
    PortWaves stopped(bench, port_scenario(), "stopped");
    PortWaves early(bench, port_scenario(), "early");
    // The first beat stands on the bus when edge 7 samples it, so edge 8 reads the first answer to that beat.
    stopped.busready_1 = "--------_-";
    early.busready_1 = "-------_-";
    for (PortWaves* const port : {&stopped, &early}) port->grant = "______1_2222222_";
    bench.run(15);
    CHECK(stopped.take == "______-_-___-__");
    CHECK(stopped.bus == "....FTT11222222");
    CHECK(early.take == "______-___-___-");
    CHECK(early.bus == "....FTT11112222");
}

TEST_CASE("input framebuffer: timing: composer passed over after a beat that its BUSREADY cannot count") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.bus.burst_pixels = 2;  // one beat
    PortWaves port(bench, scenario);
    scenario.memory.read_latency_cycles = 2;
    scenario.bus.register_stages = 1;
    PortWaves loop_of_4(bench, scenario, "loop_of_4");
    for (PortWaves* const one : {&port, &loop_of_4}) one->grant = "______1_";
    bench.run(14);
    CHECK(port.ready_1 == "______-_------");
    CHECK(loop_of_4.ready_1 == "______-_____--");
}

TEST_CASE(
    "input framebuffer: timing: burst stopped by BUSREADY its composer passed over after the clock that "
    "reads it") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.bus.burst_pixels = kWidth;
    PortWaves port(bench, scenario);
    port.busready_1 = "--------_-";
    scenario.memory.read_latency_cycles = 2;
    scenario.bus.register_stages = 1;
    PortWaves loop_of_4(bench, scenario, "loop_of_4");
    loop_of_4.busready_1 = "------------_-";
    for (PortWaves* const one : {&port, &loop_of_4}) one->grant = "______1_";
    bench.run(19);
    CHECK(port.ready_1 == "______--_----------");
    CHECK(loop_of_4.ready_1 == "______------_____--");
}

TEST_CASE("input framebuffer: timing: last beat of a frame to the request for the next pair") {
    LockstepBench bench;
    Scenario scenario = port_scenario();
    scenario.frames = 2;
    PortWaves port(bench, scenario);
    port.table.rows = {table_row(1, {0, 0}, {2, 1}, {0, 0})};
    port.grant = "_____1_";
    bench.run(9);
    CHECK(port.bus == "....FT1..");      // edge 5 has driven the pixels
    CHECK(port.request == "_------__");  // edge 6 asks
}

}  // namespace
}  // namespace metabuffer::test::input_framebuffer_timing_test
