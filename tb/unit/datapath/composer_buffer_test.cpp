#include "datapath/composer_buffer.h"

#include <catch2/catch.hpp>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <vector>

#include "formats/pixel.h"
#include "support/painted_segment.h"
#include "support/random_seed.h"
#include "unit/datapath/part_state.h"

namespace metabuffer::composer_buffer_test {
namespace {

constexpr int kWidth = 12;
constexpr int kHeight = 8;
constexpr test::Size kRaster{kWidth, kHeight};

/// A buffer with the memory that it gives addresses for.
class StoredBuffer : public ComposerBuffer {
  public:
    StoredBuffer(int capacity_pixels, int raster_width_pixels, int raster_height_pixels)
        : ComposerBuffer(capacity_pixels, raster_width_pixels, raster_height_pixels),
          memory_(static_cast<std::size_t>(buffer_addresses(capacity_pixels))) {}
    bool push(Pixel pixel) {
        const auto address = static_cast<std::size_t>(write_address());
        const bool kept = ComposerBuffer::push();
        if (kept) memory_[address] = pixel;
        return kept;
    }
    int addresses() const { return static_cast<int>(memory_.size()); }
    /// Of pixel k of the oldest frame: one that has arrived and is not released, of a frame that is not abandoned.
    int address_of(std::int64_t k) const { return buffer_address(base_address(), k, addresses()); }
    Pixel stored(std::int64_t k) const { return memory_[static_cast<std::size_t>(address_of(k))]; }

  private:
    std::vector<Pixel> memory_;
};

ViewportRow row_of(int sdx, int sdy, int multiple = 1) { return test::segment_row({sdx, sdy}, {}, multiple); }

void begin(StoredBuffer& buffer, const ViewportRow& row) {
    buffer.begin_frame();
    buffer.set_row(row);
    buffer.end_table();
}

Pixel numbered(std::int64_t n) { return Pixel(static_cast<std::uint64_t>(n) + 1); }

TEST_CASE("composer buffer: a new one is empty, has no frame and takes two tables") {
    StoredBuffer buffer(4, kWidth, kHeight);
    CHECK(buffer.capacity_pixels() == 4);
    CHECK(buffer.free_pixels() == 4);
    CHECK(buffer.held_pixels() == 0);
    CHECK_FALSE(buffer.table_complete());
    CHECK_FALSE(buffer.has_segment());
    CHECK(buffer.can_begin_frame());
    buffer.begin_frame();
    CHECK(buffer.can_begin_frame());
    buffer.begin_frame();
    CHECK_FALSE(buffer.can_begin_frame());
    CHECK_THROWS_AS(buffer.begin_frame(), std::logic_error);
}

TEST_CASE(
    "composer buffer: a frame has no segment until its row comes, and no complete table until the end is "
    "signalled") {
    StoredBuffer buffer(4, kWidth, kHeight);
    buffer.begin_frame();
    CHECK_FALSE(buffer.table_complete());
    CHECK_FALSE(buffer.has_segment());
    CHECK(buffer.segment_complete());  // without a segment no pixel is to come
    buffer.set_row(row_of(2, 1));
    CHECK(buffer.has_segment());
    CHECK_FALSE(buffer.segment_complete());
    CHECK_FALSE(buffer.table_complete());
    buffer.end_table();
    CHECK(buffer.table_complete());
}

TEST_CASE("composer buffer: it can be filled completely and not beyond") {
    StoredBuffer buffer(3, kWidth, kHeight);
    begin(buffer, row_of(5, 1));
    for (int k = 0; k < 3; ++k) {
        CHECK(buffer.push(numbered(k)));
        CHECK(buffer.held_pixels() == k + 1);
    }
    CHECK(buffer.free_pixels() == 0);
    CHECK_THROWS_AS(buffer.push(numbered(3)), std::logic_error);
}

TEST_CASE("composer buffer: a pixel that comes after its release is dropped, the next one is kept") {
    StoredBuffer buffer(3, kWidth, kHeight);
    begin(buffer, row_of(5, 1));
    buffer.push(numbered(0));
    buffer.release_through(0);
    buffer.release_through(1);  // composited without pixels 1 and 2
    buffer.release_through(2);
    CHECK(buffer.held_pixels() == 0);
    CHECK_FALSE(buffer.push(numbered(1)));
    CHECK_FALSE(buffer.push(numbered(2)));
    CHECK(buffer.held_pixels() == 0);
    CHECK(buffer.push(numbered(3)));
    CHECK(buffer.held_pixels() == 1);
    CHECK(buffer.stored(3) == numbered(3));
}

TEST_CASE("composer buffer: a release frees all pixels up to it, whether they have come or not") {
    StoredBuffer buffer(6, kWidth, kHeight);
    begin(buffer, row_of(6, 1));
    for (int k = 0; k < 4; ++k) buffer.push(numbered(k));
    buffer.release_through(2);
    CHECK(buffer.held_pixels() == 1);
    buffer.release_through(4);
    CHECK(buffer.held_pixels() == 0);
    CHECK_FALSE(buffer.push(numbered(4)));
    CHECK(buffer.push(numbered(5)));
    CHECK(buffer.held_pixels() == 1);
}

TEST_CASE("composer buffer: pixels that still come of a frame that is over are dropped") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(2, 2));
    buffer.push(numbered(0));
    for (int k = 0; k < 4; ++k) buffer.release_through(k);
    buffer.end_frame();
    CHECK_FALSE(buffer.push(numbered(1)));
    CHECK_FALSE(buffer.push(numbered(2)));
    CHECK_FALSE(buffer.push(numbered(3)));
    begin(buffer, row_of(1, 1));
    CHECK(buffer.push(numbered(50)));
    CHECK(buffer.stored(0) == numbered(50));
}

