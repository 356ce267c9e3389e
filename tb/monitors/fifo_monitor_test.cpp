#include "monitors/fifo_monitor.h"

#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "clocked_testbench.h"
#include "support/scenarios.h"
#include "violations.h"

namespace metabuffer::test::fifo_monitor_test {

// A composer or a FIFO, both played by the test, breaks each rule of docs/monitors.md once, and no other rule.
namespace {

constexpr int kCapacity = 20;  // of 32 addresses
constexpr int kEnd = 40;

struct FifoMonitorBench {
    ClockedTestbench bench;
    Scenario scenario;
    Violations violations{bench.core};
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
    // The values of the wires from an edge on.
    std::map<int, std::uint64_t> words;
    std::map<int, std::uint32_t> frees;
    std::map<int, std::uint64_t> next_words;
    std::map<int, std::uint64_t> row_words;
    std::map<int, std::uint64_t> row_next_words;

    explicit FifoMonitorBench(Smoothing smoothing = Smoothing::kReplicate)
        : scenario(with_capacity(smoothing)), monitor("monitor", scenario, "composer_1_1", violations.log) {
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
            next_words[0] = row_words[0] = row_next_words[0] = 0;
        }
        words[0] = 0;
        frees[0] = kCapacity;
    }
    static Scenario with_capacity(Smoothing smoothing) {
        Scenario scenario = small_scenario(8, 4);
        scenario.composer.smoothing = smoothing;
        scenario.composer.buffer_pixels = kCapacity;
        scenario.renderers.push_back(renderer_of({PixelImage(8, 4)}));
        return scenario;
    }
    void put(int clock, int address, int count) {
        rtl::FifoWrite beat;
        beat.address = static_cast<std::uint32_t>(address);
        beat.count = static_cast<std::uint8_t>(count);
        for (int i = 0; i < count; ++i)
            beat.words[static_cast<std::size_t>(i)] = 100 + static_cast<unsigned>(address + i);
        bench.core.drive(write, clock, beat);
        bench.core.drive(write, clock + 1, rtl::FifoWrite{});
    }
    void get(int clock, int address) {
        bench.core.drive(read, clock, rtl::FifoRead{true, static_cast<std::uint32_t>(address)});
        bench.core.drive(read, clock + 1, rtl::FifoRead{});
    }
    void let_go(int clock, unsigned oldest, unsigned newest = 0) {
        bench.core.drive(release, clock, rtl::FifoRelease{oldest, newest});
        bench.core.drive(release, clock + 1, rtl::FifoRelease{});
    }
    /// A stream by the rules: eight pixels come, two are read, three are released, six come and are given up.
    void put_stream() {
        put(3, 28, 8);
        frees[4] = 12;
        get(5, 30);
        words[6] = 130;
        get(9, 0);
        words[10] = 132;
        let_go(10, 3);
        frees[11] = 15;
        put(14, 4, 6);
        frees[15] = 9;
        get(14, 5);
        words[15] = 105;
        let_go(16, 0, 6);
        frees[17] = 15;
    }
    /// The other row is read, and the words beside those of put_stream() stand where they must.
    void put_second_row() {
        next_words[6] = 131;
        next_words[10] = 133;
        next_words[15] = 106;
        bench.core.drive(row_read, 6, rtl::FifoRead{true, 31});
        bench.core.drive(row_read, 7, rtl::FifoRead{});
        row_words[7] = 131;
        row_next_words[7] = 132;
    }
    void run() {
        for (const auto& [clock, value] : next_words) bench.core.drive(next_word, clock, value);
        for (const auto& [clock, value] : row_words) bench.core.drive(row_word, clock, value);
        for (const auto& [clock, value] : row_next_words) bench.core.drive(row_next_word, clock, value);
        for (const auto& [clock, value] : words) bench.core.drive(word, clock, value);
        for (const auto& [clock, value] : frees) bench.core.drive(free, clock, value);
        bench.run_through(kEnd);
    }
};

}  // namespace

TEST_CASE("fifo monitor: a stream by the rules breaks none", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.pixels_written() == 14);
}

TEST_CASE("fifo monitor: an address is written to while its pixel is held", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.put(20, 3, 1);
    bench.frees[21] = 14;
    bench.run();
    bench.violations.check_only("fifo/overwrite", "composer_1_1.fifo.write", 20, -1);
}

TEST_CASE("fifo monitor: a pixel is read that has not come", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.get(20, 7);  // it was given up
    bench.run();
    bench.violations.check_only("fifo/read", "composer_1_1.fifo.read", 20, -1);
}

TEST_CASE("fifo monitor: a pixel is read that has been released", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.get(12, 30);
    bench.run();
    bench.violations.check_only("fifo/read", "composer_1_1.fifo.read", 12, -1);
}

TEST_CASE("fifo monitor: more pixels are released than are held", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.let_go(20, 4, 2);
    bench.run();
    bench.violations.check_only("fifo/release", "composer_1_1.fifo.release", 20, -1);
}

TEST_CASE("fifo monitor: another word than the one that was written", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.words[6] = 131;
    bench.run();
    bench.violations.check_only("fifo/word", "composer_1_1.fifo.word", 6, -1);
}

TEST_CASE("fifo monitor: a word that does not stay until the next read", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.words[30] = 0;
    bench.run();
    bench.violations.check_only("fifo/word", "composer_1_1.fifo.word", 30, -1);
}

TEST_CASE("fifo monitor: a count of what is free that is wrong", "[monitors]") {
    FifoMonitorBench bench;
    bench.put_stream();
    bench.frees[11] = 14;
    bench.frees[12] = 15;
    bench.run();
    bench.violations.check_only("fifo/free", "composer_1_1.fifo.free", 11, -1);
}

TEST_CASE("fifo monitor: both rows of a window read by the rules break none", "[monitors]") {
    FifoMonitorBench bench(Smoothing::kBilinear);
    bench.put_stream();
    bench.put_second_row();
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("fifo monitor: another word than that of the next address", "[monitors]") {
    FifoMonitorBench bench(Smoothing::kBilinear);
    bench.put_stream();
    bench.put_second_row();
    bench.next_words[10] = 132;
    bench.run();
    bench.violations.check_only("fifo/word", "composer_1_1.fifo.next_word", 10, -1);
}

TEST_CASE("fifo monitor: another word of the other row", "[monitors]") {
    FifoMonitorBench bench(Smoothing::kBilinear);
    bench.put_stream();
    bench.put_second_row();
    bench.row_next_words[7] = 133;
    bench.run();
    bench.violations.check_only("fifo/word", "composer_1_1.fifo.row_next_word", 7, -1);
}

TEST_CASE("fifo monitor: a pixel of the other row is read that has not come", "[monitors]") {
    FifoMonitorBench bench(Smoothing::kBilinear);
    bench.put_stream();
    bench.put_second_row();
    bench.bench.core.drive(bench.row_read, 20, rtl::FifoRead{true, 7});
    bench.bench.core.drive(bench.row_read, 21, rtl::FifoRead{});
    bench.run();
    bench.violations.check_only("fifo/read", "composer_1_1.fifo.row_read", 20, -1);
}

}  // namespace metabuffer::test::fifo_monitor_test
