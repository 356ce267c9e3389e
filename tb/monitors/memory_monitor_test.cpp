#include "monitors/memory_monitor.h"

#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "rule_table.h"
#include "support/scenarios.h"

namespace metabuffer::test::memory_monitor_test {

// A bus port, a link or a memory, played by the test, breaks each rule of docs/monitors.md once, and no other rule.
namespace {

using Kind = rtl::MemoryCommand::Kind;
using Words = std::vector<std::uint64_t>;

constexpr int kEnd = 60;
constexpr int kPrecharge = 2;
constexpr int kActivate = 3;

/// Of the second renderer. Its image of 30 words has four pages of eight, so that with shared ports page 4 is the first of
/// the other image, and the last of its blocks of four words has two.
Scenario memory_scenario() {
    Scenario scenario = small_scenario(8, 4);
    scenario.memory.page_words = 8;
    scenario.memory.banks = 2;
    scenario.memory.precharge_cycles = kPrecharge;
    scenario.memory.page_miss_cycles = kPrecharge + kActivate;
    scenario.memory.words_per_cycle = 2;
    scenario.memory.write_block_words = 4;
    scenario.renderers = {renderer_of({PixelImage(2, 2)}), renderer_of({PixelImage(6, 5)})};
    return scenario;
}
Scenario altered(const std::function<void(MemoryConfig&)>& change) {
    Scenario scenario = memory_scenario();
    change(scenario.memory);
    return scenario;
}
Scenario memory_of(int precharge_cycles, int activate_cycles) {
    return altered([=](MemoryConfig& memory) {
        memory.precharge_cycles = precharge_cycles;
        memory.page_miss_cycles = precharge_cycles + activate_cycles;
    });
}
Scenario refreshed_memory(int refresh_cycles) {
    return altered([=](MemoryConfig& memory) {
        memory.refresh_interval_cycles = 25;
        memory.refresh_cycles = refresh_cycles;
    });
}

template <typename Value>
Value at(const std::map<int, Value>& values, int clock) {
    const auto found = values.find(clock);
    return found == values.end() ? Value{} : found->second;
}

/// The wires by the clock that samples them. The link fills the first page of device 1 in clocks 0 to 7.
struct MemoryBench : ClockedRuleBench {
    Scenario scenario;
    sc_core::sc_signal<bool> reset{"reset", true}, front{"front", false};
    sc_core::sc_signal<rtl::MemoryWrite> write;
    sc_core::sc_signal<rtl::MemoryCommand> command;
    sc_core::sc_signal<rtl::MemoryData> data, write_data;
    monitors::MemoryMonitor monitor;
    std::map<int, rtl::MemoryWrite> link;
    std::map<int, rtl::MemoryCommand> commands;
    std::map<int, rtl::MemoryData> answers, brought;
    std::set<int> resets;
    std::set<int> swaps;  ///< from then on the bus reads the other device

    MemoryBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench, Scenario with,
                const std::function<void(MemoryBench&)>& stream)
        : ClockedRuleBench(name, testbench), scenario(std::move(with)), monitor("monitor", scenario, 1, log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(reset);
        monitor.write_clk_i(bench.core.clk);
        monitor.write_i(write);
        monitor.front_i(front);
        monitor.command_i(command);
        monitor.data_i(data);
        for (auto& port : monitor.write_data_i) port(write_data);
        bench.core.each_clock([this](int clock) {
            reset.write(resets.count(clock) > 0);
            if (swaps.count(clock) > 0) front.write(!front.read());
            write.write(at(link, clock));
            command.write(at(commands, clock));
            data.write(at(answers, clock));
            write_data.write(at(brought, clock));
        });
        fill(0, 1, 0, 8, 100);
        stream(*this);
    }

