#include "rtl/bus_registers.h"

#include <catch2/catch.hpp>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/wires.h"

namespace metabuffer::test::bus_registers_test {
namespace {

using rtl::BusBeat;
using rtl::BusRegisters;

constexpr std::size_t kComposers = 2;

struct RegistersBench {
    ClockDomain& core;
    sc_core::sc_signal<BusBeat> bus_in, bus_out;
    rtl::SignalBank<bool> busready_in, busready_out, tableready_in, tableready_out;
    BusRegisters dut;
    const Recording<BusBeat>& beats;
    std::vector<const Recording<bool>*> busready, tableready;

    RegistersBench(ClockedTestbench& bench, int stages)
        : core(bench.core),
          busready_in(kComposers, rtl::Wires::name_of("busready_in")),
          busready_out(kComposers, rtl::Wires::name_of("busready_out")),
          tableready_in(kComposers, rtl::Wires::name_of("tableready_in")),
          tableready_out(kComposers, rtl::Wires::name_of("tableready_out")),
          dut("bus_registers", stages, kComposers),
          beats(core.record(bus_out)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.bus_i(bus_in);
        dut.bus_o(bus_out);
        for (std::size_t i = 0; i < kComposers; ++i) {
            dut.busready_i[i](busready_in[i]);
            dut.busready_o[i](busready_out[i]);
            dut.tableready_i[i](tableready_in[i]);
            dut.tableready_o[i](tableready_out[i]);
            busready.push_back(&core.record(busready_out[i]));
            tableready.push_back(&core.record(tableready_out[i]));
        }
        bench.trace(dut);
    }
    /// Edge `clock` samples a beat.
    void send(int clock, std::uint32_t first) {
        BusBeat beat;
        beat.kind = BusBeat::Kind::kPixels;
        beat.first = first;
        beat.words[0] = 0xABCD'0000'0000'0000U + first;
        core.drive(bus_in, clock, beat);
        core.drive(bus_in, clock + 1, BusBeat{});
    }
    std::vector<int> beat_clocks() const {
        return beats.clocks_where([](const BusBeat& beat) { return beat.kind != BusBeat::Kind::kNone; });
    }
};

void check_stages(int stages) {
    ClockedTestbench bench;
    RegistersBench dut(bench, stages);
    dut.send(3, 30);
    dut.send(4, 40);
    dut.send(40, 50);  // after a pause that the block sleeps through
    bench.core.pulse(dut.busready_in[0], 5);
    bench.core.pulse(dut.tableready_in[1], 60);
    bench.run_through(70);
    const int later = stages - 1;  // what edge n samples stands after edge n + stages - 1
    CHECK(dut.beat_clocks() == std::vector<int>{3 + later, 4 + later, 40 + later});
    CHECK(dut.beats.at(3 + later).first == 30);
    CHECK(dut.beats.at(4 + later).words[0] == 0xABCD'0000'0000'0028U);
    CHECK(dut.beats.at(40 + later).first == 50);
    CHECK(dut.busready[0]->high() == std::vector<int>{5 + later});
    CHECK(dut.busready[1]->high().empty());
    CHECK(dut.tableready[0]->high().empty());
    CHECK(dut.tableready[1]->high() == std::vector<int>{60 + later});
}

TEST_CASE("bus registers: through one stage a beat and each ready wire pass in a clock") { check_stages(1); }

TEST_CASE("bus registers: a beat and each ready wire pass through all stages, a stage a clock") {
    check_stages(4);
}

TEST_CASE("bus registers: reset empties every stage") {
    ClockedTestbench bench;
    RegistersBench dut(bench, 4);
    dut.send(3, 30);
    bench.core.drive(dut.busready_in[0], 3, true);
    bench.core.drive(dut.busready_in[0], 5, false);
    bench.core.drive(bench.reset, 5, true);
    bench.core.drive(bench.reset, 6, false);
    bench.run_through(20);
    CHECK(dut.beat_clocks().empty());
    CHECK(dut.busready[0]->high().empty());
}

TEST_CASE("bus registers: a reset also empties registers that are asleep") {
    ClockedTestbench bench;
    RegistersBench dut(bench, 2);
    bench.core.drive(dut.busready_in[0], 3, true);  // and stays high
    bench.core.pulse(bench.reset, 60);
    bench.run_through(70);
    CHECK(dut.busready[0]->at(59));
    CHECK_FALSE(dut.busready[0]->at(60));
    CHECK_FALSE(dut.busready[0]->at(61));
    CHECK(dut.busready[0]->at(62));
}

}  // namespace
}  // namespace metabuffer::test::bus_registers_test
