#include "monitors/memory_monitor.h"

#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "support/scenarios.h"
#include "violations.h"

namespace metabuffer::test::memory_monitor_test {

// A bus port, a link or a memory, played by the test, breaks each rule of docs/monitors.md once, and no other rule.
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
    sc_core::sc_signal<rtl::MemoryData> write_data;
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
        for (auto& port : monitor.write_data_i) port(write_data);
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

/// A memory with shared ports. The link has brought eight words of device 1, which are two blocks: words 32 to 39.
struct SharedMemoryBench : MemoryMonitorBench {
    SharedMemoryBench() : MemoryMonitorBench(shared()) {
        // Written by clock 16, and read after that.
        bench.core.drive(front, 9, false);
        bench.core.drive(front, 17, true);
    }
    static Scenario shared() {
        Scenario scenario = memory_scenario();
        scenario.memory.ports = MemoryPorts::kShared;
        scenario.memory.write_block_words = 4;
        return scenario;
    }
    void write_words(int clock, int page, const std::vector<int>& columns,
                     const std::vector<std::uint64_t>& words, std::uint8_t mask = 0xFF) {
        rtl::MemoryCommand sent;
        rtl::MemoryData brought;
        sent.kind = Kind::kWrite;
        sent.row = static_cast<std::uint32_t>(page);
        sent.bank = static_cast<std::uint8_t>(page % 2);
        sent.byte_mask = mask;
        for (const int column : columns) sent.columns[sent.count++] = static_cast<std::uint32_t>(column);
        for (const std::uint64_t word : words) brought.words[brought.count++] = word;
        bench.core.drive(write_data, clock, brought);
        bench.core.drive(command, clock, sent);
        bench.core.drive(command, clock + 1, rtl::MemoryCommand{});
    }
    /// By the rules: both blocks are written, and their page is read.
    void put_blocks() {
        send(10, Kind::kActivate, 4);
        write_words(13, 4, {0, 1}, {100, 101});
        write_words(14, 4, {2, 3}, {102, 103});
        write_words(15, 4, {4, 5}, {104, 105});
        write_words(16, 4, {6, 7}, {106, 107});
        read(17, 4, {2, 7}, {102, 107});
    }
};

}  // namespace

TEST_CASE("memory monitor: a stream by the rules breaks none", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.words_read() == 5);
}

TEST_CASE("memory monitor: a stream by the rules with a read latency breaks none", "[monitors]") {
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

TEST_CASE("memory monitor: a page is read while it is being activated", "[monitors]") {
    MemoryMonitorBench bench;
    bench.put_stream();
    bench.send(30, Kind::kPrecharge, 0);
    bench.send(32, Kind::kActivate, 0);
    bench.read(34, 0, {0}, {100});
    bench.run();
    bench.violations.check_only("memory/timing", "frame_memory_1.command", 34, -1);
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

TEST_CASE("memory monitor: with shared ports, blocks that are written as the link brought them break no rule",
          "[monitors]") {
    SharedMemoryBench bench;
    bench.put_blocks();
    // A frame that is broken off in its second block, and the first block of the next one.
    for (int word = 0; word < 6; ++word) bench.store(20 + word, 0, word, 200U + static_cast<unsigned>(word));
    for (int word = 0; word < 4; ++word) bench.store(30 + word, 0, word, 300U + static_cast<unsigned>(word));
    bench.send(30, Kind::kActivate, 1);  // another bank: page 0's is closed first
    bench.send(31, Kind::kPrecharge, 4);
    bench.send(33, Kind::kActivate, 0);
    bench.write_words(40, 0, {0, 1}, {200, 201});
    bench.write_words(41, 0, {2, 3}, {202, 203});
    bench.write_words(42, 0, {0, 1}, {300, 301});
    bench.write_words(43, 0, {2, 3}, {302, 303});
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("memory monitor: words of the link that are written before their block is whole", "[monitors]") {
    SharedMemoryBench bench;
    bench.put_blocks();
    for (int word = 0; word < 3; ++word) bench.store(20 + word, 0, word, 0);
    bench.write_words(30, 4, {0}, {0});
    bench.run();
    bench.violations.check_only("memory/write", "frame_memory_1.command", 30, -1);
}

TEST_CASE("memory monitor: words of the link that are left out", "[monitors]") {
    SharedMemoryBench bench;
    bench.put_blocks();
    for (int word = 0; word < 4; ++word) bench.store(20 + word, 0, word, 0);
    bench.send(31, Kind::kPrecharge, 4);
    bench.send(33, Kind::kActivate, 0);
    bench.write_words(40, 0, {1}, {0});
    bench.run();
    bench.violations.check_only("memory/write", "frame_memory_1.command", 40, -1);
}

TEST_CASE("memory monitor: words of the link that are written with another mask", "[monitors]") {
    SharedMemoryBench bench;
    bench.send(10, Kind::kActivate, 4);
    bench.write_words(13, 4, {0}, {100}, rtl::MemoryWrite::kColourBytes);
    bench.run();
    bench.violations.check_only("memory/write", "frame_memory_1.command", 13, -1);
}

TEST_CASE("memory monitor: words of the link that are written with other values", "[monitors]") {
    SharedMemoryBench bench;
    bench.send(10, Kind::kActivate, 4);
    bench.write_words(13, 4, {0, 1}, {100, 102});
    bench.run();
    bench.violations.check_only("memory/write", "frame_memory_1.write_data", 13, -1);
}

TEST_CASE("memory monitor: a word of the link that is written to a page that is not open", "[monitors]") {
    SharedMemoryBench bench;
    bench.write_words(13, 4, {0}, {100});
    bench.run();
    bench.violations.check_only("memory/open", "frame_memory_1.command", 13, -1);
}

TEST_CASE("memory monitor: a third block that comes before the first is written", "[monitors]") {
    SharedMemoryBench bench;
    // The bus reads device 1 by then: the link brings the other one's image.
    for (int word = 0; word < 4; ++word) bench.store(20 + word, 0, word, 0);
    bench.run();
    bench.violations.check_only("memory/write", "frame_memory_1.write", 20, -1);
}

TEST_CASE("memory monitor: words of the link that are written into the image that is read", "[monitors]") {
    SharedMemoryBench bench;
    bench.bench.core.drive(bench.front, 24, false);
    bench.put_blocks();
    for (int word = 0; word < 4; ++word) bench.store(20 + word, 0, word, 0);
    bench.send(31, Kind::kPrecharge, 4);
    bench.send(33, Kind::kActivate, 0);
    bench.write_words(40, 0, {0}, {0});
    bench.run();
    bench.violations.check_only("memory/write", "frame_memory_1.command", 40, -1);
}

}  // namespace metabuffer::test::memory_monitor_test