TEST_CASE("composer buffer: a loss abandons its frame: nothing of it is held, kept or waited for") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(10, 1));
    for (int k = 0; k < 3; ++k) buffer.push(numbered(k));
    buffer.release_through(0);
    REQUIRE(buffer.held_pixels() == 2);
    CHECK(buffer.next_pixel() == std::int64_t{3});
    CHECK(buffer.missing_pixels() == 7);
    CHECK(buffer.keeps_next());
    CHECK_FALSE(buffer.abandoned());
    CHECK_FALSE(buffer.segment_complete());
    buffer.lose(2);
    CHECK(buffer.abandoned());
    CHECK(buffer.abandoning());
    CHECK(buffer.segment_complete());
    CHECK(buffer.held_pixels() == 0);
    CHECK(buffer.next_pixel() == std::int64_t{5});
    CHECK(buffer.missing_pixels() == 5);
    CHECK_FALSE(buffer.keeps_next());
    for (int k = 5; k < 9; ++k) CHECK_FALSE(buffer.push(numbered(k)));
    CHECK(buffer.held_pixels() == 0);
    CHECK(buffer.missing_pixels() == 1);
    buffer.release_through(6);
    buffer.release_through(9);
    CHECK(buffer.held_pixels() == 0);
    buffer.push(numbered(9));
    CHECK(buffer.missing_pixels() == 0);
    buffer.end_frame();
    CHECK_FALSE(buffer.next_pixel().has_value());  // it was whole
}

TEST_CASE("composer buffer: a second loss in a frame frees nothing twice") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(2, 1));
    buffer.push(numbered(0));
    buffer.push(numbered(1));
    begin(buffer, row_of(10, 1));
    buffer.push(numbered(10));
    REQUIRE(buffer.held_pixels() == 3);
    buffer.lose(1);
    CHECK(buffer.held_pixels() == 2);
    buffer.push(numbered(12));
    buffer.lose(3);
    CHECK(buffer.held_pixels() == 2);
    CHECK(buffer.next_pixel() == std::int64_t{6});
    // The frame that is composited is whole and stays so.
    CHECK_FALSE(buffer.abandoned());
    CHECK(buffer.stored(0) == numbered(0));
    CHECK(buffer.stored(1) == numbered(1));
    buffer.release_through(1);
    buffer.end_frame();
    CHECK(buffer.abandoned());
    CHECK(buffer.held_pixels() == 0);
}

TEST_CASE("composer buffer: lost pixels that were used without having come free nothing") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(10, 1));
    buffer.push(numbered(0));
    buffer.release_through(4);
    buffer.lose(2);  // 1 and 2; the frame is at 5 already
    CHECK(buffer.held_pixels() == 0);
    CHECK(buffer.next_pixel() == std::int64_t{3});
}

