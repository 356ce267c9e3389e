#include "datapath/composer_buffer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
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

/// A buffer that keeps each frame's pixels by their index, in a map. It knows every frame there has been.
struct NaiveBuffer {
    struct Frame {
        int entry = 0;        ///< in the buffer, of a frame that has begun
        bool missed = false;  ///< it has not begun
        bool complete = false, lost_table = false, abandoned = false;
        bool whole_at_end = false;  ///< all pixels had come when it was over
        std::optional<ViewportRow> row;
        std::int64_t arrived = 0, released = 0;
        int base = 0;  ///< address of pixel 0
        std::map<std::int64_t, Pixel> held;

        std::int64_t pixels() const { return row ? std::int64_t{row->sdx} * row->sdy : 0; }
        bool whole() const { return arrived >= pixels(); }
    };

    int capacity, addresses;
    std::vector<Frame> frames{};
    std::size_t composited = 0;
    int begun = 0, begun_and_over = 0;
    int next_address = 0;

    bool has_head() const { return composited < frames.size(); }
    Frame& head() { return frames[composited]; }
    const Frame& head() const { return frames[composited]; }
    bool over() const { return !has_head(); }  ///< the newest frame is
    bool table_open() const { return has_head() && !frames.back().complete; }
    /// Pixels of the newest frame may come.
    bool receives() const {
        return !frames.empty() && !frames.back().lost_table && !(over() && frames.back().whole_at_end);
    }
    /// Pixels of it that are still to come.
    std::int64_t missing() const {
        return receives() ? std::max<std::int64_t>(frames.back().pixels() - frames.back().arrived, 0) : 0;
    }
    bool keeps_next() const {
        return !over() && !frames.back().abandoned && frames.back().arrived >= frames.back().released;
    }
    int held() const {
        std::size_t sum = 0;
        for (const Frame& frame : frames) sum += frame.held.size();
        return static_cast<int>(sum);
    }
    void begin_frame() {
        Frame frame;
        frame.entry = begun++ % 2;
        frame.base = next_address;
        frames.push_back(frame);
    }
    void miss_frame() {
        Frame frame;
        frame.missed = frame.complete = frame.lost_table = frame.abandoned = true;
        frames.push_back(frame);
    }
    void lose_table() {
        frames.back().row.reset();
        frames.back().complete = frames.back().lost_table = frames.back().abandoned = true;
    }
    void push(const Pixel& pixel) {
        if (keeps_next()) frames.back().held[frames.back().arrived] = pixel;
        ++frames.back().arrived;
        next_address = (next_address + 1) % addresses;
    }
    void lose(std::int64_t count) {
        frames.back().arrived += count;
        if (over()) return;
        frames.back().abandoned = true;
        frames.back().held.clear();
    }
    void release_through(std::int64_t k) {
        for (; head().released <= k; ++head().released) head().held.erase(head().released);
    }
    void end_frame() {
        if (!has_head()) return;
        head().whole_at_end = head().whole();
        begun_and_over += head().missed ? 0 : 1;
        ++composited;
    }
};

