#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "datapath/segment.h"
#include "formats/control_scanline.h"

namespace metabuffer {

/// Number of addresses of the memory for a buffer of so many pixels: a power of two, and enough that the consecutive
/// words of a beat lie in different block RAMs.
constexpr int buffer_addresses(int capacity_pixels) {
    int addresses = 16;
    while (addresses < capacity_pixels) {
        addresses *= 2;
    }
    return addresses;
}

/// The address of a segment's pixel k, given that of its pixel 0; after the last address comes the first.
constexpr int buffer_address(std::int64_t base_address, std::int64_t k, int addresses) {
    return static_cast<int>((base_address + k) & (std::int64_t{addresses} - 1));
}

/// How many addresses `to` lies after `from`.
constexpr int addresses_behind(int from, int to, int addresses) { return (to - from) & (addresses - 1); }

/// The account of a composer's local memory (section 5.2 of the paper): a queue of the segment's pixels with a moving
/// window, since a replicated source row is read again until its last repetition.
///
/// Pixels arrive in the order of their index k and are addressed by it. Pixel k is held from its arrival until it is
/// released; a pixel that arrives after its release is dropped. The buffer never holds more than its capacity: push()
/// on a full buffer throws std::logic_error, since the bus has then broken its protocol.
///
/// Frames count from 0, in the order of the bus. frames_heard() of them are known, frames_composited() of these are over:
///
/// | frame | what it is |
/// | --- | --- |
/// | kept | its table has begun; up to two are kept. An abandoned one has lost pixels or rows: none of it is used |
/// | missed | known, but its table did not come: it is composited in its turn, abandoned, without a segment or room |
/// | head | the oldest known frame that is not over, kept or missed: the one that the pipeline composites |
/// | newest | the newest kept frame: the one that the bus sends |
/// | ended | the newest frame, once it is over before all its pixels have come: the bus may still send it |
class ComposerBuffer {
  public:
    static constexpr int kFrames = 2;

    /// capacity_pixels: 1 or more. The raster is that of the composer's display.
    ComposerBuffer(int capacity_pixels, int raster_width_pixels, int raster_height_pixels,
                   Smoothing smoothing = Smoothing::kReplicate);

    // ---- the bus side ----

    /// Fewer than two known frames are not over, so another may come.
    bool wants_frame() const { return frames_heard_ - frames_composited_ < kFrames; }
    /// There is room to keep another frame. A missed frame takes none, so this may hold without wants_frame().
    bool can_begin_frame() const { return frames_ < kFrames; }
    /// Frames known so far, kept or missed.
    int frames_heard() const { return frames_heard_; }
    /// The next frame's table begins: until its row comes, the frame has no segment here.
    void begin_frame();
    /// The next frame is missed.
    void miss_frame();
    /// The table's row for this composer.
    void set_row(const ViewportRow& row);
    /// The table is complete.
    void end_table();
    /// Rows of the newest frame's table are still to come.
    bool table_open() const { return frames_ > 0 && !newest().table_complete; }
    /// The newest frame's table is open, and rows of it will not come.
    void lose_table();
    /// The last known frame was missed or its table was lost: its pixels are dropped.
    bool table_lost() const { return table_lost_; }

    // Pixels that come are the newest frame's, or the ended frame's.

    /// The next pixel has come, to be written to write_address(). False if it was dropped: it came too late, or its frame
    /// is abandoned.
    bool push();
    int write_address() const { return write_address_; }
    /// Index in its segment of the pixel that comes next; none if no pixel is to come.
    std::optional<std::int64_t> next_pixel() const;
    /// push() would keep the next pixel.
    bool keeps_next() const { return next_pixel().has_value() && keeps(receiving(), receiving().arrived); }
    /// The next pixel is one of an abandoned frame.
    bool abandoning() const { return next_pixel().has_value() && receiving().abandoned; }
    /// Pixels that have not come yet.
    std::int64_t missing_pixels() const;
    /// The next `count` pixels will not come. Their frame is abandoned, unless it is over.
    void lose(std::int64_t count);

