#include "tlm/column_time.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "support/random_seed.h"

namespace metabuffer::test {
namespace {

using tlm::ColumnTime;
using tlm::FrameTime;
using tlm::kNoStep;
using tlm::kUnknownCycle;
using tlm::MinimumTree;

TEST_CASE("minimum tree: gives the smallest of its values whatever their number") {
    const auto seed = random_seed(511);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (int count = 1; count <= 40; ++count) {
        MinimumTree tree(static_cast<std::size_t>(count));
        std::vector<std::int64_t> values(static_cast<std::size_t>(count), kNoStep);
        CHECK(tree.minimum() == kNoStep);
        for (int i = 0; i < 200; ++i) {
            const auto index = static_cast<std::size_t>(random.between(0, count - 1));
            values[index] = random.one_in(5) ? kNoStep : random.between(0, 30);
            tree.set(index, values[index]);
            REQUIRE(tree.value(index) == values[index]);
            REQUIRE(tree.minimum() == *std::min_element(values.begin(), values.end()));
        }
    }
}

TEST_CASE("frame time: a step takes a clock and a stall is clocks without a step") {
    const auto seed = random_seed(512);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (int trial = 0; trial < 300; ++trial) {
        INFO("trial " << trial);
        // Each step is delayed to no earlier than some clock; the naive column takes them one by one.
        constexpr int kSteps = 60;
        const std::int64_t start = random.between(0, 50);
        FrameTime time;
        CHECK_FALSE(time.started());
        CHECK(time.step_at(1000) == -1);
        time.start(start);
        std::vector<std::int64_t> cycles = {start};
        for (std::int64_t step = 1; step < kSteps; ++step) {
            std::int64_t cycle = cycles.back() + 1;
            const int delays = random.one_in(4) ? random.between(1, 3) : 0;
            for (int i = 0; i < delays; ++i) {
                const std::int64_t wanted = cycle + random.between(-3, 6);
                REQUIRE(time.delay_step(step, wanted) == std::max<std::int64_t>(0, wanted - cycle));
                cycle = std::max(cycle, wanted);
            }
            cycles.push_back(cycle);
        }
        REQUIRE(time.start_cycle() == start);
        const std::int64_t last_known = random.one_in(2) ? kNoStep : random.between(0, kSteps - 1);
        time.set_last_known_step(last_known);
        for (std::int64_t step = 0; step < kSteps; ++step) {
            INFO("step " << step);
            REQUIRE(time.extrapolated_cycle(step) == cycles[static_cast<std::size_t>(step)]);
            REQUIRE(time.cycle_of(step) ==
                    (step <= last_known ? cycles[static_cast<std::size_t>(step)] : kUnknownCycle));
        }
        for (std::int64_t cycle = start - 3; cycle <= cycles.back(); ++cycle) {
            INFO("clock " << cycle);
            const std::int64_t step =
                std::upper_bound(cycles.begin(), cycles.end(), cycle) - cycles.begin() - 1;
            REQUIRE(time.step_at(cycle) == std::min(step, last_known));
        }
        time.start(7);
        REQUIRE(time.cycle_of(20) == 27);
    }
}

TEST_CASE(
    "column time: in stall mode only step 0 is known before the composers have reported what they need") {
    constexpr std::int64_t kStart = 100;
    ColumnTime stalling(2, 10, true);
    stalling.start(0, kStart);
    CHECK(stalling.frame(0).cycle_of(0) == kStart);
    CHECK(stalling.frame(0).cycle_of(1) == kUnknownCycle);
    stalling.set_needed_step(0, kNoStep);
    stalling.set_needed_step(1, 4);
    stalling.advance(kStart);
    CHECK(stalling.frame(0).cycle_of(4) == kStart + 4);
    CHECK(stalling.frame(0).cycle_of(5) == kUnknownCycle);

    ColumnTime steady(2, 10, false);
    steady.start(0, kStart);
    CHECK(steady.frame(0).cycle_of(5) == kStart + 5);
}

TEST_CASE("column time: in glitch mode a frame passes without a gap") {
    ColumnTime column(3, 100, false);
    CHECK_FALSE(column.started(0));
    CHECK(column.not_before(0, 30, 20) == 50);  // even if it starts now
    column.start(0, 50);
    CHECK(column.started(0));
    CHECK(column.frame(0).cycle_of(0) == 50);
    CHECK(column.frame(0).cycle_of(column.last_step()) == 153);
    column.note_composited();
    CHECK(column.composition(0).first == 51);  // of the top composer
    CHECK(column.composition(0).last == 152);  // of the bottom composer
    CHECK(column.stalled_cycles(1000) == 0);
}

TEST_CASE("column time: what waits for a step is called once and in the order of steps") {
    ColumnTime column(2, 50, true);
    std::vector<int> known;
    column.when_known(1, 0, [&known] { known.push_back(100); });
    column.when_known(0, 9, [&known] { known.push_back(9); });
    column.when_known(0, 0, [&known] { known.push_back(0); });
    column.when_known(0, 10, [&known] { known.push_back(10); });
    column.call_waiters();
    CHECK(known.empty());
    column.start(0, 30);
    column.set_needed_step(0, 9);
    column.set_needed_step(1, kNoStep);
    column.advance(28);
    column.call_waiters();
    CHECK(known == std::vector<int>{0, 9});  // step 9 waits for the pixel and is the last that is known
    column.set_needed_step(0, kNoStep);
    column.advance(28);
    column.call_waiters();
    CHECK(known == std::vector<int>{0, 9, 10});
    column.start(1, 300);
    column.call_waiters();
    CHECK(known == std::vector<int>{0, 9, 10, 100});
    column.call_waiters();
    CHECK(known.size() == 4);
}

TEST_CASE("column time: the column stands still from the step that needs a pixel to the pixel's arrival") {
    ColumnTime column(2, 50, true);
    column.start(0, 30);
    column.set_needed_step(0, kNoStep);
    column.set_needed_step(1, 9);
    column.advance(29);
    CHECK(column.frame(0).cycle_of(9) == 39);
    CHECK(column.frame(0).cycle_of(10) == kUnknownCycle);
    CHECK(column.not_before(0, 12, 60) == 42);
    // Not known yet, the stall counts up to the present: the STALL of clock 39 holds clock 40.
    CHECK(column.stalled_cycles(39) == 0);
    CHECK(column.stalled_cycles(40) == 1);
    CHECK(column.stalled_cycles_for(1, 45) == 6);
    CHECK(column.stalled_cycles_for(0, 45) == 0);
    // The pixel is sampled in clock 47: used in 48.
    column.add_arrival(1, 9, 47);
    column.set_needed_step(1, kNoStep);
    column.advance(45);
    CHECK(column.frame(0).cycle_of(9) == 39);
    CHECK(column.frame(0).cycle_of(10) == 48);
    CHECK(column.frame(0).step_at(46) == 9);
    CHECK(column.stalled_cycles(42) == 3);  // counted already beyond the present
    CHECK(column.stalled_cycles(100) == 8);
    CHECK(column.stalled_cycles_for(1, 100) == 8);
    CHECK(column.stalled_cycles_for(0, 100) == 0);
}

TEST_CASE("column time: two composers that wait for one clock each count it and the column counts it once") {
    ColumnTime column(3, 50, true);
    column.start(0, 30);
    column.add_arrival(0, 5, 40);
    column.add_arrival(2, 5, 44);
    for (int r = 0; r < 3; ++r) column.set_needed_step(r, kNoStep);
    column.advance(29);
    CHECK(column.frame(0).cycle_of(6) == 45);
    CHECK(column.stalled_cycles(100) == 9);
    CHECK(column.stalled_cycles_for(0, 100) == 5);
    CHECK(column.stalled_cycles_for(1, 100) == 0);
    CHECK(column.stalled_cycles_for(2, 100) == 9);
}

TEST_CASE(
    "column time: a composer that waits for a pixel on its way waits no longer than that when another waits "
    "on") {
    ColumnTime column(2, 50, true);
    column.start(0, 30);
    column.set_needed_step(0, 9);
    column.add_arrival(1, 9, 47);
    column.set_needed_step(1, kNoStep);
    column.advance(31);
    CHECK(column.frame(0).cycle_of(9) == 39);
    CHECK(column.frame(0).cycle_of(10) == kUnknownCycle);
    CHECK(column.stalled_cycles(45) == 6);
    CHECK(column.stalled_cycles_for(1, 45) == 6);
    CHECK(column.stalled_cycles(60) == 21);
    CHECK(column.stalled_cycles_for(0, 60) == 21);
    CHECK(column.stalled_cycles_for(1, 60) == 8);
}

TEST_CASE(
    "column time: a composer's first stall is its earliest that is known, and the step that it still needs "
    "may be "
    "one") {
    ColumnTime column(2, 50, true);
    const auto first_stalls = [&column] {
        return std::array<std::int64_t, 2>{column.first_stall_cycle(0), column.first_stall_cycle(1)};
    };
    const auto equal = [&](std::int64_t of_top, std::int64_t of_bottom) {
        return first_stalls() == std::array<std::int64_t, 2>{of_top, of_bottom};
    };
    CHECK(equal(kUnknownCycle, kUnknownCycle));
    column.start(0, 30);
    CHECK(equal(30, 30));
    column.set_needed_step(0, 9);
    column.set_needed_step(1, 12);
    CHECK(equal(39, kUnknownCycle));  // the other one needs its pixel later
    column.set_needed_step(0, kNoStep);
    column.set_needed_step(1, kNoStep);
    column.advance(31);
    CHECK(equal(kUnknownCycle, kUnknownCycle));  // no pixel was late
    column.start(1, 90);
    column.set_needed_step(0, 7);
    column.add_arrival(1, 5, 100);
    column.set_needed_step(1, kNoStep);
    column.advance(101);
    CHECK(equal(102, 95));
}

TEST_CASE("column time: stalls far in the past are forgotten and still counted") {
    constexpr int kStalls = 3000;
    ColumnTime column(1, 2 * kStalls, true);
    column.start(0, 10);
    std::int64_t cycle = 10;
    for (int i = 1; i <= kStalls; ++i) {
        // Every step waits two clocks for its pixel.
        column.set_needed_step(0, i);
        column.add_arrival(0, i - 1, cycle + 2);
        column.advance(cycle);
        column.advance(cycle);  // the stall that ends in the future is kept
        REQUIRE(column.stalled_cycles(cycle) == 2 * i - 2);
        REQUIRE(column.stalled_cycles(cycle + 1) == 2 * i - 1);
        cycle += 3;
        REQUIRE(column.frame(0).cycle_of(i) == cycle);
        REQUIRE(column.stalled_cycles(cycle) == 2 * i);
        REQUIRE(column.stalled_cycles_for(0, cycle - 2) == 2 * i - 1);
    }
}

}  // namespace
}  // namespace metabuffer::test