TEST_CASE("composer buffer: the frame after an abandoned one is kept apart and found where it was stored") {
    for (int lost = 1; lost < 12; ++lost) {
        INFO(lost << " pixels lost");
        StoredBuffer buffer(5, kWidth, kHeight);
        begin(buffer, row_of(12, 1));
        buffer.push(numbered(0));
        buffer.lose(lost);
        begin(buffer, row_of(5, 1));
        CHECK_FALSE(buffer.abandoning());
        CHECK(buffer.next_pixel() == std::int64_t{0});
        for (int k = 0; k < 5; ++k) CHECK(buffer.push(numbered(100 + k)));
        CHECK(buffer.held_pixels() == 5);
        buffer.end_frame();
        CHECK_FALSE(buffer.abandoned());
        CHECK(buffer.segment_complete());
        for (int k = 0; k < 5; ++k) CHECK(buffer.stored(k) == numbered(100 + k));
    }
}

TEST_CASE("composer buffer: losses in a frame that is over are known, and abandon no other frame") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(6, 1));
    buffer.push(numbered(0));
    buffer.release_through(5);
    buffer.end_frame();
    CHECK(buffer.next_pixel() == std::int64_t{1});
    CHECK_FALSE(buffer.push(numbered(1)));
    CHECK(buffer.missing_pixels() == 4);
    buffer.lose(2);
    CHECK_FALSE(buffer.abandoning());  // it is over: what still comes of it is late
    CHECK(buffer.next_pixel() == std::int64_t{4});
    CHECK(buffer.missing_pixels() == 2);
    buffer.lose(2);
    CHECK(buffer.missing_pixels() == 0);
    CHECK(buffer.held_pixels() == 0);
    begin(buffer, row_of(2, 1));
    CHECK_FALSE(buffer.abandoned());
    CHECK(buffer.next_pixel() == std::int64_t{0});
    CHECK(buffer.push(numbered(50)));
    CHECK(buffer.stored(0) == numbered(50));
}

TEST_CASE("composer buffer: an abandoned frame stays abandoned when it is over") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(6, 1));
    buffer.lose(2);
    buffer.release_through(5);
    buffer.end_frame();
    CHECK_FALSE(buffer.has_frame());
    CHECK(buffer.abandoning());
    CHECK(buffer.next_pixel() == std::int64_t{2});
    CHECK_FALSE(buffer.push(numbered(2)));
    CHECK(buffer.missing_pixels() == 3);
}

TEST_CASE("composer buffer: a frame that was missed takes its turn, has no segment and is not waited for") {
    StoredBuffer buffer(8, kWidth, kHeight);
    begin(buffer, row_of(2, 1));
    CHECK(buffer.frames_heard() == 1);
    CHECK(buffer.wants_frame());
    CHECK_FALSE(buffer.table_lost());
    buffer.push(numbered(0));
    buffer.push(numbered(1));
    buffer.miss_frame();
    CHECK(buffer.frames_heard() == 2);
    CHECK_FALSE(buffer.wants_frame());
    CHECK(buffer.can_begin_frame());  // there is room for the one after it
    CHECK(buffer.table_lost());
    CHECK_FALSE(buffer.next_pixel().has_value());
    CHECK(buffer.missing_pixels() == 0);
    begin(buffer, row_of(3, 1));
    CHECK_FALSE(buffer.table_lost());
    CHECK(buffer.frames_heard() == 3);
    CHECK(buffer.next_pixel() == 0);
    buffer.push(numbered(10));
    CHECK(buffer.held_pixels() == 3);

    CHECK(buffer.has_segment());
    CHECK_FALSE(buffer.abandoned());
    CHECK(buffer.stored(1) == numbered(1));
    buffer.release_through(1);
    buffer.end_frame();

    CHECK(buffer.has_frame());
    CHECK(buffer.table_complete());
    CHECK_FALSE(buffer.has_segment());
    CHECK(buffer.segment_complete());
    CHECK(buffer.abandoned());
    CHECK_FALSE(buffer.wants_frame());
    buffer.push(numbered(11));  // of the frame after it
    buffer.end_frame();

    CHECK(buffer.wants_frame());
    CHECK(buffer.has_segment());
    CHECK_FALSE(buffer.abandoned());
    CHECK_FALSE(buffer.segment_complete());
    CHECK(buffer.has_arrived(1));
    CHECK_FALSE(buffer.has_arrived(2));
    CHECK(buffer.stored(1) == numbered(11));
    buffer.push(numbered(12));
    buffer.release_through(2);
    buffer.end_frame();
    CHECK_FALSE(buffer.has_frame());
    CHECK_FALSE(buffer.table_complete());
    CHECK(buffer.held_pixels() == 0);
}