/// What the buffer says about itself, and what the memory has at the addresses that it gives.
void check_same(const ComposerBuffer& buffer, const std::vector<Pixel>& memory, const NaiveBuffer& wanted) {
    REQUIRE(buffer.capacity_pixels() == wanted.capacity);
    REQUIRE(buffer.held_pixels() == wanted.held());
    REQUIRE(buffer.free_pixels() == wanted.capacity - wanted.held());
    // The bus side.
    const auto frames_heard = static_cast<int>(wanted.frames.size());
    const auto composited = static_cast<int>(wanted.composited);
    REQUIRE(buffer.frames_heard() == frames_heard);
    REQUIRE(buffer.wants_frame() == (frames_heard - composited < 2));
    REQUIRE(buffer.can_begin_frame() == (wanted.begun - wanted.begun_and_over < 2));
    REQUIRE(buffer.table_open() == wanted.table_open());
    REQUIRE(buffer.table_lost() == (frames_heard > 0 && wanted.frames.back().lost_table));
    REQUIRE(buffer.write_address() == wanted.next_address);
    REQUIRE(buffer.missing_pixels() == wanted.missing());
    if (!wanted.receives()) REQUIRE_FALSE(buffer.next_pixel().has_value());
    if (wanted.missing() > 0) {
        REQUIRE(buffer.next_pixel() == wanted.frames.back().arrived);
        REQUIRE(buffer.keeps_next() == wanted.keeps_next());
        REQUIRE(buffer.abandoning() == wanted.frames.back().abandoned);
    }
    // The pipeline side.
    REQUIRE(buffer.has_frame() == wanted.has_head());
    const NaiveBuffer::Frame none;
    const NaiveBuffer::Frame& head = wanted.has_head() ? wanted.head() : none;
    REQUIRE(buffer.table_complete() == head.complete);
    REQUIRE(buffer.has_segment() == head.row.has_value());
    REQUIRE(buffer.abandoned() == head.abandoned);
    REQUIRE(buffer.segment_complete() == (head.abandoned || head.whole()));
    if (head.row) {
        REQUIRE(buffer.segment().row() == *head.row);
        REQUIRE(buffer.arrived_pixels() == head.arrived);
        REQUIRE(buffer.has_arrived(head.arrived - 1));
        REQUIRE_FALSE(buffer.has_arrived(head.arrived));
        REQUIRE(buffer.base_address() == head.base);
        std::map<std::int64_t, Pixel> stored;
        for (const auto& [k, pixel] : head.held) {
            const int address = buffer_address(buffer.base_address(), k, wanted.addresses);
            stored[k] = memory.at(static_cast<std::size_t>(address));
        }
        REQUIRE((stored == head.held));  // no two pixels are the same
    }
}

/// What a waveform shows: each frame under its entry.
void check_state(const ComposerBuffer& buffer, const NaiveBuffer& wanted) {
    const test::PartState state(buffer);
    REQUIRE(state["held"] == wanted.held());
    REQUIRE(state["write_address"] == wanted.next_address);
    REQUIRE(state["head"] == wanted.begun_and_over % 2);
    REQUIRE(state["frames"] == wanted.begun - wanted.begun_and_over);
    REQUIRE(state["frames_heard"] == static_cast<std::int64_t>(wanted.frames.size()));
    REQUIRE(state["frames_composited"] == static_cast<std::int64_t>(wanted.composited));
    if (wanted.frames.empty()) return;
    REQUIRE(state["table_lost"] == wanted.frames.back().lost_table);
    const auto check_frame = [&](const std::string& name, std::size_t number) {
        const NaiveBuffer::Frame& frame = wanted.frames[number];
        REQUIRE(state[name + "_number"] == static_cast<std::int64_t>(number));
        REQUIRE(state[name + "_table_complete"] == frame.complete);
        REQUIRE(state[name + "_has_segment"] == frame.row.has_value());
        REQUIRE(state[name + "_abandoned"] == frame.abandoned);
        REQUIRE(state[name + "_arrived"] == frame.arrived);
        REQUIRE(state[name + "_released"] == frame.released);
        REQUIRE(state[name + "_base_address"] == frame.base);
    };
    for (std::size_t number = wanted.composited; number < wanted.frames.size(); ++number) {
        const NaiveBuffer::Frame& frame = wanted.frames[number];
        if (!frame.missed) check_frame("frame_" + std::to_string(frame.entry), number);
    }
    if (wanted.missing() == 0) return;
    REQUIRE(state["receiving_ended_frame"] == wanted.over());
    if (wanted.over()) check_frame("ended", wanted.frames.size() - 1);
}

/// A bus that loses beats and a raster that does not wait, at random within their protocols.
class RandomUse {
  public:
    RandomUse(test::Random& random, int capacity, int addresses, Smoothing smoothing)
        : random_(random),
          smoothing_(smoothing),
          buffer_(capacity, kWidth, kHeight, smoothing),
          wanted_{capacity, addresses},
          memory_(static_cast<std::size_t>(addresses)) {}

    void play(int steps) {
        check();
        for (int step = 0; step < steps; ++step) {
            INFO("step " << step);
            if (random_.one_in(2)) {
                bus();
            } else {
                raster();
            }
            check();
        }
        REQUIRE(number_ > steps / 25);
    }

