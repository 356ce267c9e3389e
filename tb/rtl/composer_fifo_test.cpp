#include "rtl/composer_fifo.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <deque>
#include <map>
#include <vector>

#include "clocked_testbench.h"
#include "datapath/composer_buffer.h"
#include "expected_report.h"
#include "support/random_seed.h"

namespace metabuffer::test::composer_fifo_test {
namespace {

using rtl::ComposerFifo;
using rtl::FifoRead;
using rtl::FifoRelease;
using rtl::FifoWrite;

constexpr std::uint64_t kTag = 0xA5A5'0000'0000'0000U;

struct FifoBench {
    ClockDomain& core;
    sc_core::sc_signal<FifoWrite> write;
    sc_core::sc_signal<FifoRead> read;
    sc_core::sc_signal<FifoRelease> release;
    sc_core::sc_signal<std::uint64_t> word;
    sc_core::sc_signal<std::uint32_t> free;
    ComposerFifo dut;
    const Recording<std::uint64_t>& words;  ///< what stands after each edge
    const Recording<std::uint32_t>& frees;

    FifoBench(ClockedTestbench& bench, int capacity)
        : core(bench.core), dut("fifo", capacity), words(core.record(word)), frees(core.record(free)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.write_i(write);
        dut.read_i(read);
        dut.release_i(release);
        dut.word_o(word);
        dut.free_o(free);
        bench.trace(dut);
    }
    /// Words first, first + 1, ... at one edge.
    void put(int clock, int address, int count, std::uint64_t first) {
        FifoWrite beat;
        beat.address = static_cast<std::uint32_t>(address);
        beat.count = static_cast<std::uint8_t>(count);
        for (int i = 0; i < count; ++i)
            beat.words[static_cast<std::size_t>(i)] = kTag + first + static_cast<unsigned>(i);
        core.drive(write, clock, beat);
        core.drive(write, clock + 1, FifoWrite{});
    }
    void get(int clock, int address) {
        core.drive(read, clock, FifoRead{true, static_cast<std::uint32_t>(address)});
        core.drive(read, clock + 1, FifoRead{});
    }
    void let_go(int clock, unsigned oldest, unsigned newest = 0) {
        core.drive(release, clock, FifoRelease{oldest, newest});
        core.drive(release, clock + 1, FifoRelease{});
    }
};

TEST_CASE("composer fifo: a word is read back at the edge that reads it, and stands until the next read") {
    ClockedTestbench bench;
    FifoBench dut(bench, 64);
    dut.put(2, 5, 8, 100);
    dut.get(4, 6);
    dut.get(9, 12);
    dut.get(10, 5);
    bench.run_through(40);
    CHECK(dut.words.at(3) == 0);
    for (int clock = 4; clock < 9; ++clock) CHECK(dut.words.at(clock) == kTag + 101);
    CHECK(dut.words.at(9) == kTag + 107);
    for (int clock = 10; clock <= 40; ++clock) CHECK(dut.words.at(clock) == kTag + 100);
}

TEST_CASE("composer fifo: a word that is written at the edge that reads it is read") {
    ClockedTestbench bench;
    FifoBench dut(bench, 64);
    dut.put(2, 0, 4, 10);
    for (int lane = 0; lane < 4; ++lane) {
        dut.put(10 + 4 * lane, 20, 4, 100 * static_cast<unsigned>(lane + 1));
        dut.get(10 + 4 * lane, 20 + lane);
        dut.let_go(11 + 4 * lane, 4);
    }
    // The word next to those of the beat is the old one.
    dut.put(40, 4, 4, 500);
    dut.get(40, 3);
    bench.run_through(44);
    for (int lane = 0; lane < 4; ++lane) {
        CHECK(dut.words.at(10 + 4 * lane) ==
              kTag + 100 * static_cast<unsigned>(lane + 1) + static_cast<unsigned>(lane));
    }
    CHECK(dut.words.at(40) == kTag + 13);
}

TEST_CASE("composer fifo: the first address follows the last one, within a beat too") {
    ClockedTestbench bench;
    FifoBench dut(bench, 20);  // 32 addresses
    dut.put(2, 29, 8, 1);
    for (int i = 0; i < 8; ++i) dut.get(4 + i, (29 + i) % 32);
    dut.put(20, 31, 3, 50);
    dut.get(20, 1);
    bench.run_through(24);
    for (int i = 0; i < 8; ++i) CHECK(dut.words.at(4 + i) == kTag + 1 + static_cast<unsigned>(i));
    CHECK(dut.words.at(20) == kTag + 52);
}

TEST_CASE("composer fifo: the free space follows what is written and released, until the FIFO is full") {
    ClockedTestbench bench;
    FifoBench dut(bench, 10);
    dut.put(2, 0, 8, 0);
    dut.let_go(3, 3);
    dut.put(4, 8, 5, 0);
    dut.let_go(5, 1, 4);  // the oldest, and four of a frame that is abandoned
    dut.put(8, 13, 2, 0);
    dut.let_go(8, 5);
    bench.run_through(12);
    CHECK(dut.frees.at(-1) == 10);
    CHECK(dut.frees.at(1) == 10);
    CHECK(dut.frees.at(2) == 2);
    CHECK(dut.frees.at(3) == 5);
    CHECK(dut.frees.at(4) == 0);
    CHECK(dut.frees.at(5) == 5);
    CHECK(dut.frees.at(8) == 8);
    CHECK(dut.frees.at(12) == 8);
}

TEST_CASE("composer fifo: a pixel may be released at the edge that brings it") {
    ClockedTestbench bench;
    FifoBench dut(bench, 4);
    dut.put(2, 0, 4, 0);
    dut.let_go(2, 4);
    bench.run_through(4);
    CHECK(dut.frees.at(2) == 4);
}

TEST_CASE("composer fifo: more pixels than are free are reported") {
    ExpectedReport report("/metabuffer/composer_fifo/full");
    ClockedTestbench bench;
    FifoBench dut(bench, 10);
    dut.put(2, 0, 8, 0);
    dut.put(4, 8, 3, 0);
    bench.run_through(6);
    CHECK(report.count() == 1);
}

TEST_CASE("composer fifo: a release of more than it holds is reported") {
    ExpectedReport report("/metabuffer/composer_fifo/empty");
    ClockedTestbench bench;
    FifoBench dut(bench, 10);
    dut.put(2, 0, 2, 0);
    dut.let_go(4, 2, 1);
    bench.run_through(6);
    CHECK(report.count() == 1);
}

TEST_CASE("composer fifo: a read at an address that it does not have is reported") {
    ExpectedReport report("/metabuffer/composer_fifo/address");
    ClockedTestbench bench;
    FifoBench dut(bench, 10);
    dut.get(3, 16);
    bench.run_through(6);
    CHECK(report.count() == 1);
}

TEST_CASE("composer fifo: a write to an address that it does not have is reported") {
    ExpectedReport report("/metabuffer/composer_fifo/address");
    ClockedTestbench bench;
    FifoBench dut(bench, 17);
    dut.put(3, 32, 1, 0);
    dut.put(5, 32, 0, 0);  // writes nothing
    bench.run_through(8);
    CHECK(report.count() == 1);
}

TEST_CASE("composer fifo: reset releases everything") {
    ClockedTestbench bench;
    FifoBench dut(bench, 10);
    dut.put(2, 0, 8, 40);
    dut.get(3, 2);
    bench.core.drive(bench.reset, 5, true);
    bench.core.drive(bench.reset, 6, false);
    dut.put(8, 0, 8, 60);
    dut.get(9, 2);
    bench.run_through(12);
    CHECK(dut.words.at(4) == kTag + 42);
    CHECK(dut.frees.at(5) == 10);
    CHECK(dut.words.at(5) == 0);
    CHECK(dut.frees.at(8) == 2);
    CHECK(dut.words.at(9) == kTag + 62);
}

TEST_CASE("composer fifo: its clock may stand still only while nothing is written, read or released") {
    ClockedTestbench bench;
    FifoBench dut(bench, 16);
    dut.put(4, 0, 2, 1);
    dut.get(8, 0);
    dut.let_go(12, 1);
    dut.let_go(16, 0, 1);
    dut.put(20, 2, 1, 3);
    bench.core.drive(bench.reset, 24, true);
    // A block that never sleeps is right too.
    for (const int clock : {4, 8, 12, 16, 20, 24}) {
        bench.run_through(clock - 1);
        INFO("clock " << clock);
        CHECK_FALSE(dut.dut.sleeps());
    }
}

TEST_CASE("composer fifo: under random use it agrees with a memory and a count at every clock") {
    const auto seed = random_seed(913);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kCapacity = 45;
    const int addresses = buffer_addresses(kCapacity);
    constexpr int kClocks = 3000;
    ClockedTestbench bench;
    FifoBench dut(bench, kCapacity);
    std::map<int, std::uint64_t> memory;
    std::deque<int> held;  // addresses, the oldest first
    std::vector<std::uint64_t> wanted_words;
    std::vector<std::uint32_t> wanted_frees;
    std::uint64_t word = 0;
    std::uint64_t next = 1;
    int write_address = 0;
    bool pause = false;
    for (int clock = 0; clock < kClocks; ++clock) {
        if (random.one_in(pause ? 12 : 60)) pause = !pause;  // long enough for the block to sleep
        FifoWrite write;
        FifoRead read;
        FifoRelease release;
        if (!pause) {
            const int count = std::min(random.between(0, 8), kCapacity - static_cast<int>(held.size()));
            write.count = static_cast<std::uint8_t>(random.one_in(2) ? count : 0);
            write.address = static_cast<std::uint32_t>(write_address);
            const int before = static_cast<int>(held.size());
            for (std::size_t i = 0; i < write.count; ++i) {
                write.words[i] = memory[write_address] = kTag + next++;
                held.push_back(write_address);
                write_address = (write_address + 1) % addresses;
            }
            if (!held.empty() && random.one_in(2)) {
                const auto place =
                    static_cast<std::size_t>(random.between(0, static_cast<int>(held.size()) - 1));
                read = {true, static_cast<std::uint32_t>(held[place])};
                word = memory[held[place]];
            }
            release.oldest = static_cast<std::uint32_t>(random.one_in(2) ? random.between(0, before) : 0);
            for (std::uint32_t i = 0; i < release.oldest; ++i) held.pop_front();
            if (random.one_in(40)) {
                release.newest = static_cast<std::uint32_t>(random.between(0, static_cast<int>(held.size())));
                for (std::uint32_t i = 0; i < release.newest; ++i) held.pop_back();
            }
        }
        dut.core.drive(dut.write, clock, write);
        dut.core.drive(dut.read, clock, read);
        dut.core.drive(dut.release, clock, release);
        wanted_words.push_back(word);
        wanted_frees.push_back(static_cast<std::uint32_t>(kCapacity - static_cast<int>(held.size())));
    }
    bench.run_through(kClocks);
    for (int clock = 0; clock < kClocks; ++clock) {
        INFO("clock " << clock);
        REQUIRE(dut.words.at(clock) == wanted_words[static_cast<std::size_t>(clock)]);
        REQUIRE(dut.frees.at(clock) == wanted_frees[static_cast<std::size_t>(clock)]);
    }
}

}  // namespace
}  // namespace metabuffer::test::composer_fifo_test
