#include "datapath/composer_buffer.h"

#include <algorithm>
#include <stdexcept>

namespace metabuffer {

ComposerBuffer::ComposerBuffer(int capacity_pixels, int raster_width_pixels, int raster_height_pixels,
                               Smoothing smoothing)
    : capacity_(capacity_pixels),
      addresses_(buffer_addresses(capacity_pixels)),
      raster_width_(raster_width_pixels),
      raster_height_(raster_height_pixels),
      smoothing_(smoothing) {}

void ComposerBuffer::begin_frame() {
    if (!can_begin_frame()) {
        throw std::logic_error("a third frame's table was broadcast");
    }
    ++frames_;
    receiving_ended_frame_ = table_lost_ = false;
    newest() = Frame{};
    newest().number = frames_heard_++;
    newest().base_address = write_address_;
}

void ComposerBuffer::miss_frame() {
    ++frames_heard_;
    table_lost_ = true;
}

void ComposerBuffer::set_row(const ViewportRow& row) {
    newest().segment = Segment(row, raster_width_, raster_height_, smoothing_);
    newest().has_segment = true;
}

void ComposerBuffer::end_table() { newest().table_complete = true; }

void ComposerBuffer::lose_table() {
    newest().has_segment = false;
    newest().abandoned = true;
    newest().table_complete = true;
    table_lost_ = true;
}

bool ComposerBuffer::push() {
    write_address_ = write_address_ + 1 == addresses_ ? 0 : write_address_ + 1;
    Frame& frame = receiving();
    if (!keeps(frame, frame.arrived++)) {
        return false;
    }
    if (held_ == capacity_) {
        throw std::logic_error("a pixel arrived at a full buffer");
    }
    ++held_;
    return true;
}

std::optional<std::int64_t> ComposerBuffer::next_pixel() const {
    if (table_lost_ || (!receiving_ended_frame_ && frames_ == 0)) {
        return std::nullopt;
    }
    return receiving().arrived;
}

std::int64_t ComposerBuffer::missing_pixels() const {
    if (!next_pixel().has_value() || receiving().whole()) {
        return 0;
    }
    return receiving().segment.pixels() - receiving().arrived;
}

void ComposerBuffer::lose(std::int64_t count) {
    Frame& frame = receiving();
    if (!frame.abandoned && !receiving_ended_frame_) {
        held_ -= static_cast<int>(std::max<std::int64_t>(frame.arrived - frame.released, 0));
        frame.abandoned = true;
    }
    frame.arrived += count;
}

void ComposerBuffer::start_frame() {
    if (has_segment() && head().segment.skipped_pixels() > 0) {
        release_through(head().segment.skipped_pixels() - 1);
    }
}

void ComposerBuffer::release_through(std::int64_t k) {
    Frame& frame = head();
    if (k < frame.released) {
        return;
    }
    if (!frame.abandoned && frame.arrived > frame.released) {
        held_ -= static_cast<int>(std::min(frame.arrived, k + 1) - frame.released);
    }
    frame.released = k + 1;
}

void ComposerBuffer::end_frame() {
    if (missed()) {
        ++frames_composited_;
        return;
    }
    if (frames_ == 0) {
        return;  // a frame that was started and is not known
    }
    if (has_segment()) {
        // The last pixel has had its last use: nothing of this frame is held any more.
        receiving_ended_frame_ = frames_ == 1 && !head().whole();
        if (receiving_ended_frame_) {
            ended_ = head();
        }
    }
    head_ = (head_ + 1) % kFrames;
    --frames_;
    ++frames_composited_;
}

SegmentWalker::SegmentWalker(const Segment& segment, bool has_segment, int raster_width_pixels,
                             int raster_height_pixels)
    : raster_width_(raster_width_pixels), raster_height_(raster_height_pixels) {
    if (has_segment) {
        const ViewportRow& row = segment.row();
        left_ = segment.left();
        right_ = segment.right();
        top_ = segment.top();
        bottom_ = segment.bottom();
        multiple_ = row.dmultiple;
        source_width_ = row.sdx;
        start_column_phase_ = left_ - row.dx;
        first_row_phase_ = top_ - row.dy;
        if (start_column_phase_ >= multiple_) {
            start_column_phase_ -= multiple_;
            start_column_ = 1;
        }
        if (first_row_phase_ >= multiple_) {
            first_row_phase_ -= multiple_;
            source_row_ = 1;
            row_first_pixel_ = source_width_;
        }
        reach_ = segment.reach();
        source_height_ = row.sdy;
        if (smooths()) {
            start_column_blend_ = BlendCounter(multiple_, start_column_phase_);
            row_blend_ = BlendCounter(multiple_, first_row_phase_);
        }
    }
    start_row();
}

void SegmentWalker::start_row() {
    if (y_ == top_) {
        row_phase_ = first_row_phase_;
    } else if (row_covered_) {
        if (++row_phase_ == multiple_) {
            row_phase_ = 0;
            first_row_phase_ = 0;
            row_first_pixel_ += source_width_;
            ++source_row_;
        }
        if (smooths()) row_blend_.step();
    }
    row_covered_ = y_ >= top_ && y_ < bottom_;
    last_repetition_ = row_phase_ == multiple_ - 1 || y_ == bottom_ - 1;
    column_ = start_column_;
    column_phase_ = start_column_phase_;
    if (smooths()) start_smoothed_row();
}

void SegmentWalker::start_smoothed_row() {
    column_blend_ = start_column_blend_;
    const int side = row_blend_.side();
    has_across_ = side != 0 && source_row_ + side >= 0 && source_row_ + side < source_height_;
    across_ = std::int64_t{side} * source_width_;
    // The source row above has its last use in the last raster row that lies nearer to it than to this row's centre. In
    // the last raster row it may be in use still; then it is released pixel by pixel, and all others at the end.
    releasing_row_ = -1;
    const bool last_raster_row = y_ == bottom_ - 1;
    if (source_row_ > 0 && (row_phase_ == reach_ - 1 || (last_raster_row && row_phase_ < reach_))) {
        releasing_row_ = row_first_pixel_ - source_width_;
    } else if (last_raster_row) {
        releasing_row_ = row_first_pixel_;
    }
}

RasterStep SegmentWalker::step() const {
    RasterStep step;
    if (done()) {
        return step;
    }
    step.last = x_ == raster_width_ - 1 && y_ == raster_height_ - 1;
    step.covered = covered();
    if (!step.covered) {
        return step;
    }
    step.replayed = replayed();
    step.pixel = pixel();
    if (smooths() && has_beside()) {
        step.beside = column_blend_.side();
        step.weight_x = static_cast<std::uint8_t>(column_blend_.weight());
    }
    if (smooths() && has_across_) {
        step.across = static_cast<std::int32_t>(across_);
        step.weight_y = static_cast<std::uint8_t>(row_blend_.weight());
    }
    return step;
}

BlendWindow<std::int64_t> RasterStep::window() const {
    BlendWindow<std::int64_t> window{pixel, Segment::kNoPixel, Segment::kNoPixel, Segment::kNoPixel};
    if (beside != 0) window.beside = pixel + beside;
    if (across != 0) window.across = pixel + across;
    if (beside != 0 && across != 0) window.diagonal = window.beside + across;
    return window;
}

std::int64_t SegmentWalker::smoothed_released() const {
    if (releasing_row_ < 0) return Segment::kNoPixel;
    if (x_ == right_ - 1) {
        return y_ == bottom_ - 1 ? std::int64_t{source_width_} * source_height_ - 1
                                 : releasing_row_ + source_width_ - 1;
    }
    // The column before has its last use in the last raster column that lies nearer to it; one that lies beside the
    // raster has none.
    return column_ > 0 && column_phase_ >= reach_ - 1 ? releasing_row_ + column_ - 1 : Segment::kNoPixel;
}

}  // namespace metabuffer