  private:
    void check() const {
        check_same(buffer_, memory_, wanted_);
        check_state(buffer_, wanted_);
    }
    void bus() {
        if (wanted_.table_open()) {
            next_row();
        } else if (wanted_.missing() > 0 && !random_.one_in(80)) {
            next_pixels();
        } else {
            next_frame();
        }
    }
    void next_row() {
        if (random_.one_in(8)) {
            buffer_.lose_table();
            wanted_.lose_table();
        } else if (!wanted_.frames.back().row && !random_.one_in(5)) {
            const ViewportRow row = smoothing_ == Smoothing::kBilinear
                                        ? test::random_smoothed_row(random_, kRaster, 3)
                                        : test::random_valid_row(random_, kRaster, 3);
            buffer_.set_row(row);
            wanted_.frames.back().row = row;
        } else {
            buffer_.end_table();
            wanted_.frames.back().complete = true;
        }
    }
    void next_pixels() {
        if (random_.one_in(60)) {
            const int lost = random_.between(1, static_cast<int>(wanted_.missing()));
            buffer_.lose(lost);
            wanted_.lose(lost);
            return;
        }
        for (int i = random_.between(1, 8); i > 0 && wanted_.missing() > 0; --i) {
            if (wanted_.held() == wanted_.capacity && wanted_.keeps_next()) {
                REQUIRE_THROWS_AS(ComposerBuffer(buffer_).push(), std::logic_error);
                return;
            }
            const Pixel pixel(static_cast<std::uint64_t>(++number_));
            const auto address = static_cast<std::size_t>(buffer_.write_address());
            REQUIRE(buffer_.push() == wanted_.keeps_next());
            if (wanted_.keeps_next()) memory_.at(address) = pixel;
            wanted_.push(pixel);
        }
    }
    void next_frame() {
        constexpr std::size_t kMostWaiting = 4;
        if (wanted_.begun - wanted_.begun_and_over == 2) {
            REQUIRE_THROWS_AS(ComposerBuffer(buffer_).begin_frame(), std::logic_error);
        } else if (!random_.one_in(6)) {
            buffer_.begin_frame();
            wanted_.begin_frame();
            return;
        }
        if (wanted_.frames.size() - wanted_.composited < kMostWaiting && random_.one_in(6)) {
            buffer_.miss_frame();
            wanted_.miss_frame();
        }
    }
    void raster() {
        if (!wanted_.has_head()) {
            if (random_.one_in(10)) buffer_.end_frame();  // nobody knows that frame
            return;
        }
        const NaiveBuffer::Frame& head = wanted_.head();
        if (!head.complete) return;
        if (head.released == 0 && random_.one_in(2)) {
            buffer_.start_frame();
            if (head.row) wanted_.release_through(skipped(*head.row) - 1);
        }
        for (int i = random_.between(1, 8); i > 0 && head.released < head.pixels(); --i) {
            // Mostly it releases pixels that have come or cannot come; starving is the exception.
            const bool may_come = wanted_.composited + 1 == wanted_.frames.size() && !head.abandoned;
            if (head.released >= head.arrived && may_come && !random_.one_in(20)) return;
            const std::int64_t k =
                std::min<std::int64_t>(head.released + random_.between(-2, 2), head.pixels() - 1);
            if (k < 0) continue;
            buffer_.release_through(k);
            wanted_.release_through(k);
        }
        if (head.released == head.pixels()) {
            buffer_.end_frame();
            wanted_.end_frame();
        }
    }
    /// Pixels that no raster position needs, above the raster.
    std::int64_t skipped(const ViewportRow& row) const {
        const test::PaintedSegment painted(row, kRaster, smoothing_);
        return std::count(painted.last.begin(), painted.last.end(), test::PaintedSegment::kNone);
    }

    test::Random& random_;
    Smoothing smoothing_;
    ComposerBuffer buffer_;
    NaiveBuffer wanted_;
    std::vector<Pixel> memory_;
    std::int64_t number_ = 0;  ///< of pixels
};

TEST_CASE("composer buffer: agrees with a naive one under random use, at any capacity") {
    const auto seed = test::random_seed(132);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    const std::map<int, int> addresses{{1, 16}, {2, 16}, {7, 16}, {16, 16}, {17, 32}, {64, 64}, {200, 256}};
    for (const auto& [capacity, count] : addresses) {
        INFO("capacity " << capacity);
        RandomUse(random, capacity, count, Smoothing::kReplicate).play(2000);
        RandomUse(random, capacity, count, Smoothing::kBilinear).play(2000);
    }
}

}  // namespace
}  // namespace metabuffer::composer_buffer_test