    /// The link's words, one a clock, with values that count up.
    MemoryBench& fill(int clock, int device, int first, int words, std::uint64_t value,
                      std::uint8_t mask = 0xFF) {
        for (int word = 0; word < words; ++word) {
            link[clock + word] = {true, static_cast<std::uint8_t>(device),
                                  static_cast<std::uint32_t>(first + word),
                                  value + static_cast<std::uint64_t>(word), mask};
        }
        return *this;
    }
    MemoryBench& send(int clock, Kind kind, int page = 0, const std::vector<int>& columns = {},
                      std::uint8_t mask = 0xFF) {
        rtl::MemoryCommand& sent = commands[clock] = {};
        sent.kind = kind;
        sent.row = static_cast<std::uint32_t>(page);
        sent.bank = static_cast<std::uint8_t>(page % 2);
        sent.byte_mask = mask;
        for (const int column : columns) sent.columns[sent.count++] = static_cast<std::uint32_t>(column);
        return *this;
    }
    MemoryBench& activate(int clock, int page) { return send(clock, Kind::kActivate, page); }
    MemoryBench& precharge(int clock, int bank) { return send(clock, Kind::kPrecharge, bank); }
    MemoryBench& answer(int clock, const Words& words) { return put(answers, clock, words); }
    MemoryBench& read(int clock, int page, const std::vector<int>& columns, const Words& words) {
        return send(clock, Kind::kRead, page, columns)
            .answer(clock + scenario.memory.read_latency_cycles, words);
    }
    MemoryBench& store(int clock, int page, const std::vector<int>& columns, const Words& words,
                       std::uint8_t mask = 0xFF) {
        return send(clock, Kind::kWrite, page, columns, mask).put(brought, clock, words);
    }
    /// Page 0 of bank 0 is read, then page 2; last page 1 of the other bank.
    void put_stream() {
        swaps = {9};
        fill(8, 1, 29, 1, 129);
        activate(10, 0).read(13, 0, {0, 1}, {100, 101}).read(14, 0, {5}, {105});
        precharge(16, 0).activate(18, 2).read(21, 2, {3}, {0});
        activate(22, 1).read(25, 1, {0}, {0});
    }
    /// With shared ports the link's eight words are two blocks. Both are written and read.
    void put_blocks() {
        swaps = {17};
        activate(10, 4);
        store(13, 4, {0, 1}, {100, 101}).store(14, 4, {2, 3}, {102, 103});
        store(15, 4, {4, 5}, {104, 105}).store(16, 4, {6, 7}, {106, 107});
        read(17, 4, {2, 7}, {102, 107});
    }

  private:
    MemoryBench& put(std::map<int, rtl::MemoryData>& where, int clock, const Words& words) {
        rtl::MemoryData& of = where[clock] = {};
        for (const std::uint64_t word : words) of.words[of.count++] = word;
        return *this;
    }
};
void no_stream(MemoryBench& bench) { bench.swaps = {9}; }

const std::string kWrite = "frame_memory_2.write";
const std::string kCommand = "frame_memory_2.command";
const std::string kData = "frame_memory_2.data";

/// The stream breaks no rule; words of it come wrong.
void add_data_rows(ClockedRuleTable<MemoryBench>& rules, int latency) {
    const Scenario scenario =
        altered([latency](MemoryConfig& memory) { memory.read_latency_cycles = latency; });
    const std::string of = " after " + std::to_string(latency) + " clocks";
    rules.of(scenario, &MemoryBench::put_stream);
    const auto row = [&](const std::string& name, const std::vector<Reported>& reports, const auto& change) {
        rules.row(name + of, reports, change);
    };
    rules.row("a stream by the rules, with its words" + of, {}, {},
              [](const auto& bench) { CHECK(bench.monitor.words_read() == 5); });
    row("another word than was written", {{"memory/data", kData, 30 + latency}},
        [](auto& bench) { bench.read(30, 2, {3}, {1}); });
    row("a word of two is another one", {{"memory/data", kData, 31 + latency}}, [](auto& bench) {
        bench.precharge(26, 0).activate(28, 0).read(31, 0, {1, 2}, {101, 107});
    });
    row("a word too few", {{"memory/data", kData, 30 + latency}}, [](auto& bench) {
        bench.read(30, 2, {3, 4}, {0});
    });
    row("a word too many", {{"memory/data", kData, 30 + latency}}, [](auto& bench) {
        bench.read(30, 2, {3}, {0, 0});
    });
    row("no words", {{"memory/data", kData, 30 + latency}}, [](auto& bench) { bench.read(30, 2, {3}, {}); });
    row("words without a read", {{"memory/data", kData, 38 + latency}},
        [=](auto& bench) { bench.answer(38 + latency, {0}); });
    row("of the image's last word and one beyond it, which is 0", {}, [](auto& bench) {
        bench.precharge(30, 1).activate(32, 3).read(35, 3, {5, 6}, {129, 0});
    });
}

}  // namespace

