#include "monitors/composer_observer.h"

#include <algorithm>
#include <utility>

#include "monitors/reference_composition.h"

namespace metabuffer::monitors {
namespace {

constexpr std::int64_t kMostFramesAtOnce = 65535;  ///< that a beat may report

std::uint64_t power_of_two_from(std::int64_t least) {
    std::uint64_t size = 1;
    while (size < static_cast<std::uint64_t>(least)) {
        size *= 2;
    }
    return size;
}

}  // namespace

ComposerObserver::ComposerObserver(const Scenario& scenario, int renderer, int display)
    : destination_(static_cast<std::uint16_t>(display + 1)),
      composition_(scenario.composition),
      far_z_(far_z(scenario.depth_format)),
      smoothing_(scenario.composer.smoothing),
      may_stall_(scenario.composer.may_stall()),
      background_(scenario.background_pixel()),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_height_(scenario.displays.raster_height_pixels()),
      buffer_pixels_(scenario.composer.buffer_pixels),
      ready_space_pixels_(scenario.composer.ready_space_pixels),
      timing_(scenario) {
    counters_.renderer = renderer + 1;
    counters_.display = display + 1;
}

void ComposerObserver::reset(bool pipemaster) {
    pipemaster_ = pipemaster;
    frames_.clear();
    frames_heard_ = x_ = y_ = 0;
    next_row_ = 0;
    frame_ = -1;
    counters_.starved_by_frame.clear();  // frames begin at 0 again
    announced_ = silent_edges_ = 0;
    dropped_edges_ = 0;
    ended_short_ = table_lost_ = running_ = false;
    below_was_ready_ = stood_still_ = overflowed_ = table_refused_ = false;
    expected_ = ComposerOutputs{};
}

void ComposerObserver::edge(const ComposerInputs& inputs, std::int64_t cycle) {
    const bool was_running = running_;
    overflowed_ = table_refused_ = false;
    kept_pixels_ = 0;
    stood_still_ = may_stall_ && inputs.column_stall;
    if (!stood_still_) {
        pipeline(inputs, cycle);
    } else if (expected_.stall) {
        ++counters_.stalled_cycles;
    }
    take_bus(inputs.bus);
    handshakes(was_running, inputs, cycle);
}

bool ComposerObserver::idle(const ComposerInputs& inputs) const {
    return !running_ && !expected_.startframe && !inputs.startframe && !expected_.pipe.valid &&
           dropped_edges_ == 0 && !(pipemaster_ && expected_.pipeready) && announced_ == 0 &&
           inputs.bus.kind == rtl::BusBeat::Kind::kNone;
}

// ---- the pipeline ----

void ComposerObserver::pipeline(const ComposerInputs& inputs, std::int64_t cycle) {
    if (running_) {
        expected_.startframe = false;
        composite(pipemaster_ ? rtl::PipePixel{background_, true, false} : inputs.pipe, cycle);
        return;
    }
    expected_.pipe.valid = false;
    expected_.startframe = pipemaster_ ? expected_.pipeready : inputs.startframe;
    if (expected_.startframe) {
        running_ = true;
        x_ = y_ = 0;
        Frame& frame = oldest();
        row_ = frame.has_segment ? frame.positions.raster_row(0) : SegmentPositions::RasterRow{};
        if (frame.has_segment && frame.positions.smooths()) {
            frame.used_up = frame.positions.used_up_after(-1, -1, 0);
        }
        ++frame_;
        frame_spans_.push_back({cycle, kNever, kNever});
    }
}

std::optional<ComposerObserver::LocalPixel> ComposerObserver::next_local_pixel() const {
    const Frame& frame = oldest();
    if (!row_.covered || !frame.positions.covers(x_)) {
        return std::nullopt;
    }
    LocalPixel local;
    local.column = frame.positions.column_at(x_);
    local.index = local.newest = row_.first_pixel + local.column;
    std::optional<ReferenceMixture> mixture;
    if (frame.positions.smooths()) {
        const ReferenceLines columns = frame.positions.columns_at(x_);
        const ReferenceLines rows = frame.positions.rows_at(y_);
        local.newest = std::int64_t{std::max(rows.own, rows.other)} * frame.positions.source_width() +
                       std::max(columns.own, columns.other);
        if (local.newest < frame.arrived && !frame.abandoned) {
            mixture = mixture_at(frame, columns, rows);
        }
    }
    local.arrived = local.newest < frame.arrived;
    local.abandoned = frame.abandoned;
    local.repeated = row_.repeats;
    local.last_use = frame.positions.smooths()
                         ? frame.positions.used_up_after(x_, y_, frame.used_up) > frame.used_up
                         : row_.last && frame.positions.columns_used_up(x_) > local.column;
    if (mixture) {
        local.pixel = reference_smoothing(*mixture, composition_, far_z_);
    } else if (local.arrived && !local.abandoned) {
        local.pixel = Pixel(frame.ring[static_cast<std::uint64_t>(local.index) & frame.ring_mask]);
    }
    return local;
}

ReferenceMixture ComposerObserver::mixture_at(const Frame& frame, const ReferenceLines& columns,
                                              const ReferenceLines& rows) const {
    const auto pixel = [&frame](int column, int row) {
        const std::int64_t k = std::int64_t{row} * frame.positions.source_width() + column;
        return Pixel(frame.ring[static_cast<std::uint64_t>(k) & frame.ring_mask]);
    };
    return {pixel(columns.own, rows.own),
            pixel(columns.other, rows.own),
            pixel(columns.own, rows.other),
            pixel(columns.other, rows.other),
            columns.weight,
            rows.weight};
}

bool ComposerObserver::needs_missing_pixel() const {
    if (!running_) {
        return false;
    }
    const std::optional<LocalPixel> local = next_local_pixel();
    return local && local->starves();
}

void ComposerObserver::composite(const rtl::PipePixel& upstream, std::int64_t cycle) {
    if (x_ == 0 && y_ == 0) {
        frame_spans_.back().start_cycle = cycle;
    }
    Frame& frame = oldest();
    expected_.pipe = {upstream.pixel, true, upstream.lost || frame.abandoned};
    if (const std::optional<LocalPixel> local = next_local_pixel()) {
        if (local->starves()) {
            count_starved_pixel({frame_, x_, y_}, cycle);
        } else if (!local->abandoned) {
            expected_.pipe.pixel = reference_composition(composition_, local->pixel, upstream.pixel);
            counters_.replayed_pixels += local->repeated ? 1 : 0;
        }
        if (frame.positions.smooths()) {
            frame.used_up = frame.positions.used_up_after(x_, y_, frame.used_up);
        } else if (row_.last) {
            frame.used_up = row_.first_pixel + frame.positions.columns_used_up(x_);
        }
    }
    if (++x_ == raster_width_) {
        x_ = 0;
        if (++y_ == raster_height_) {
            end_frame(cycle);
        } else {
            row_ = frame.has_segment ? frame.positions.raster_row(y_) : SegmentPositions::RasterRow{};
        }
    }
}

void ComposerObserver::end_frame(std::int64_t cycle) {
    running_ = false;
    frame_spans_.back().end_cycle = cycle;
    if (frames_.empty()) {
        return;  // a STARTFRAME that nobody had asked for
    }
    ended_short_ = frames_.size() == 1 && oldest().missing() > 0;
    if (ended_short_) {
        ended_ = std::move(oldest());
        ended_.used_up = ended_.positions.pixels();
    }
    frames_.erase(frames_.begin());
}

// ---- the bus ----

void ComposerObserver::take_bus(const rtl::BusBeat& beat) {
    ++silent_edges_;
    const bool in_its_turn = beat.kind == rtl::BusBeat::Kind::kNone || follow_frames(beat);
    switch (in_its_turn ? beat.kind : rtl::BusBeat::Kind::kNone) {
        case rtl::BusBeat::Kind::kNone:
            break;
        case rtl::BusBeat::Kind::kFrameStart:
            frames_.emplace_back();
            frames_.back().table_complete = beat.last;
            ++frames_heard_;
            table_lost_ = ended_short_ = false;
            next_row_ = 0;
            break;
        case rtl::BusBeat::Kind::kTableRow:
            take_row(beat);
            break;
        case rtl::BusBeat::Kind::kPixels:
            lose_open_table();
            if (beat.destination == destination_ && take_pixels(beat)) {
                announced_ = beat.remaining;
                silent_edges_ = 0;
                counters_.buffer_high_water = std::max(counters_.buffer_high_water, held_pixels());
            }
            break;
    }
    if (silent_edges_ == timing_.longest_gap_cycles) {
        announced_ = 0;  // the rest of the burst does not come
    }
}

/// What the frame's number of a beat alone says. False for a beat that breaks the bus's protocol.
bool ComposerObserver::follow_frames(const rtl::BusBeat& beat) {
    const bool starts = beat.kind == rtl::BusBeat::Kind::kFrameStart;
    // Frames begun since the newest known one; before the first frame the number is -1, so there are none.
    std::int64_t begun = std::int64_t{static_cast<std::int32_t>(beat.frame)} + 1 - frames_heard_;
    if (begun < 0 || begun > kMostFramesAtOnce || (starts && begun == 0)) {
        return false;
    }
    if (starts && !has_room_for_table()) {
        table_refused_ = true;
        return false;
    }
    if (begun == 0) {
        return true;
    }
    // The bus sends all of a frame before the next one's table: what is missing now was lost.
    lose_open_table();
    if (const std::int64_t missing = missing_pixels(); missing > 0) {
        lose(missing);
    }
    for (const int seen = starts ? 1 : 0; begun > seen; --begun) {
        Frame missed;
        missed.missed = missed.table_complete = missed.abandoned = true;
        frames_.push_back(missed);
        ++frames_heard_;
        ++counters_.lost_tables;
        table_lost_ = true;
        ended_short_ = false;
    }
    return true;
}

bool ComposerObserver::has_room_for_table() const {
    const auto taken =
        std::count_if(frames_.begin(), frames_.end(), [](const Frame& frame) { return !frame.missed; });
    return static_cast<std::size_t>(taken) < kFrames;
}

void ComposerObserver::lose_open_table() {
    if (!table_open()) {
        return;
    }
    frames_.back() = Frame{};
    frames_.back().table_complete = frames_.back().abandoned = true;
    ++counters_.lost_tables;
    table_lost_ = true;
}

void ComposerObserver::take_row(const rtl::BusBeat& beat) {
    if (!table_open() || beat.first < next_row_) {
        return;
    }
    if (beat.first > next_row_++) {
        lose_open_table();
        return;
    }
    Frame& frame = frames_.back();
    frame.table_complete = beat.last;
    if (beat.destination == destination_) {
        frame.has_segment = true;
        frame.positions = SegmentPositions(beat.row(), raster_width_, raster_height_, smoothing_);
        const std::uint64_t size = power_of_two_from(std::min(buffer_pixels_, frame.positions.pixels()));
        frame.ring.assign(size, 0);
        frame.ring_mask = size - 1;
    }
}

void ComposerObserver::lose(std::int64_t count) {
    Frame& frame = receiving();
    counters_.lost_pixels += count;
    frame.abandoned = frame.abandoned || !ended_short_;
    frame.arrived += count;
}

/// False if the beat breaks the bus's protocol.
bool ComposerObserver::take_pixels(const rtl::BusBeat& beat) {
    if (table_lost_) {
        return true;
    }
    if (!ended_short_ && frames_.empty()) {
        return false;
    }
    Frame& frame = receiving();
    if (!frame.has_segment || beat.first < frame.arrived) {
        return false;
    }
    if (beat.first > frame.arrived) {
        lose(beat.first - frame.arrived);
    }
    for (std::size_t i = 0; i < beat.count; ++i) {
        const std::int64_t k = frame.arrived;
        if (!frame.abandoned && k < frame.used_up) {
            ++counters_.late_pixels;
        } else if (!frame.abandoned) {
            if (free_pixels() == 0) {
                overflowed_ = true;
                return false;
            }
            frame.ring[static_cast<std::uint64_t>(k) & frame.ring_mask] = beat.words[i];
            ++kept_pixels_;
        }
        ++frame.arrived;
    }
    return true;
}

std::int64_t ComposerObserver::missing_pixels() const {
    return table_lost_ || (!ended_short_ && frames_.empty()) ? 0 : receiving().missing();
}

std::int64_t ComposerObserver::held_pixels() const {
    std::int64_t held = 0;
    for (const Frame& frame : frames_) {
        held += frame.held();
    }
    return held;
}

// ---- the handshakes ----

bool ComposerObserver::prefetched() const {
    return !running_ && table_complete() && (segment_complete() || free_pixels() < ready_space_pixels_);
}

void ComposerObserver::handshakes(bool was_running, const ComposerInputs& inputs, std::int64_t cycle) {
    if (dropped_edges_ == 1) {
        announced_ = 0;  // the beats sent after the drop have come: the burst is over
    }
    dropped_edges_ = std::max<std::int64_t>(dropped_edges_ - 1, 0);
    const std::int64_t room = free_pixels();
    if (dropped_edges_ > 0) {
        expected_.busready = false;
    } else if (announced_ > timing_.beat_pixels) {
        expected_.busready = room >= std::min(announced_, timing_.in_flight_pixels);
        if (!expected_.busready) {
            dropped_edges_ = timing_.cut_cycles;
            count_busready_drop(cycle);
        }
    } else {
        expected_.busready = room - announced_ >= ready_space_pixels_;
    }
    expected_.tableready = frames_.size() < kFrames;

    // A PIPEREADY from below at a frame's last edge still belongs to that frame.
    below_was_ready_ = inputs.pipeready && !was_running;
    const bool ready = expected_.pipeready || (below_was_ready_ && prefetched());
    expected_.pipeready = ready && !running_ && !was_running && !expected_.startframe;

    expected_.stall = may_stall_ && needs_missing_pixel();
    if (expected_.stall) {
        note_starved(cycle);
    }
}

}  // namespace metabuffer::monitors
