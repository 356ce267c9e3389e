#include "rtl/beat_receiver.h"

#include <algorithm>

#include "report/waits.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
namespace {

/// A bus cannot have reached a frame number that is farther ahead of the newest frame's than this.
constexpr int kMostFramesAhead = 65535;

}  // namespace

BeatReceiver::BeatReceiver(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
                           ComposerRecord& record)
    : Block(name),
      display_(static_cast<std::uint16_t>(display)),
      may_stall_(scenario.composer.may_stall()),
      ready_space_pixels_(scenario.composer.ready_space_pixels),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      pixel_bits_(segment_pixel_bits(scenario)),
      in_flight_pixels_(in_flight_pixels(scenario.bus, scenario.memory)),
      cut_cycles_(busready_cut_cycles(scenario.bus, scenario.memory)),
      longest_gap_cycles_(longest_beat_gap_cycles(scenario)),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      record_(record),
      buffer_(registers_, "buffer", 1,
              ComposerBuffer(scenario.composer.buffer_pixels, scenario.displays.raster_width_pixels(),
                             scenario.displays.raster_height_pixels(), scenario.composer.smoothing)),
      progress_(registers_, "progress", pixel_bits_),
      release_(registers_, "release", bits_for(scenario.composer.buffer_pixels)),
      announced_(registers_, "announced", bits_for(scenario.bus.burst_pixels)),
      silent_cycles_(registers_, "silent_cycles", bits_for(longest_gap_cycles_)),
      burst_cut_(registers_, "burst_cut", cut_cycles_),
      next_row_(registers_, "next_row", bits_for(scenario.displays.count())) {}

void BeatReceiver::reset() {
    registers_.reset();
    busready_o.write(busready_);
    tableready_o.write(tableready_);
    segment_o.write(HeadSegment{});
    progress_o.write(progress_);
    fetched_o.write(fetched_);
    write_o.write(FifoWrite{});
    release_o.write(release_);
}

void BeatReceiver::clock_edge() {
    const int held_before = buffer_->held_pixels();
    if (!may_stall_ || !column_stall_i.read()) {
        raster_edge();
    }
    bus_edge();
    drive_fifo(held_before);
    drive_handshakes();
    drive_raster();
}

// ---- the raster ----

void BeatReceiver::raster_edge() {
    if (start_i.read()) {
        buffer_.change().start_frame();
    }
    if (!uses_i.read()) {
        return;
    }
    const PixelUse& use = use_i.read();
    if (use.last_use != Segment::kNoPixel) {
        buffer_.change().release_through(use.last_use);
    }
    if (use.ends_frame) {
        buffer_.change().end_frame();
        segment_changes_ = true;
    }
}

void BeatReceiver::drive_raster() {
    if (segment_changes_) {
        segment_o.write(buffer_->has_segment() ? HeadSegment{true, buffer_->segment()} : HeadSegment{});
        segment_changes_ = false;
    }
    const SegmentProgress progress{buffer_->abandoned(), buffer_->arrived_pixels(),
                                   static_cast<std::uint32_t>(buffer_->base_address())};
    drive_output(progress_, progress_o, progress);
    drive_output(fetched_, fetched_o,
                 buffer_->table_complete() &&
                     (buffer_->segment_complete() || buffer_->free_pixels() < ready_space_pixels_));
}

// ---- the bus ----

void BeatReceiver::bus_edge() {
    const BusBeat& beat = bus_i.read();
    if (beat.kind != BusBeat::Kind::kNone) {
        clocked_.stay_awake();  // what is dropped is counted
        if (!follow_frames(beat)) {
            return;
        }
    }
    switch (beat.kind) {
        case BusBeat::Kind::kNone:
            break;
        case BusBeat::Kind::kFrameStart:
            begin_frame(beat);
            break;
        case BusBeat::Kind::kTableRow:
            take_row(beat);
            break;
        case BusBeat::Kind::kPixels:
            lose_open_table();  // pixels come after the table's last row
            if (beat.destination == display_) {
                take_pixels(beat);
                return;
            }
            break;
    }
    if (announced_ > 0) {
        ++silent_cycles_;
        if (silent_cycles_ == longest_gap_cycles_) {
            // What was announced does not come: it is lost, or something other than this composer stopped its burst.
            announced_ = 0;
        }
    }
}

/// Every beat names its frame, and the bus finishes a frame before it begins the next. So a beat shows what was lost of
/// the frames before it, and of its own frame if the start of that was lost. False, and reported, for a frame that is
/// over or cannot have begun.
bool BeatReceiver::follow_frames(const BusBeat& beat) {
    const bool begins = beat.kind == BusBeat::Kind::kFrameStart;
    const auto newest = static_cast<std::uint32_t>(buffer_->frames_heard() - 1);
    const auto behind_newest = static_cast<std::int32_t>(beat.frame - newest);
    if (behind_newest < (begins ? 1 : 0) || behind_newest > kMostFramesAhead) {
        protocol_error("a beat of a frame that is over, or that cannot have begun");
        return false;
    }
    if (begins && !buffer_->can_begin_frame()) {
        protocol_error("a third frame's table");
        return false;
    }
    if (behind_newest > 0) {
        lose_open_table();
        if (const std::int64_t missing = buffer_->missing_pixels(); missing > 0) {
            lose_pixels(missing);
        }
        for (int begun = begins ? 1 : 0; begun < behind_newest; ++begun) {
            ++record_.mutable_counters().lost_tables;
            buffer_.change().miss_frame();
            segment_changes_ = true;
        }
    }
    return true;
}