TEST_CASE("composer buffer: a frame that was missed lacks no pixels, whatever the one before it lacks") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(2, 1));
    CHECK(buffer.missing_pixels() == 2);
    buffer.miss_frame();
    CHECK(buffer.missing_pixels() == 0);
}

TEST_CASE("composer buffer: several frames missed with none before and none after them") {
    StoredBuffer buffer(4, kWidth, kHeight);
    for (int frame = 0; frame < 3; ++frame) buffer.miss_frame();
    for (int frame = 0; frame < 3; ++frame) {
        CHECK(buffer.has_frame());
        CHECK(buffer.table_complete());
        CHECK(buffer.abandoned());
        CHECK(buffer.wants_frame() == (frame == 2));
        buffer.end_frame();
    }
    CHECK_FALSE(buffer.has_frame());
    CHECK_FALSE(buffer.abandoned());
    CHECK(buffer.table_lost());  // pixels of the last one may still come
    begin(buffer, row_of(1, 1));
    CHECK(buffer.has_segment());
    CHECK_FALSE(buffer.abandoned());
}

TEST_CASE("composer buffer: a frame whose table is lost keeps its turn and loses its segment") {
    StoredBuffer buffer(8, kWidth, kHeight);
    begin(buffer, row_of(2, 1));
    buffer.push(numbered(0));
    CHECK_FALSE(buffer.table_open());
    buffer.begin_frame();
    CHECK(buffer.table_open());
    buffer.set_row(row_of(3, 2));
    buffer.lose_table();
    CHECK_FALSE(buffer.table_open());
    CHECK(buffer.table_lost());
    CHECK_FALSE(buffer.can_begin_frame());
    CHECK(buffer.missing_pixels() == 0);
    CHECK(buffer.held_pixels() == 1);
    CHECK_FALSE(buffer.abandoned());
    buffer.release_through(1);
    buffer.end_frame();
    CHECK(buffer.table_complete());
    CHECK(buffer.abandoned());
    CHECK_FALSE(buffer.has_segment());
    CHECK(buffer.segment_complete());
    buffer.end_frame();
    CHECK(buffer.table_lost());
    CHECK_FALSE(buffer.next_pixel().has_value());
    CHECK_FALSE(buffer.has_frame());
}

TEST_CASE("composer buffer: pixels of a frame that is over do not come once a later frame is known") {
    StoredBuffer buffer(4, kWidth, kHeight);
    begin(buffer, row_of(2, 1));
    buffer.release_through(1);
    buffer.end_frame();
    CHECK(buffer.missing_pixels() == 2);
    buffer.lose(2);
    buffer.miss_frame();
    CHECK_FALSE(buffer.next_pixel().has_value());
    begin(buffer, row_of(2, 1));
    CHECK(buffer.next_pixel() == 0);
    CHECK(buffer.push(numbered(5)));
}

TEST_CASE("composer buffer: the end of a frame that is not known changes nothing") {
    StoredBuffer buffer(4, kWidth, kHeight);
    buffer.end_frame();
    CHECK_FALSE(buffer.has_frame());
    begin(buffer, row_of(1, 1));
    CHECK(buffer.has_segment());
    CHECK_FALSE(buffer.abandoned());
    buffer.lose(1);
    buffer.end_frame();
    begin(buffer, row_of(1, 1));
    buffer.push(numbered(0));
    buffer.end_frame();
    CHECK_FALSE(buffer.abandoned());  // nor does it have the state of the frame that is over
}

TEST_CASE("composer buffer: the next frame's pixels do not count for the one that is composited") {
    StoredBuffer buffer(6, kWidth, kHeight);
    begin(buffer, row_of(2, 1));
    buffer.push(numbered(0));
    buffer.push(numbered(1));
    begin(buffer, row_of(3, 1));
    buffer.push(numbered(100));
    buffer.push(numbered(101));
    CHECK(buffer.held_pixels() == 4);
    CHECK(buffer.segment_complete());
    CHECK(buffer.segment().pixels() == 2);
    CHECK_FALSE(buffer.has_arrived(2));
    buffer.release_through(0);
    buffer.release_through(1);
    buffer.end_frame();
    CHECK(buffer.held_pixels() == 2);
    CHECK(buffer.segment().pixels() == 3);
    CHECK_FALSE(buffer.segment_complete());
    CHECK(buffer.has_arrived(1));
    CHECK_FALSE(buffer.has_arrived(2));
    CHECK(buffer.stored(0) == numbered(100));
    CHECK(buffer.stored(1) == numbered(101));
}