    // ---- the pipeline side: the head frame ----

    bool has_frame() const { return frames_heard_ > frames_composited_; }
    /// Its table is known to its end, or will not come.
    bool table_complete() const { return missed() || (frames_ > 0 && head().table_complete); }
    bool has_segment() const { return frames_ > 0 && head().has_segment && !missed(); }
    const Segment& segment() const { return head().segment; }
    /// Every pixel of its segment has arrived, or will not come.
    bool segment_complete() const { return !has_segment() || head().abandoned || head().whole(); }
    bool abandoned() const { return missed() || (frames_ > 0 && head().abandoned); }
    std::int64_t arrived_pixels() const { return head().arrived; }
    bool has_arrived(std::int64_t k) const { return k < head().arrived; }
    /// The address of its pixel 0.
    std::int64_t base_address() const { return head().base_address; }

    /// Its compositing begins: leading pixels that no raster position needs are released.
    void start_frame();
    /// Pixel k has been used for the last time: it and all before it are released.
    void release_through(std::int64_t k);
    /// It is over.
    void end_frame();

    int capacity_pixels() const { return capacity_; }
    int held_pixels() const { return held_; }
    int free_pixels() const { return capacity_ - held_; }

    /// Calls see(name, value, largest value) for each register but those of the frames' segments, which are rows of
    /// tables.
    template <typename See>
    void visit_state(const See& see) const {
        see("held", held_, capacity_);
        see("write_address", write_address_, addresses_ - 1);
        see("head", head_, kFrames - 1);
        see("frames", frames_, kFrames);
        see("frames_heard", frames_heard_, kLargestFrameNumber);
        see("frames_composited", frames_composited_, kLargestFrameNumber);
        see("table_lost", table_lost_, 1);
        see("receiving_ended_frame", receiving_ended_frame_, 1);
        const auto see_frame = [this, &see](const std::string& name, const Frame& frame) {
            const std::int64_t pixels = most_segment_pixels(raster_width_, raster_height_);
            see((name + "_number").c_str(), frame.number, kLargestFrameNumber);
            see((name + "_table_complete").c_str(), frame.table_complete, 1);
            see((name + "_has_segment").c_str(), frame.has_segment, 1);
            see((name + "_abandoned").c_str(), frame.abandoned, 1);
            see((name + "_arrived").c_str(), frame.arrived, pixels);
            see((name + "_released").c_str(), frame.released, pixels);
            see((name + "_base_address").c_str(), frame.base_address, addresses_ - 1);
        };
        see_frame("frame_0", frame_[0]);
        see_frame("frame_1", frame_[1]);
        see_frame("ended", ended_);
    }

  private:
    struct Frame {
        int number = 0;  ///< from 0
        bool table_complete = false;
        bool has_segment = false;
        bool abandoned = false;
        Segment segment;
        std::int64_t arrived = 0;
        std::int64_t released = 0;
        std::int64_t base_address = 0;  ///< of pixel 0

        bool whole() const { return !has_segment || arrived == segment.pixels(); }
    };

    /// The head frame is a missed one.
    bool missed() const { return frames_composited_ != (frames_ > 0 ? head().number : frames_heard_); }

    static bool keeps(const Frame& frame, std::int64_t k) { return k >= frame.released && !frame.abandoned; }

    const Frame& head() const { return frame_[head_]; }
    Frame& head() { return frame_[head_]; }
    const Frame& newest() const { return frame_[(head_ + frames_ - 1) % kFrames]; }
    Frame& newest() { return frame_[(head_ + frames_ - 1) % kFrames]; }
    /// The frame whose pixels come next.
    const Frame& receiving() const { return receiving_ended_frame_ ? ended_ : newest(); }
    Frame& receiving() { return receiving_ended_frame_ ? ended_ : newest(); }

