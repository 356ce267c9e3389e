#include "rtl/swap_lock.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "clocked_testbench.h"

namespace metabuffer::test {
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

bool bit(int pattern, int index) { return ((pattern >> index) & 1) != 0; }

TEST_CASE("swap lock: SWAPLOCK is high within the clock in which every FRAMEDONE is, and only then") {
    ClockedTestbench bench;
    std::vector<sc_core::sc_signal<bool>> framedone(kInputs);
    sc_core::sc_signal<bool> swaplock;
    SwapLock dut("swap_lock", kInputs);
    for (std::size_t i = 0; i < kInputs; ++i) dut.framedone_i[i](framedone[i]);
    dut.swaplock_o(swaplock);
    bench.trace(dut);
    const auto& locked = bench.core.record(swaplock);
    play_all_patterns(bench, [&](int i, bool level) { framedone[static_cast<std::size_t>(i)].write(level); });
    CHECK_FALSE(locked.at(-1));
    CHECK(locked.high() == std::vector<int>{15, 31});
}

TEST_CASE("swap lock: with one display it is that display's FRAMEDONE") {
    ClockedTestbench bench;
    sc_core::sc_signal<bool> framedone;
    sc_core::sc_signal<bool> swaplock;
    SwapLock dut("swap_lock", 1);
    dut.framedone_i[0](framedone);
    dut.swaplock_o(swaplock);
    bench.trace(dut);
    const auto& locked = bench.core.record(swaplock);
    bench.core.pulse(framedone, 5);
    bench.run_through(10);
    CHECK(locked.high() == std::vector<int>{5});
}

TEST_CASE("column stall: COLUMNSTALL is high within each clock in which any STALL is, and only then") {
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
}  // namespace metabuffer::test