TEST_CASE("composer buffer: a waveform shows each frame's account, under the place that the frame has") {
    StoredBuffer buffer(16, kWidth, kHeight);
    const auto show = [&buffer] { return test::PartState(buffer); };
    begin(buffer, row_of(3, 1));
    for (int k = 0; k < 3; ++k) buffer.push(numbered(k));
    CHECK(show()["frames"] == 1);
    CHECK(show()["head"] == 0);
    CHECK(show()["frame_0_number"] == 0);
    CHECK(show()["frame_0_has_segment"] == 1);
    CHECK(show()["frame_0_table_complete"] == 1);
    CHECK(show()["frame_0_abandoned"] == 0);
    CHECK(show()["frame_0_arrived"] == 3);
    CHECK(show()["frame_0_released"] == 0);
    CHECK(show()["frame_0_base_address"] == 0);
    buffer.begin_frame();
    CHECK(show()["frames"] == 2);
    CHECK(show()["frames_heard"] == 2);
    CHECK(show()["frame_1_number"] == 1);
    CHECK(show()["frame_1_has_segment"] == 0);
    CHECK(show()["frame_1_table_complete"] == 0);
    CHECK(show()["frame_1_base_address"] == 3);
    buffer.set_row(row_of(4, 1));
    buffer.end_table();
    buffer.push(numbered(10));
    buffer.release_through(1);
    CHECK(show()["frame_0_arrived"] == 3);
    CHECK(show()["frame_0_released"] == 2);
    CHECK(show()["frame_1_arrived"] == 1);
    CHECK(show()["frame_1_table_complete"] == 1);
    CHECK(show()["held"] == 2);
    CHECK(show()["write_address"] == 4);
    buffer.end_frame();
    CHECK(show()["head"] == 1);
    CHECK(show()["frames_composited"] == 1);
    buffer.lose(2);
    CHECK(show()["frame_1_abandoned"] == 1);
    CHECK(show()["receiving_ended_frame"] == 0);
    buffer.end_frame();
    CHECK(show()["receiving_ended_frame"] == 1);
    CHECK(show()["ended_number"] == 1);
    CHECK(show()["ended_arrived"] == 3);
}

// ---- against a buffer without addresses ----

/// Each frame holds its pixels by their index in a map; nothing wraps.
class MapBuffer {
  public:
    struct Frame {
        bool complete = false;
        bool has_row = false;
        std::int64_t pixels = 0;
        std::int64_t arrived = 0;
        std::int64_t released = 0;
        std::map<std::int64_t, Pixel> held;
    };

    void begin_frame() {
        frames_.push_back(std::make_shared<Frame>());
        receiving_ = frames_.back();
    }
    std::shared_ptr<Frame> receiving() const { return receiving_; }
    std::shared_ptr<Frame> head() const { return frames_.empty() ? nullptr : frames_.front(); }
    std::size_t frames() const { return frames_.size(); }
    bool push(Pixel pixel) {
        const std::int64_t k = receiving_->arrived++;
        if (k < receiving_->released) return false;
        receiving_->held[k] = pixel;
        return true;
    }
    void release() {
        head()->held.erase(head()->released);
        ++head()->released;
    }
    void end_frame() { frames_.pop_front(); }
    int held() const {
        std::size_t sum = 0;
        for (const auto& frame : frames_) sum += frame->held.size();
        return static_cast<int>(sum);
    }

  private:
    std::deque<std::shared_ptr<Frame>> frames_;
    std::shared_ptr<Frame> receiving_;  ///< the newest, even if it is over
};

void check_same(const StoredBuffer& buffer, const MapBuffer& wanted) {
    REQUIRE(buffer.held_pixels() == wanted.held());
    REQUIRE(buffer.free_pixels() == buffer.capacity_pixels() - wanted.held());
    REQUIRE(buffer.can_begin_frame() == (wanted.frames() < 2));
    const auto head = wanted.head();
    REQUIRE(buffer.table_complete() == (head != nullptr && head->complete));
    REQUIRE(buffer.has_segment() == (head != nullptr && head->has_row));
    if (head == nullptr || !head->has_row) return;
    REQUIRE(buffer.segment_complete() == (head->arrived == head->pixels));
    for (std::int64_t k = 0; k < head->pixels; ++k) REQUIRE(buffer.has_arrived(k) == (k < head->arrived));
    std::set<int> addresses;
    for (const auto& [k, pixel] : head->held) {
        const int address = buffer.address_of(k);
        REQUIRE(address >= 0);
        REQUIRE(address < buffer.addresses());
        REQUIRE(addresses.insert(address).second);
        REQUIRE(buffer.stored(k) == pixel);
    }
}

