#include "rtl/swap_lock.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "clocked_testbench.h"

namespace metabuffer::test::swap_lock_test {
namespace {

using rtl::ColumnStall;
using rtl::SwapLock;

constexpr int kInputs = 4;

/// Counts through all input patterns, one a clock, twice over. What a recording holds at a clock is what
/// stood just before the next stimulus, so an output that follows its inputs within the clock shows at the
/// same clock.
template <typename Drive>
void play_all_patterns(ClockedTestbench& bench, Drive drive) {
    bench.core.each_clock([drive](int clock) {
        for (int i = 0; i < kInputs; ++i) drive(i, ((clock >> i) & 1) != 0);
    });
    bench.run_through(2 * (1 << kInputs));
}

struct SwapLockBench {
    std::vector<sc_core::sc_signal<bool>> framedone;
    std::vector<sc_core::sc_signal<bool>> framebad;
    sc_core::sc_signal<bool> swaplock;
    sc_core::sc_signal<bool> swapskip;
    SwapLock dut;
    const Recording<bool>& locked;
    const Recording<bool>& skipped;

    SwapLockBench(ClockedTestbench& bench, int displays)
        : framedone(static_cast<std::size_t>(displays)),
          framebad(static_cast<std::size_t>(displays)),
          dut("swap_lock", displays),
          locked(bench.core.record(swaplock)),
          skipped(bench.core.record(swapskip)) {
        for (std::size_t i = 0; i < framedone.size(); ++i) {
            dut.framedone_i[i](framedone[i]);
            dut.framebad_i[i](framebad[i]);
        }
        dut.swaplock_o(swaplock);
        dut.swapskip_o(swapskip);
        bench.trace(dut);
    }
};

bool bit(int pattern, int index) { return ((pattern >> index) & 1) != 0; }

TEST_CASE("swap lock: timing: SWAPLOCK is high within the clock in which every FRAMEDONE is") {
    ClockedTestbench bench;
    SwapLockBench dut(bench, kInputs);
    play_all_patterns(bench,
                      [&](int i, bool level) { dut.framedone[static_cast<std::size_t>(i)].write(level); });
    CHECK_FALSE(dut.locked.at(-1));
    CHECK(dut.locked.high() == std::vector<int>{15, 31});
    CHECK(dut.skipped.high().empty());
}

TEST_CASE("swap lock: SWAPSKIP is high within each clock in which any FRAMEBAD is, and only then") {
    ClockedTestbench bench;
    SwapLockBench dut(bench, kInputs);
    play_all_patterns(bench,
                      [&](int i, bool level) { dut.framebad[static_cast<std::size_t>(i)].write(level); });
    CHECK_FALSE(dut.skipped.at(-1));
    std::vector<int> wanted = clock_range(0, 33);
    wanted.erase(std::remove_if(wanted.begin(), wanted.end(), [](int clock) { return clock % 16 == 0; }),
                 wanted.end());
    CHECK(dut.skipped.high() == wanted);
    CHECK(dut.locked.high().empty());
}

TEST_CASE("swap lock: with one display they are that display's FRAMEDONE and FRAMEBAD") {
    ClockedTestbench bench;
    SwapLockBench dut(bench, 1);
    bench.core.pulse(dut.framedone[0], 5);
    bench.core.pulse(dut.framebad[0], 7);
    bench.run_through(10);
    CHECK(dut.locked.high() == std::vector<int>{5});
    CHECK(dut.skipped.high() == std::vector<int>{7});
}

TEST_CASE("column stall: timing: COLUMNSTALL is high within each clock in which any STALL is") {
    ClockedTestbench bench;
    std::vector<sc_core::sc_signal<bool>> stall(kInputs);
    sc_core::sc_signal<bool> column_stall;
    ColumnStall dut("column_stall", kInputs);
    for (std::size_t i = 0; i < kInputs; ++i) dut.stall_i[i](stall[i]);
    dut.column_stall_o(column_stall);
    bench.trace(dut);
    const auto& stalled = bench.core.record(column_stall);
    play_all_patterns(bench, [&](int i, bool level) { stall[static_cast<std::size_t>(i)].write(level); });
    std::vector<int> wanted;
    for (int clock = 0; clock <= 32; ++clock) {
        if (bit(clock, 0) || bit(clock, 1) || bit(clock, 2) || bit(clock, 3)) wanted.push_back(clock);
    }
    CHECK_FALSE(stalled.at(-1));
    CHECK(stalled.high() == wanted);
}

}  // namespace
}  // namespace metabuffer::test::swap_lock_test
