#include "monitors/memory_monitor.h"

#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "support/scenarios.h"
#include "violations.h"

using namespace metabuffer;
using namespace metabuffer::test;

// Each rule of docs/monitors.md is broken once by a bus port, a link or a memory, played by the test, that breaks no
// other.
namespace {

using Kind = rtl::MemoryCommand::Kind;

constexpr int kEnd = 60;
constexpr int kPageWords = 8;
constexpr int kPrecharge = 2;
constexpr int kActivate = 3;

Scenario memory_scenario(int latency = 0, int refresh_interval = 0) {
    Scenario scenario = small_scenario(8, 4);
    scenario.memory.page_words = kPageWords;
    scenario.memory.banks = 2;
    scenario.memory.precharge_cycles = kPrecharge;
    scenario.memory.page_miss_cycles = kPrecharge + kActivate;
    scenario.memory.words_per_cycle = 2;
    scenario.memory.read_latency_cycles = latency;
    scenario.memory.refresh_interval_cycles = refresh_interval;
    scenario.memory.refresh_cycles = refresh_interval > 0 ? 4 : 0;
    scenario.renderers.push_back(renderer_of({PixelImage(8, 4)}));
    return scenario;
}

struct MemoryMonitorBench {
    ClockedTestbench bench;
    Scenario scenario;
    Violations violations{bench.core};
    sc_core::sc_signal<rtl::MemoryWrite> write;
    sc_core::sc_signal<bool> front{"front", false};
    sc_core::sc_signal<rtl::MemoryCommand> command;
    sc_core::sc_signal<rtl::MemoryData> data;
    monitors::MemoryMonitor monitor;

    explicit MemoryMonitorBench(Scenario with = memory_scenario())
        : scenario(std::move(with)), monitor("monitor", scenario, 0, violations.log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.write_clk_i(bench.core.clk);
        monitor.write_i(write);
        monitor.front_i(front);
        monitor.command_i(command);
        monitor.data_i(data);
        // The link fills device 1, which the bus reads from clock 9 on.
        for (int word = 0; word < 8; ++word) store(word, 1, word, 100 + static_cast<unsigned>(word));
        bench.core.drive(front, 9, true);
    }
    void store(int clock, int device, int address, std::uint64_t value) {
        bench.core.drive(write, clock,
                         rtl::MemoryWrite{true, static_cast<std::uint8_t>(device),
                                          static_cast<std::uint32_t>(address), value, 0xFF});
        bench.core.drive(write, clock + 1, rtl::MemoryWrite{});
    }
    void send(int clock, Kind kind, int page = 0, const std::vector<int>& columns = {}) {
        rtl::MemoryCommand sent;
        sent.kind = kind;
        sent.row = static_cast<std::uint32_t>(page);
        sent.bank = static_cast<std::uint8_t>(page % 2);
        for (const int column : columns) sent.columns[sent.count++] = static_cast<std::uint32_t>(column);
        bench.core.drive(command, clock, sent);
        bench.core.drive(command, clock + 1, rtl::MemoryCommand{});
    }
    void answer(int clock, const std::vector<std::uint64_t>& words) {
        rtl::MemoryData put_out;
        for (const std::uint64_t word : words) put_out.words[put_out.count++] = word;
        bench.core.drive(data, clock, put_out);
        bench.core.drive(data, clock + 1, rtl::MemoryData{});
    }
    void read(int clock, int page, const std::vector<int>& columns, const std::vector<std::uint64_t>& words) {
        send(clock, Kind::kRead, page, columns);
        answer(clock + scenario.memory.read_latency_cycles, words);
    }
    /// By the rules: page 0 is read, then page 2 of the same bank, then page 1 of the other one.
    void put_stream() {
        send(10, Kind::kActivate, 0);
        read(13, 0, {0, 1}, {100, 101});
        read(14, 0, {5}, {105});
        send(16, Kind::kPrecharge, 2);
        send(18, Kind::kActivate, 2);
        read(21, 2, {3}, {0});
        send(22, Kind::kActivate, 1);
        read(25, 1, {0}, {0});
    }
    void run() { bench.run_through(kEnd); }
};

}  // namespace

TEST_CASE("memory monitor: a stream by the rules breaks none", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.words_read() == 5);
}

TEST_CASE("memory monitor: so does one with a read latency", "[monitors]") {
    MemoryMonitorBench bench(memory_scenario(3));
    bench.put_stream();
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.words_read() == 5);
}

TEST_CASE("memory monitor: the link writes the device that the bus reads", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.store(30, 1, 3, 7);
    bench.run();
    bench.violations.check_only("memory/device", "frame_memory_1.write", 30, -1);
}

TEST_CASE("memory monitor: a read of a page that is not open", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.read(30, 0, {0}, {100});
    bench.run();
    bench.violations.check_only("memory/open", "frame_memory_1.command", 30, -1);
}

TEST_CASE("memory monitor: a page is opened while another one of its bank is", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.send(30, Kind::kActivate, 0);
    bench.run();
    bench.violations.check_only("memory/activate", "frame_memory_1.command", 30, -1);
}

TEST_CASE("memory monitor: a page is opened while its bank is still closing", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.send(30, Kind::kPrecharge, 0);
    bench.send(31, Kind::kActivate, 0);
    bench.run();
    bench.violations.check_only("memory/activate", "frame_memory_1.command", 31, -1);
}

TEST_CASE("memory monitor: other words than were written", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.send(30, Kind::kRead, 2, {3});
    bench.answer(30, {1});
    bench.run();
    bench.violations.check_only("memory/data", "frame_memory_1.data", 30, -1);
}

TEST_CASE("memory monitor: words that come too early", "[monitors]") {
    MemoryMonitorBench bench(memory_scenario(3));
    bench.put_stream();
    bench.send(30, Kind::kRead, 2, {3});
    bench.answer(32, {0});
    bench.run();
    bench.violations.check_only("memory/data", "frame_memory_1.data", 32, -1);
}

TEST_CASE("memory monitor: refreshes in time break no rule", "[monitors]") {
    MemoryMonitorBench bench(memory_scenario(0, 25));
    bench.send(25, Kind::kRefresh);
    bench.send(50, Kind::kRefresh);
    bench.send(54, Kind::kActivate, 0);
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("memory monitor: a refresh that does not come", "[monitors]") {
    MemoryMonitorBench bench(memory_scenario(0, 25));
    bench.send(26, Kind::kRefresh);
    bench.send(50, Kind::kRefresh);
    bench.run();
    bench.violations.check_only("memory/refresh", "frame_memory_1.command", 25, -1);
}

TEST_CASE("memory monitor: a command while a refresh lasts", "[monitors]") {
    MemoryMonitorBench bench(memory_scenario(0, 25));
    bench.send(25, Kind::kRefresh);
    bench.send(28, Kind::kActivate, 0);
    bench.send(50, Kind::kRefresh);
    bench.run();
    bench.violations.check_only("memory/refresh", "frame_memory_1.command", 28, -1);
}
