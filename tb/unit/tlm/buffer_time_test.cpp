#include "tlm/buffer_time.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <utility>
#include <vector>

#include "support/rows.h"

namespace metabuffer::test {
namespace {

using tlm::BufferTime;
using tlm::ColumnTime;
using tlm::kNoStep;
using tlm::kUnknownCycle;
using tlm::SlotTime;

constexpr int kWidth = 8;
constexpr int kHeight = 2;

BufferTime::Config config_of(int capacity, int ready_space) {
    BufferTime::Config config;
    config.capacity_pixels = capacity;
    config.ready_space_pixels = ready_space;
    config.raster_width_pixels = kWidth;
    config.raster_height_pixels = kHeight;
    return config;
}

TEST_CASE("buffer time: a composer is prefetched when its table is known and it has no segment") {
    ColumnTime column(1, kWidth * kHeight, false);
    BufferTime buffer(config_of(4, 2), column);
    CHECK(buffer.prefetched_cycle(0) == kUnknownCycle);
    CHECK(buffer.table_cycle(0) == kUnknownCycle);
    buffer.begin_frame(0, nullptr, 17, 10);
    CHECK(buffer.prefetched_cycle(0) == 17);
    CHECK(buffer.segment(0) == nullptr);
    CHECK(buffer.slot_time(20, 10).cycle == 20);
}

TEST_CASE(
    "buffer time: a composer is prefetched by its last pixel or by the one that leaves no ready space") {
    ColumnTime column(1, kWidth * kHeight, false);
    const ViewportRow small = segment_row({3, 1});
    const ViewportRow large = segment_row({8, 2});
    BufferTime whole(config_of(8, 2), column);
    whole.begin_frame(0, &small, 10, 10);
    whole.add({0, 2, 11}, 11);
    CHECK(whole.prefetched_cycle(0) == kUnknownCycle);
    whole.add({2, 1, 20}, 20);
    CHECK(whole.prefetched_cycle(0) == 21);
    BufferTime full(config_of(8, 2), column);
    full.begin_frame(0, &large, 10, 10);
    full.add({0, 6, 11}, 11);  // 2 free: a slot would still be taken
    CHECK(full.prefetched_cycle(0) == kUnknownCycle);
    CHECK(full.slot_time(17, 11).cycle == 17);
    full.add({6, 1, 30}, 30);
    CHECK(full.prefetched_cycle(0) == 31);
}

TEST_CASE("buffer time: a slot is taken a clock after the last use that makes the ready space free") {
    ColumnTime column(1, kWidth * kHeight, false);
    const ViewportRow row = segment_row({8, 2});
    BufferTime buffer(config_of(8, 2), column);
    buffer.begin_frame(0, &row, 10, 10);
    buffer.add({0, 8, 11}, 11);
    const SlotTime unknown = buffer.slot_time(20, 11);
    CHECK(unknown.cycle == kUnknownCycle);
    CHECK(unknown.frame == 0);
    CHECK(unknown.step == 2);  // pixel 0 is composited in step 1 and pixel 1 in step 2
    column.start(0, 40);
    buffer.start_frame(0);
    CHECK(buffer.slot_time(20, 11).cycle == 43);
    CHECK(buffer.slot_time(50, 11).cycle == 50);
}

TEST_CASE("buffer time: BUSREADY is not asked in a burst whose rest fits one beat") {
    ColumnTime column(1, kWidth * kHeight, false);
    const ViewportRow row = segment_row({8, 2});
    BufferTime::Config config = config_of(8, 4);
    config.pixels_per_beat = 2;
    config.in_flight_pixels = 4;
    BufferTime buffer(config, column);
    buffer.begin_frame(0, &row, 10, 10);
    buffer.add({0, 8, 11}, 11);
    using Verdict = BufferTime::Verdict;
    CHECK(buffer.busready_in_burst({8, 15, 2}, 16) == Verdict::kTaken);
    CHECK(buffer.busready_in_burst({8, 15, 3}, 16) == Verdict::kDropped);
    CHECK(buffer.busready_in_burst({5, 15, 3}, 16) == Verdict::kTaken);    // 3 free for the 3 that are left
    CHECK(buffer.busready_in_burst({5, 15, 9}, 16) == Verdict::kDropped);  // two beats need 4
    CHECK(buffer.busready_in_burst({4, 15, 9}, 16) == Verdict::kTaken);
    // The column may have begun by the beat's clock, unless that has passed.
    CHECK(buffer.busready_in_burst({8, 15, 3}, 15) == Verdict::kUndecided);
}

TEST_CASE("buffer time: a pixel sampled in the clock of its use starves and is late if that was its last") {
    for (const std::int64_t first_cycle : {54, 55}) {
        ColumnTime column(1, kWidth * kHeight, false);
        const ViewportRow row = segment_row({8, 1});
        BufferTime buffer(config_of(8, 2), column);
        buffer.begin_frame(0, &row, 10, 10);
        buffer.add({0, 7, 11}, 11);  // no slot is left: prefetched
        column.start(0, 48);         // pixel 7 is used in clock 48 + 1 + 7
        buffer.start_frame(0);
        buffer.add({7, 1, first_cycle}, first_cycle);  // sampled a clock later
        buffer.close_frame(0, kWidth * kHeight, 64);
        const ComposerCounters counters = buffer.finish(100, 0);
        CHECK(counters.starved_pixels == (first_cycle == 55 ? 1 : 0));
        CHECK(counters.late_pixels == (first_cycle == 55 ? 1 : 0));
        CHECK(counters.buffer_high_water == 7);
    }
}

TEST_CASE("buffer time: levels are reported before and after each run of beats") {
    ColumnTime column(1, kWidth * kHeight, false);
    const ViewportRow row = segment_row({8, 2});
    BufferTime buffer(config_of(32, 2), column);
    using Levels = std::vector<std::pair<std::int64_t, int>>;
    Levels levels;
    buffer.on_level([&levels](std::int64_t cycle, int held) { levels.emplace_back(cycle, held); });
    buffer.begin_frame(0, &row, 10, 10);
    buffer.add({0, 4, 11}, 11);  // sampled in clocks 12 to 15
    buffer.add({4, 8, 30}, 30);
    buffer.finish(100, 0);
    CHECK(levels == Levels{{11, 0}, {15, 4}, {30, 4}, {38, 12}});
}

TEST_CASE("buffer time: levels fall to zero after a frame, though the next one's table has come") {
    ColumnTime column(1, kWidth * kHeight, false);
    const ViewportRow row = segment_row({8, 2});
    BufferTime buffer(config_of(32, 2), column);
    std::vector<std::pair<std::int64_t, int>> levels;
    buffer.on_level([&levels](std::int64_t cycle, int held) { levels.emplace_back(cycle, held); });
    buffer.begin_frame(0, &row, 10, 10);
    buffer.add({0, 16, 11}, 11);
    column.start(0, 40);
    buffer.start_frame(0);
    buffer.begin_frame(1, &row, 45, 45);
    buffer.close_frame(0, kWidth * kHeight, 70);
    REQUIRE_FALSE(levels.empty());
    // The frame's last pixel is composited in clock 40 + 16.
    CHECK(levels.back().first >= 56);
    CHECK(levels.back().second == 0);
}

TEST_CASE("buffer time: pixels held are counted when it is known what of the frame before has been used") {
    ColumnTime column(2, kWidth * kHeight, true);
    const ViewportRow row = segment_row({8, 1});
    BufferTime::Config config = config_of(16, 2);
    config.renderer = 1;
    BufferTime buffer(config, column);
    buffer.begin_frame(0, &row, 10, 10);
    buffer.add({0, 8, 11}, 11);
    column.start(0, 40);
    buffer.start_frame(0);
    column.set_needed_step(0, 5);  // the other composer's next pixel may come late
    column.advance(40);
    buffer.begin_frame(1, &row, 42, 42);
    buffer.add({0, 6, 48}, 48);  // sampled in clocks 49 to 54
    buffer.add({6, 1, 60}, 52);
    // That pixel is sampled in clock 53. So step 6 is in clock 54, and uses the fifth pixel.
    column.add_arrival(0, 5, 53);
    column.set_needed_step(0, kNoStep);
    column.advance(52);
    CHECK(buffer.finish(100, 0).buffer_high_water == 6 + 8 - 5);
}

TEST_CASE("buffer time: a drop of BUSREADY after the end of the run has not happened") {
    ColumnTime column(1, kWidth * kHeight, false);
    BufferTime buffer(config_of(8, 2), column);
    buffer.begin_frame(0, nullptr, 10, 10);
    buffer.count_drop(30);
    buffer.count_drop(41);
    CHECK(buffer.finish(40, 3).busready_drops == 1);
}

}  // namespace
}  // namespace metabuffer::test