void BeatReceiver::begin_frame(const BusBeat& beat) {
    buffer_.change().begin_frame();
    segment_changes_ = true;
    next_row_ = 0;
    if (beat.last) {
        buffer_.change().end_table();
    }
}

void BeatReceiver::take_row(const BusBeat& beat) {
    if (buffer_->table_lost()) {
        return;
    }
    if (!buffer_->table_open() || beat.first < next_row_) {
        protocol_error("row " + std::to_string(beat.first) + " of a table again");
        return;
    }
    if (beat.first > next_row_) {
        lose_open_table();
        return;
    }
    ++next_row_;
    if (beat.destination == display_) {
        buffer_.change().set_row(beat.row());
        segment_changes_ = true;
    }
    if (beat.last) {
        buffer_.change().end_table();
    }
}

/// The rows that the newest frame's table lacks will not come. One of them may have been this composer's.
void BeatReceiver::lose_open_table() {
    if (buffer_->table_open()) {
        ++record_.mutable_counters().lost_tables;
        buffer_.change().lose_table();
        segment_changes_ = true;
    }
}

void BeatReceiver::take_pixels(const BusBeat& beat) {
    if (!buffer_->table_lost() && !keep_pixels(beat)) {
        return;
    }
    announced_ = static_cast<int>(beat.remaining);
    silent_cycles_ = 0;
}

/// False, and reported, if the bus has broken its protocol.
bool BeatReceiver::keep_pixels(const BusBeat& beat) {
    const std::optional<std::int64_t> next = buffer_->next_pixel();
    if (!next || beat.first < *next) {
        protocol_error("pixel " + std::to_string(beat.first) + " of its segment when " +
                       (next ? std::to_string(*next) + " was next" : "it was sent no table"));
        return false;
    }
    if (beat.first > *next) {
        lose_pixels(beat.first - *next);
    }
    for (int i = 0; i < beat.count; ++i) {
        if (buffer_->free_pixels() == 0 && buffer_->keeps_next()) {
            protocol_error("a pixel for a full buffer");
            return false;
        }
        const auto address = static_cast<std::uint32_t>(buffer_->write_address());
        if (!buffer_.change().push()) {
            record_.mutable_counters().late_pixels += buffer_->abandoning() ? 0 : 1;
            continue;
        }
        if (kept_.count == 0) {
            kept_.address = address;
        }
        kept_.words[kept_.count++] = beat.words[static_cast<std::size_t>(i)];
    }
    std::int64_t& high_water = record_.mutable_counters().buffer_high_water;
    high_water = std::max<std::int64_t>(high_water, buffer_->held_pixels());
    return true;
}

void BeatReceiver::protocol_error(const std::string& what) const {
    SC_REPORT_ERROR("/metabuffer/composer/protocol", (whole() + " was sent " + what).c_str());
}

void BeatReceiver::lose_pixels(std::int64_t count) {
    record_.mutable_counters().lost_pixels += count;
    const int held = buffer_->held_pixels();
    buffer_.change().lose(count);
    abandoned_pixels_ += static_cast<std::uint32_t>(held - buffer_->held_pixels());
}

// ---- the FIFO ----

/// Which of this edge's pixels the FIFO stores and releases.
void BeatReceiver::drive_fifo(int held_before) {
    if (kept_.count > 0 || writes_) {
        write_o.write(kept_);
        writes_ = kept_.count > 0;
    }
    FifoRelease release;
    release.newest = abandoned_pixels_;
    release.oldest =
        static_cast<std::uint32_t>(held_before + kept_.count - buffer_->held_pixels()) - abandoned_pixels_;
    if (release.any() || release_->any()) {
        release_ = release;
        release_o.write(release);
    }
    kept_.count = 0;
    abandoned_pixels_ = 0;
}

// ---- the handshakes ----

bool BeatReceiver::slot_ready() const { return buffer_->free_pixels() - announced_ >= ready_space_pixels_; }

void BeatReceiver::drive_handshakes() {
    if (burst_cut_.pass() && !burst_cut_.running()) {
        announced_ = 0;
    }
    bool busready = !burst_cut_.running();
    if (!busready) {
        // What the bus sends before it reads the drop is still to come.
    } else if (announced_ > pixels_per_beat_) {
        busready = buffer_->free_pixels() >= std::min(announced_.value(), in_flight_pixels_);
        if (!busready) {
            burst_cut_.start(cut_cycles_);
            record_.count_busready_drop(clock_edge_number(core_period_picoseconds_));
        }
    } else {
        busready = slot_ready();
    }
    drive_output(busready_, busready_o, busready);
    drive_output(tableready_, tableready_o, buffer_->wants_frame());
}

void BeatReceiver::trace(sc_core::sc_trace_file* file) const {
    registers_.trace(file, path(""));
    sc_trace(file, segment_o.read(), path("segment"));
}

std::string BeatReceiver::waiting_for() const {
    const int next = record_.frame() + 1;
    if (!buffer_->table_complete()) {
        return waits::for_table(next);
    }
    return fetched_ ? std::string() : waits::for_prefetch(next);
}

}  // namespace metabuffer::rtl