/// Plays tables, pixels, releases and frame ends in a random order that the protocol allows.
void play(test::Random& random, int capacity, int steps) {
    StoredBuffer buffer(capacity, kWidth, kHeight);
    MapBuffer wanted;
    std::int64_t number = 0;
    std::int64_t to_come = 0;  // pixels of the frame that is received
    for (int step = 0; step < steps; ++step) {
        INFO("step " << step);
        const auto head = wanted.head();
        switch (random.between(0, 3)) {
            case 0:  // the bus: a table, when the frame before has been sent
                if (to_come > 0 || wanted.frames() == 2) break;
                buffer.begin_frame();
                wanted.begin_frame();
                check_same(buffer, wanted);
                if (!random.one_in(5)) {
                    const ViewportRow row = test::random_valid_row(random, kRaster, 3);
                    buffer.set_row(row);
                    wanted.receiving()->has_row = true;
                    wanted.receiving()->pixels = to_come = std::int64_t{row.sdx} * row.sdy;
                    check_same(buffer, wanted);
                }
                buffer.end_table();
                wanted.receiving()->complete = true;
                break;
            case 1:  // the bus: some pixels
                for (int i = random.between(1, 8); i > 0 && to_come > 0; --i) {
                    const bool late = wanted.receiving()->arrived < wanted.receiving()->released;
                    if (wanted.held() == capacity && !late) {
                        REQUIRE_THROWS_AS(StoredBuffer(buffer).push(numbered(number)), std::logic_error);
                        break;
                    }
                    REQUIRE(buffer.push(numbered(number)) == wanted.push(numbered(number)));
                    ++number;
                    --to_come;
                    check_same(buffer, wanted);
                }
                break;
            case 2:  // the pipeline: releases pixels, whether they have come or not
                if (head == nullptr || !head->complete) break;
                for (int i = random.between(1, 8); i > 0 && head->released < head->pixels; --i) {
                    // Mostly it releases pixels that have come; starving is the exception.
                    if (head->released >= head->arrived && !random.one_in(20)) break;
                    buffer.release_through(head->released);
                    wanted.release();
                    check_same(buffer, wanted);
                }
                break;
            default:  // the pipeline: the raster is finished
                if (head == nullptr || !head->complete || head->released < head->pixels) break;
                buffer.end_frame();
                wanted.end_frame();
                break;
        }
        check_same(buffer, wanted);
    }
    REQUIRE(number > steps / 10);
}

TEST_CASE("composer buffer: agrees with a buffer without addresses under random use, at any capacity") {
    const auto seed = test::random_seed(132);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (const int capacity : {1, 2, 3, 7, 16, 64, 200}) {
        INFO("capacity " << capacity);
        play(random, capacity, 3000);
    }
}

TEST_CASE(
    "composer buffer: with the walker's releases it never holds a pixel longer than painting needs it") {
    const auto seed = test::random_seed(133);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 200; ++trial) {
        const ViewportRow row = test::random_valid_row(random, kRaster, 4);
        INFO("trial " << trial << ": sdx " << row.sdx << ", sdy " << row.sdy << ", dx " << row.dx << ", dy "
                      << row.dy << ", multiple " << row.dmultiple);
        const test::PaintedSegment painted(row, kRaster);
        const auto pixels = static_cast<std::int64_t>(painted.last.size());
        StoredBuffer buffer(static_cast<int>(pixels), kWidth, kHeight);
        begin(buffer, row);
        for (std::int64_t k = 0; k < pixels; ++k) buffer.push(numbered(k));
        SegmentWalker walker(buffer.segment(), true, kWidth, kHeight);
        for (std::int64_t position = 0; position < kWidth * kHeight; ++position) {
            const std::int64_t k = painted.owner(position);
            if (k != test::PaintedSegment::kNone) {
                REQUIRE(buffer.stored(walker.pixel()) == numbered(k));
            }
            if (walker.covered() && walker.last_use()) buffer.release_through(walker.pixel());
            walker.advance();
            std::int64_t needed = 0;
            for (const std::int64_t last : painted.last) needed += last > position ? 1 : 0;
            REQUIRE(buffer.held_pixels() == needed);
        }
    }
}

}  // namespace
}  // namespace metabuffer::composer_buffer_test