    int capacity_;
    int addresses_;
    int raster_width_;
    int raster_height_;
    Smoothing smoothing_;
    Frame frame_[kFrames];
    Frame ended_;  ///< while receiving_ended_frame_: the frame that is over
    int head_ = 0;
    int frames_ = 0;             ///< kept now
    int frames_heard_ = 0;       ///< known so far, kept or missed
    int frames_composited_ = 0;  ///< over
    bool table_lost_ = false;
    bool receiving_ended_frame_ = false;  ///< pixels of a frame that is over may still arrive
    int held_ = 0;
    int write_address_ = 0;
};

/// What a raster position shows of a segment.
struct RasterStep {
    std::int64_t pixel = 0;
    // Of a smoothed segment: the pixels that are mixed here besides.
    std::int32_t across =
        0;  ///< from a pixel of this source row to the one in the other row; 0: no other row
    std::int32_t beside = 0;  ///< -1: the pixel before; 1: the one after; 0: neither
    std::uint8_t weight_x = 0;
    std::uint8_t weight_y = 0;
    bool last = false;      ///< the raster's last position
    bool covered = false;   ///< the segment shows here; else all but `last` is 0
    bool replayed = false;  ///< its source row is shown for the second time or a later one

    /// As Segment::window_at and Segment::newest_at; only where covered.
    BlendWindow<std::int64_t> window() const;
    std::int64_t newest() const { return pixel + (across > 0 ? across : 0) + (beside > 0 ? 1 : 0); }

    /// In waveforms, see rtl/fields.h.
    template <typename See>
    static void visit_fields(const See& see, int pixel_bits = 64) {
        constexpr int kAcrossBits = 17;  // a raster's width with a sign
        see("last", &RasterStep::last);
        see("covered", &RasterStep::covered);
        see("replayed", &RasterStep::replayed);
        see("pixel", &RasterStep::pixel, pixel_bits);
        see("beside", &RasterStep::beside, 2);
        see("across", &RasterStep::across, kAcrossBits);
        see("weight_x", &RasterStep::weight_x);
        see("weight_y", &RasterStep::weight_y);
    }
};
inline bool operator==(const RasterStep& a, const RasterStep& b) {
    return a.pixel == b.pixel && a.across == b.across && a.beside == b.beside && a.weight_x == b.weight_x &&
           a.weight_y == b.weight_y && a.last == b.last && a.covered == b.covered && a.replayed == b.replayed;
}

/// Walks a display's raster in raster order. For each position it says whether the segment covers it, which of the
/// segment's pixels shows there, and whether that is the pixel's last use. Of a smoothed segment it gives all pixels
/// that a raster pixel is mixed of, and their weights. It only increments, as the hardware does.
class SegmentWalker {
  public:
    SegmentWalker() = default;
    /// Starts at the raster's top left. With has_segment = false nothing is ever covered.
    SegmentWalker(const Segment& segment, bool has_segment, int raster_width_pixels,
                  int raster_height_pixels);

    bool done() const { return y_ >= raster_height_; }
    int x() const { return x_; }
    int y() const { return y_; }
    bool covered() const { return row_covered_ && x_ >= left_ && x_ < right_; }
    /// The segment pixel that shows here; only where covered().
    std::int64_t pixel() const { return row_first_pixel_ + column_; }
    /// Pixels since the start of the source row; only where covered().
    int column() const { return column_; }
    /// First pixel of the source row that this raster row shows.
    std::int64_t row_first_pixel() const { return row_first_pixel_; }
    /// Which repetition of the source row this raster row is, from 0.
    int row_phase() const { return row_phase_; }
    /// The pixel is not needed at any later position; only where covered().
    bool last_use() const { return last_repetition_ && (column_phase_ == multiple_ - 1 || x_ == right_ - 1); }
    /// The pixels up to here are not needed at any later position; Segment::kNoPixel if this position releases none.
    /// Only where covered().
    std::int64_t released() const {
        return smooths() ? smoothed_released() : (last_use() ? pixel() : Segment::kNoPixel);
    }

    bool smooths() const { return reach_ > 0; }
    /// What shows here; nothing beyond the raster.
    RasterStep step() const;
    /// The raster row shows its source row for the second time or a later one.
    bool replayed() const { return row_covered_ && row_phase_ > first_row_phase_; }
    void advance();