TEST_CASE("memory monitor: its rules in a table", "[monitors]") {
    ClockedRuleTable<MemoryBench> rules;
    add_data_rows(rules, 0);
    add_data_rows(rules, 20);  // longer than it takes the monitor to sleep
    add_data_rows(rules, 3);
    rules.row("what is on its way at a reset never comes", {}, [](auto& bench) {
        bench.send(30, Kind::kRead, 2, {3}).resets = {31, 32};
    });

    rules.of(memory_scenario(), &MemoryBench::put_stream);
    rules.row("the link writes the device that the bus reads", {{"memory/device", kWrite, 30}},
              [](auto& bench) { bench.fill(30, 1, 3, 1, 7); });
    rules.row(
        "a write that stands is one in each clock", {{"memory/device", kWrite, 30}},
        [](auto& bench) {
            for (int clock = 30; clock < 50; ++clock) bench.fill(clock, 1, 3, 1, 7);
        },
        [](const auto& bench) { CHECK(bench.monitor.unreported() == 19); });
    rules.row(
        "the link writes the device that the bus does not read, which is read after a swap", {},
        [](auto& bench) {
            bench.fill(30, 0, 16, 2, 0x1111'1111'1111'1111, rtl::MemoryWrite::kColourBytes);
            bench.fill(32, 0, 16, 1, 0x2222'2222'2222'2222, rtl::MemoryWrite::kDepthBytes).swaps.insert(35);
            bench.read(36, 2, {0, 1}, {0x2222'2222'2211'1111, 0x11'1112});
        });
    rules.row("the link writes the first device while the bus reads it", {{"memory/device", kWrite, 36}},
              [](auto& bench) { bench.fill(36, 0, 3, 1, 7).swaps.insert(35); });
    rules.row("a read while another page of its bank is open", {{"memory/open", kCommand, 30}},
              [](auto& bench) { bench.read(30, 0, {0}, {100}); });
    rules.row("a read of a bank that is closed", {{"memory/open", kCommand, 33}},
              [](auto& bench) { bench.precharge(30, 0).read(33, 2, {0}, {0}); });
    rules.row("a read after both banks were closed", {{"memory/open", kCommand, 33}},
              [](auto& bench) { bench.send(30, Kind::kPrechargeAll).read(33, 1, {0}, {0}); });
    rules.row("a read after a reset, which closes the banks", {{"memory/open", kCommand, 33}},
              [](auto& bench) { bench.read(33, 2, {0}, {0}).resets = {31}; });
    rules.row("a page is opened at the first clock after a reset", {}, [](auto& bench) {
        bench.precharge(30, 0).activate(32, 0).read(35, 0, {0}, {100}).resets = {31};
    });
    rules.row("a command in reset is none", {},
              [](auto& bench) { bench.send(31, Kind::kActivate, 0).answer(31, {7}).resets = {31}; });
    rules.row(
        "one report of a rule", {{"memory/open", kCommand, 30}},
        [](auto& bench) { bench.read(30, 0, {0}, {100}).read(40, 2, {0}, {0}); },
        [](const auto& bench) { CHECK(bench.monitor.unreported() == 1); });
    rules.row("a page is opened while another one of its bank is open", {{"memory/activate", kCommand, 30}},
              [](auto& bench) { bench.activate(30, 0); });
    rules.row("a page is opened that is open", {{"memory/activate", kCommand, 30}},
              [](auto& bench) { bench.activate(30, 2); });
    rules.row("a page is opened in a bank that it does not lie in", {{"memory/activate", kCommand, 32}},
              [](auto& bench) { bench.precharge(30, 1).activate(32, 2).commands[32].bank = 1; });
    rules.row("a page is opened while its bank is still closing", {{"memory/activate", kCommand, 31}},
              [](auto& bench) { bench.precharge(30, 0).activate(31, 0); });
    rules.row("a page is opened while both banks are still closing", {{"memory/activate", kCommand, 31}},
              [](auto& bench) { bench.send(30, Kind::kPrechargeAll).activate(31, 3); });
    rules.row("a page is opened as soon as both banks are closed", {}, [](auto& bench) {
        bench.send(30, Kind::kPrechargeAll).activate(32, 3).activate(33, 0).read(35, 3, {0}, {0});
    });
    rules.row("a bank closes while the other one is read and opened", {}, [](auto& bench) {
        bench.precharge(30, 0)
            .read(31, 1, {1}, {0})
            .activate(32, 0)
            .read(33, 1, {2}, {0})
            .read(35, 0, {0}, {100});
    });
    rules.row("a page is read while it is being activated", {{"memory/timing", kCommand, 34}},
              [](auto& bench) { bench.precharge(30, 0).activate(32, 0).read(34, 0, {0}, {100}); });
    rules.row("a page is closed while it is being activated", {},
              [](auto& bench) { bench.precharge(30, 0).activate(32, 0).precharge(33, 0).activate(35, 2); });
    rules.row("a refresh in a memory that has none", {{"memory/refresh", kCommand, 30}},
              [](auto& bench) { bench.send(30, Kind::kRefresh); });

    rules.of(memory_of(1, kActivate), no_stream);
    rules.row("a bank that closes in one clock must be closed, too", {{"memory/activate", kCommand, 30}},
              [](auto& bench) { bench.activate(20, 0).activate(30, 2); });

    rules.of(memory_of(kPrecharge, 0), no_stream);
    rules.row("where an activation takes no clock, a read opens its page once the bank is closed", {},
              [](auto& bench) {
                  bench.read(20, 0, {0}, {100}).read(21, 1, {0}, {0}).precharge(30, 0).read(32, 2, {0}, {0});
              });
    rules.row("where an activation takes no clock, a read while its bank is closing",
              {{"memory/timing", kCommand, 31}},
              [](auto& bench) { bench.read(20, 0, {0}, {100}).precharge(30, 0).read(31, 2, {0}, {0}); });
    rules.row("where an activation takes no clock, a read while another page is open",
              {{"memory/open", kCommand, 30}},
              [](auto& bench) { bench.read(20, 0, {0}, {100}).read(30, 2, {0}, {0}); });
    rules.row("where an activation takes no clock, a page is read as it is opened", {},
              [](auto& bench) { bench.activate(20, 0).read(21, 0, {0}, {100}); });

    rules.of(memory_of(0, kActivate), no_stream);
    rules.row("without precharge_cycles a page is opened while another is, and read at once", {},
              [](auto& bench) {
                  bench.activate(20, 0).read(21, 0, {0}, {100}).activate(22, 2).read(23, 2, {0}, {0});
              });
    rules.row("without precharge_cycles a page is read that is not open", {{"memory/open", kCommand, 30}},
              [](auto& bench) { bench.activate(20, 0).read(30, 2, {0}, {0}); });

    rules.of(memory_of(0, 0), no_stream);
    rules.row("where a page miss takes no clock, any read opens its page", {}, [](auto& bench) {
        bench.read(20, 0, {0}, {100}).read(21, 2, {0}, {0}).precharge(22, 0).read(23, 0, {1}, {101});
    });

    rules.of(refreshed_memory(4), [](MemoryBench& bench) {
        no_stream(bench);
        bench.activate(15, 0).send(25, Kind::kRefresh).send(50, Kind::kRefresh);
    });
    rules.row("refreshes in time, and commands after them", {},
              [](auto& bench) { bench.activate(29, 0).read(32, 0, {0}, {100}).activate(54, 1); });
    rules.row("a refresh that does not come", {{"memory/refresh", kCommand, 25}},
              [](auto& bench) { bench.commands.erase(25); });
    rules.row(
        "a refresh that is early", {{"memory/refresh", kCommand, 24}},
        [](auto& bench) { bench.send(24, Kind::kRefresh); },
        [](const auto& bench) { CHECK(bench.monitor.unreported() == 1); });
    rules.row("a command while a refresh lasts", {{"memory/refresh", kCommand, 28}},
              [](auto& bench) { bench.activate(28, 0); });
    rules.row("a refresh closes the banks", {{"memory/open", kCommand, 30}},
              [](auto& bench) { bench.read(30, 0, {0}, {100}); });
    rules.row("refreshes count from the end of reset", {}, [](auto& bench) {
        bench.resets = {26};
        bench.activate(27, 0).commands.erase(50);
        bench.send(52, Kind::kRefresh);
    });

    rules.of(refreshed_memory(1), no_stream);
    rules.row("a refresh has closed the banks when it ends", {}, [](auto& bench) {
        bench.activate(15, 0).send(25, Kind::kRefresh).activate(26, 0).send(50, Kind::kRefresh);
    });

    rules.of(altered([](MemoryConfig& memory) { memory.ports = MemoryPorts::kShared; }),
             &MemoryBench::put_blocks);
    rules.row("with shared ports, blocks that are written as the link brought them", {}, {},
              [](const auto& bench) { CHECK(bench.monitor.words_read() == 2); });
    rules.row("a frame that is broken off in its second block, and the first block of the next one", {},
              [](auto& bench) {
                  bench.fill(20, 0, 0, 6, 200).fill(30, 0, 0, 4, 300);
                  bench.precharge(31, 0).activate(33, 0);
                  bench.store(40, 0, {0, 1}, {200, 201}).store(41, 0, {2, 3}, {202, 203});
                  bench.store(42, 0, {0, 1}, {300, 301}).store(43, 0, {2, 3}, {302, 303});
              });
    rules.row("an image's last block has the words that are left", {}, [](auto& bench) {
        bench.fill(20, 0, 28, 2, 228).activate(30, 3).store(33, 3, {4, 5}, {228, 229});
    });
    rules.row("after an image's last block no word waits", {{"memory/write", kCommand, 34}}, [](auto& bench) {
        bench.fill(20, 0, 28, 2, 228).activate(30, 3).store(33, 3, {4, 5}, {228, 229}).store(34, 3, {6}, {0});
    });
    rules.row("blocks that were waiting at a reset are written no more", {{"memory/write", kCommand, 40}},
              [](auto& bench) {
                  bench.fill(20, 0, 0, 4, 200).resets = {30};
                  bench.activate(33, 0).store(40, 0, {0}, {200});
              });
    rules.row("words of the link that are written before their block is whole",
              {{"memory/write", kCommand, 30}}, [](auto& bench) {
                  bench.fill(20, 0, 0, 3, 0)
                      .activate(22, 1)
                      .precharge(23, 0)
                      .activate(25, 0)
                      .store(30, 0, {0}, {0});
              });
    rules.row("words of the link that are left out", {{"memory/write", kCommand, 40}}, [](auto& bench) {
        bench.fill(20, 0, 0, 4, 0).precharge(31, 0).activate(33, 0).store(40, 0, {1}, {0});
    });
    rules.row("words of the link that are written with another mask", {{"memory/write", kCommand, 13}},
              [](auto& bench) { bench.commands[13].byte_mask = rtl::MemoryWrite::kColourBytes; });
    rules.row("words of the link that are written with other values",
              {{"memory/write", "frame_memory_2.write_data", 13}},
              [](auto& bench) { bench.brought[13].words[1] = 102; });
    rules.row(
        "a word of the link that is written to a page that is not open", {{"memory/open", kCommand, 13}},
        [](auto& bench) { bench.commands.erase(10); },
        [](const auto& bench) { CHECK(bench.monitor.unreported() == 0); });
    rules.row("two blocks wait, and none more", {}, [](auto& bench) { bench.fill(20, 0, 0, 8, 0); });
    rules.row("a third block begins while two wait", {{"memory/write", kWrite, 28}},
              [](auto& bench) { bench.fill(20, 0, 0, 9, 0); });
    rules.row("words of the link that are written into the image that is read",
              {{"memory/write", kCommand, 40}}, [](auto& bench) {
                  bench.swaps.insert(24);
                  bench.fill(20, 0, 0, 4, 0).precharge(31, 0).activate(33, 0).store(40, 0, {0}, {0});
              });
    rules.run_and_check(kEnd);
}

}  // namespace metabuffer::test::memory_monitor_test
