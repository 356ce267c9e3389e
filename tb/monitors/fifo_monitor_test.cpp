#include "monitors/fifo_monitor.h"

#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "rule_table.h"
#include "support/scenarios.h"

namespace metabuffer::test::fifo_monitor_test {

// A composer or a FIFO, both played by the test, breaks each rule of docs/monitors.md once, and no other rule.
namespace {

constexpr int kCapacity = 20;  // of 32 addresses
constexpr int kEnd = 40;

/// What a wire carries from an edge on.
template <typename Value>
using Values = std::map<int, Value>;

/// A stream by the rules: eight pixels come, two are read, three are released, six come and are given up.
struct FifoBench : ClockedRuleBench {
    Scenario scenario;
    sc_core::sc_signal<rtl::FifoWrite> write;
    sc_core::sc_signal<rtl::FifoRead> read;
    sc_core::sc_signal<rtl::FifoRelease> release;
    sc_core::sc_signal<std::uint64_t> word;
    sc_core::sc_signal<std::uint32_t> free;
    // Of a window of two rows.
    sc_core::sc_signal<std::uint64_t> next_word;
    sc_core::sc_signal<rtl::FifoRead> row_read;
    sc_core::sc_signal<std::uint64_t> row_word;
    sc_core::sc_signal<std::uint64_t> row_next_word;
    monitors::FifoMonitor monitor;
    std::map<int, rtl::FifoWrite> writes;  ///< at an edge, as those after it
    std::map<int, rtl::FifoRead> reads{{5, {true, 30}}, {9, {true, 0}}, {14, {true, 5}}};
    std::map<int, rtl::FifoRead> row_reads{{6, {true, 31}}};
    std::map<int, rtl::FifoRelease> releases{{10, {3, 0}}, {16, {0, 6}}};
    Values<std::uint32_t> frees{{0, kCapacity}, {4, 12}, {11, 15}, {15, 9}, {17, 15}};
    Values<std::uint64_t> words{{0, 0}, {6, 130}, {10, 132}, {15, 105}};
    Values<std::uint64_t> next_words{{0, 0}, {6, 131}, {10, 133}, {15, 106}};
    Values<std::uint64_t> row_words{{0, 0}, {7, 131}};
    Values<std::uint64_t> row_next_words{{0, 0}, {7, 132}};

    FifoBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench,
              Smoothing smoothing = Smoothing::kReplicate)
        : ClockedRuleBench(name, testbench),
          scenario(with_capacity(smoothing)),
          monitor("monitor", scenario, "composer_1_1", log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.write_i(write);
        monitor.read_i(read);
        monitor.release_i(release);
        monitor.word_i(word);
        monitor.free_i(free);
        if (smoothing == Smoothing::kBilinear) {
            monitor.second_row->next_word_i(next_word);
            monitor.second_row->row_read_i(row_read);
            monitor.second_row->row_word_i(row_word);
            monitor.second_row->row_next_word_i(row_next_word);
        }
        put(3, 28, 8);
        put(14, 4, 6);
        bench.core.each_clock([this](int clock) {
            write.write(at(writes, clock));
            read.write(at(reads, clock));
            row_read.write(at(row_reads, clock));
            release.write(at(releases, clock));
            free.write(std::prev(frees.upper_bound(clock))->second);
            word.write(std::prev(words.upper_bound(clock))->second);
            next_word.write(std::prev(next_words.upper_bound(clock))->second);
            row_word.write(std::prev(row_words.upper_bound(clock))->second);
            row_next_word.write(std::prev(row_next_words.upper_bound(clock))->second);
        });
    }
    static Scenario with_capacity(Smoothing smoothing) {
        Scenario scenario = small_scenario(8, 4);
        scenario.composer.smoothing = smoothing;
        scenario.composer.buffer_pixels = kCapacity;
        scenario.renderers.push_back(renderer_of({PixelImage(8, 4)}));
        return scenario;
    }
    template <typename Value>
    static Value at(const std::map<int, Value>& pulses, int clock) {
        const auto found = pulses.find(clock);
        return found == pulses.end() ? Value{} : found->second;
    }
    void put(int clock, int address, int count) {
        rtl::FifoWrite& beat = writes[clock];
        beat.address = static_cast<std::uint32_t>(address);
        beat.count = static_cast<std::uint8_t>(count);
        for (int i = 0; i < count; ++i)
            beat.words[static_cast<std::size_t>(i)] = 100 + static_cast<unsigned>(address + i);
    }
};

const std::string kFifo = "composer_1_1.fifo.";

}  // namespace

TEST_CASE("fifo monitor: its rules in a table", "[monitors]") {
    ClockedRuleTable<FifoBench> rules;
    rules.of();
    rules.row("a stream by the rules", {}, {},
              [](const auto& bench) { CHECK(bench.monitor.pixels_written() == 14); });
    rules.row("an address is written to while its pixel is held", {{"fifo/overwrite", kFifo + "write", 20}},
              [](auto& bench) {
                  bench.put(20, 3, 1);
                  bench.frees[21] = 14;
              });
    rules.row("a pixel is read that was given up", {{"fifo/read", kFifo + "read", 20}}, [](auto& bench) {
        bench.reads[20] = {true, 7};
    });
    rules.row("a pixel is read that has been released", {{"fifo/read", kFifo + "read", 12}}, [](auto& bench) {
        bench.reads[12] = {true, 30};
    });
    rules.row("more pixels are released than are held", {{"fifo/release", kFifo + "release", 20}},
              [](auto& bench) {
                  bench.releases[20] = {4, 2};
              });
    rules.row("another word than the one that was written", {{"fifo/word", kFifo + "word", 6}},
              [](auto& bench) { bench.words[6] = 131; });
    rules.row("a word does not stay until the next read", {{"fifo/word", kFifo + "word", 30}},
              [](auto& bench) { bench.words[30] = 0; });
    rules.row("a wrong count of what is free", {{"fifo/free", kFifo + "free", 11}}, [](auto& bench) {
        bench.frees[11] = 14;
        bench.frees[12] = 15;
    });

    rules.of(Smoothing::kBilinear);
    rules.row("both rows of a window read by the rules", {});
    rules.row("another word than that of the next address", {{"fifo/word", kFifo + "next_word", 10}},
              [](auto& bench) { bench.next_words[10] = 132; });
    rules.row("another word of the other row", {{"fifo/word", kFifo + "row_word", 7}},
              [](auto& bench) { bench.row_words[7] = 132; });
    rules.row("another word of the other row's next address", {{"fifo/word", kFifo + "row_next_word", 7}},
              [](auto& bench) { bench.row_next_words[7] = 133; });
    rules.row("a pixel of the other row is read that has not come", {{"fifo/read", kFifo + "row_read", 20}},
              [](auto& bench) {
                  bench.row_reads[20] = {true, 7};
              });
    rules.run_and_check(kEnd);
}

}  // namespace metabuffer::test::fifo_monitor_test