    /// Calls see(name, value, largest value) for each register, or with the smallest value too. Those of smoothing are
    /// apart, since a composer that replicates does not have them.
    template <typename See>
    void visit_state(const See& see) const;
    template <typename See>
    void visit_smoothing_state(const See& see) const;

  private:
    static constexpr std::int64_t kLargestSide = 0xFFFF;  ///< of a segment
    void start_row();
    void start_smoothed_row();
    std::int64_t smoothed_released() const;
    bool has_beside() const {
        const int side = column_blend_.side();
        return side != 0 && column_ + side >= 0 && column_ + side < source_width_;
    }

    int raster_width_ = 0;
    int raster_height_ = 0;
    int left_ = 0;
    int right_ = 0;
    int top_ = 0;
    int bottom_ = 0;
    int multiple_ = 1;
    int source_width_ = 0;
    int start_column_ = 0;  ///< source column at the raster's left: 1 if column 0 lies beside the raster
    int start_column_phase_ = 0;  ///< repetitions of that source column that lie left of the raster
    int first_row_phase_ = 0;     ///< the same for the current source row and the raster's top
    int x_ = 0;
    int y_ = 0;
    int column_ = 0;
    int column_phase_ = 0;
    int row_phase_ = 0;
    std::int64_t row_first_pixel_ = 0;
    bool row_covered_ = false;
    bool last_repetition_ = false;

    // Smoothing.
    int reach_ = 0;
    int source_height_ = 0;
    int source_row_ = 0;
    BlendCounter start_column_blend_;
    BlendCounter column_blend_;
    BlendCounter row_blend_;
    bool has_across_ = false;  ///< another source row goes into this raster row
    std::int64_t across_ = 0;  ///< from a pixel of this source row to the one across
    std::int64_t releasing_row_ =
        -1;  ///< first pixel of the source row that this raster row releases; -1: none
};

template <typename See>
void SegmentWalker::visit_state(const See& see) const {
    see("x", x_, raster_width_);
    see("y", y_, raster_height_);
    see("window_row_pixel", row_first_pixel_, most_segment_pixels(raster_width_, raster_height_));
    see("window_column", column_, kLargestSide);
    see("window_column_phase", column_phase_, kMaximumMultiple);
    see("window_repetition", row_phase_, kMaximumMultiple);
    see("row_covered", row_covered_, 1);
    see("last_repetition", last_repetition_, 1);
    see("left", left_, raster_width_);
    see("right", right_, raster_width_);
    see("top", top_, raster_height_);
    see("bottom", bottom_, raster_height_);
    see("multiple", multiple_, kMaximumMultiple);
    see("source_width", source_width_, kLargestSide);
    see("start_column", start_column_, 1);
    see("start_column_phase", start_column_phase_, kMaximumMultiple);
    see("first_row_phase", first_row_phase_, kMaximumMultiple);
}

template <typename See>
void SegmentWalker::visit_smoothing_state(const See& see) const {
    see("reach", reach_, kMaximumMultiple);
    see("source_height", source_height_, kLargestSide);
    see("source_row", source_row_, kLargestSide);
    see("has_across", has_across_, 1);
    see("across", across_, kLargestSide, -kLargestSide);
    see("releasing_row", releasing_row_, most_segment_pixels(raster_width_, raster_height_), -1);
    const auto see_blend = [&see](const std::string& name, const BlendCounter& blend) {
        blend.visit_state(
            [&](const char* part, const int& value, std::int64_t largest, std::int64_t smallest = 0) {
                see((name + '_' + part).c_str(), value, largest, smallest);
            });
    };
    see_blend("start_column_blend", start_column_blend_);
    see_blend("column_blend", column_blend_);
    see_blend("row_blend", row_blend_);
}

inline void SegmentWalker::advance() {
    if (covered()) {
        if (++column_phase_ == multiple_) {
            column_phase_ = 0;
            ++column_;
        }
        if (smooths()) column_blend_.step();
    }
    if (++x_ == raster_width_) {
        x_ = 0;
        ++y_;
        start_row();
    }
}

}  // namespace metabuffer
