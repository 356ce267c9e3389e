#include "rtl/display_memory.h"

#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "expected_report.h"
#include "support/random_seed.h"

namespace metabuffer::test::display_memory_test {
namespace {

using rtl::DisplayMemory;
using rtl::DisplayRead;
using rtl::DisplayWrite;

constexpr std::uint32_t kPixels = 12;

struct MemoryBench {
    ClockDomain& core;
    ClockDomain& dvi;
    sc_core::sc_signal<bool> writes, reads;
    sc_core::sc_signal<DisplayWrite> write;
    sc_core::sc_signal<DisplayRead> read;
    sc_core::sc_signal<std::uint32_t> data;
    DisplayMemory dut;
    const Recording<std::uint32_t>& colours;  ///< what stands after each DVI edge

    MemoryBench(ClockedTestbench& bench, ClockDomain& dvi_domain, const std::string& name = "display_memory")
        : core(bench.core), dvi(dvi_domain), dut(name.c_str(), kPixels), colours(dvi_domain.record(data)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.writes_i(writes);
        dut.write_i(write);
        dut.dvi_clk_i(dvi.clk);
        dut.reads_i(reads);
        dut.read_i(read);
        dut.data_o(data);
        bench.trace(dut);
    }
    /// Stands at write_i at core edge `clock` alone.
    void put(int clock, const DisplayWrite& pixel) {
        core.drive(writes, clock, true);
        core.drive(write, clock, pixel);
        core.drive(writes, clock + 1, false);
    }
    /// DVI edge `clock` reads.
    void get(int clock, bool bank, std::uint32_t address) {
        dvi.drive(reads, clock, true);
        dvi.drive(read, clock, DisplayRead{bank, address});
        dvi.drive(reads, clock + 1, false);
    }
};

TEST_CASE("display memory: a pixel is put out at the edge that reads it, and stands until the next is read") {
    ClockedTestbench bench;
    MemoryBench dut(bench, bench.core);
    dut.put(2, {false, 0, 0x112233});
    dut.put(3, {false, kPixels - 1, 0x445566});
    dut.get(20, false, kPixels - 1);  // after a pause in which both ports sleep
    dut.get(40, false, 0);
    bench.run_through(60);
    CHECK(dut.colours.at(19) == 0);
    for (int clock = 20; clock < 40; ++clock) CHECK(dut.colours.at(clock) == 0x445566);
    for (int clock = 40; clock < 60; ++clock) CHECK(dut.colours.at(clock) == 0x112233);
}

TEST_CASE("display memory: the banks hold a pixel each at an address") {
    ClockedTestbench bench;
    MemoryBench dut(bench, bench.core);
    dut.put(2, {false, 5, 0xAAAAAA});
    dut.put(3, {true, 5, 0xBBBBBB});
    dut.get(6, false, 5);
    dut.get(7, true, 5);
    dut.get(8, true, 4);
    bench.run_through(10);
    CHECK(dut.colours.at(6) == 0xAAAAAA);
    CHECK(dut.colours.at(7) == 0xBBBBBB);
    CHECK(dut.colours.at(8) == 0);
}

TEST_CASE("display memory: without writes_i nothing is stored, and without reads_i nothing is put out") {
    ClockedTestbench bench;
    MemoryBench dut(bench, bench.core);
    dut.put(2, {false, 5, 0xAAAAAA});
    bench.core.drive(dut.write, 5, DisplayWrite{false, 5, 0xBBBBBB});
    bench.core.drive(dut.read, 5, DisplayRead{false, 5});
    dut.get(9, false, 5);
    bench.run_through(12);
    CHECK(dut.colours.at(8) == 0);
    CHECK(dut.colours.at(9) == 0xAAAAAA);  // what stands at write_i is not on its way
}

TEST_CASE("display memory: a pixel that is still at write_i is read as it will be stored, no other one is") {
    ClockedTestbench bench;
    ClockDomain& dvi = bench.add_clock("dvi", 1'000);  // ten edges to one of the core clock
    MemoryBench dut(bench, dvi);
    const auto dvi_clock_of = [&](int core_clock) {
        return 10 * (core_clock + bench.core.reset_clocks()) - dvi.reset_clocks();
    };
    dut.put(2, {false, 3, 0x101010});
    dut.put(3, {true, 3, 0x202020});
    dut.put(4, {false, 4, 0x303030});
    dut.put(20, {false, 3, 0x404040});
    // The domains know how long reset lasts once the run begins.
    bench.run_through(10);
    // It stands at write_i from the falling edge before core edge 20 on.
    const int stored = dvi_clock_of(20);
    dut.get(stored - 7, false, 3);
    dut.get(stored - 4, false, 3);
    dut.get(stored - 3, true, 3);
    dut.get(stored - 2, false, 4);
    dut.get(stored + 8, false, 3);
    bench.run_through(24);
    CHECK(dut.colours.at(stored - 7) == 0x101010);
    CHECK(dut.colours.at(stored - 4) == 0x404040);
    CHECK(dut.colours.at(stored - 3) == 0x202020);
    CHECK(dut.colours.at(stored - 2) == 0x303030);
    CHECK(dut.colours.at(stored + 8) == 0x404040);
}

TEST_CASE("display memory: reset clears what is put out, and the pixels stay") {
    ClockedTestbench bench;
    MemoryBench dut(bench, bench.core);
    dut.put(2, {true, 7, 0x777777});
    dut.get(4, true, 7);
    bench.core.drive(bench.reset, 20, true);
    dut.get(21, true, 7);  // not while reset is high
    bench.core.drive(bench.reset, 22, false);
    dut.get(30, true, 7);
    bench.run_through(32);
    CHECK(dut.colours.at(19) == 0x777777);
    CHECK(dut.colours.at(20) == 0);
    CHECK(dut.colours.at(21) == 0);
    CHECK(dut.colours.at(29) == 0);
    CHECK(dut.colours.at(30) == 0x777777);
}

TEST_CASE("display memory: a write to an address that it does not have is reported") {
    ExpectedReport report("/metabuffer/display_memory/address");
    ClockedTestbench bench;
    MemoryBench dut(bench, bench.core);
    dut.put(2, {false, kPixels - 1, 0});
    dut.put(3, {true, kPixels, 0});
    bench.run_through(6);
    CHECK(report.count() == 1);
}

TEST_CASE("display memory: a read of an address that it does not have is reported") {
    ExpectedReport report("/metabuffer/display_memory/address");
    ClockedTestbench bench;
    MemoryBench dut(bench, bench.core);
    dut.get(2, true, kPixels - 1);
    dut.get(3, false, kPixels);
    bench.run_through(6);
    CHECK(report.count() == 1);
}

TEST_CASE("display memory: under random use it agrees with a map at every read, whatever the clocks' ratio") {
    const auto seed = random_seed(2209);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ClockedTestbench bench;
    constexpr int kClocks = 600;
    // Multiples of 16 ps: none of these has an edge at a falling edge of the core clock, when write_i changes.
    const std::vector<std::int64_t> periods{1'600, 9'984, 10'016, 33'328};
    std::vector<std::unique_ptr<MemoryBench>> duts;
    /// What stands at write_i or is stored, from the time at which it is driven on, by bank and address.
    std::vector<std::map<std::pair<bool, std::uint32_t>, std::map<std::int64_t, std::uint32_t>>> pixels;
    std::vector<std::vector<std::pair<int, DisplayRead>>> asked;
    for (const std::int64_t period : periods) {
        const std::string number = std::to_string(period);
        ClockDomain& dvi = bench.add_clock(("dvi_" + number).c_str(), period);
        duts.push_back(std::make_unique<MemoryBench>(bench, dvi, "display_memory_" + number));
        MemoryBench& dut = *duts.back();
        pixels.emplace_back();
        asked.emplace_back();
        const auto any_address = [&] { return static_cast<std::uint32_t>(random.between(0, kPixels - 1)); };
        for (int clock = 0; clock < kClocks; clock += random.between(1, random.one_in(5) ? 20 : 2)) {
            const DisplayWrite write{random.one_in(2), any_address(),
                                     static_cast<std::uint32_t>(random.bits()) & 0xFFFFFFU};
            dut.put(clock, write);
            pixels.back()[{write.bank, write.address}][clock] = write.colour;
        }
        const auto edges = static_cast<int>(kClocks * bench.core.period_picoseconds() / period);
        for (int clock = 0; clock < edges; clock += random.between(1, random.one_in(5) ? 20 : 2)) {
            const DisplayRead read{random.one_in(2), any_address()};
            dut.get(clock, read.bank, read.address);
            asked.back().emplace_back(clock, read);
        }
    }
    bench.run_through(kClocks + 20);
    for (std::size_t i = 0; i < duts.size(); ++i) {
        const MemoryBench& dut = *duts[i];
        for (const auto& [clock, read] : asked[i]) {
            INFO("period " << periods[i] << ", DVI clock " << clock << ", " << read);
            // The last core clock whose write was driven, half a period before its edge, before this read's edge.
            const std::int64_t period = bench.core.period_picoseconds();
            const std::int64_t time = (clock + dut.dvi.reset_clocks()) * dut.dvi.period_picoseconds();
            const std::int64_t last = (time + period / 2) / period - bench.core.reset_clocks();
            std::uint32_t due = 0;
            for (const auto& [written, colour] : pixels[i][{read.bank, read.address}]) {
                if (written <= last) due = colour;
            }
            REQUIRE(dut.colours.at(clock) == due);
        }
    }
}

}  // namespace
}  // namespace metabuffer::test::display_memory_test
