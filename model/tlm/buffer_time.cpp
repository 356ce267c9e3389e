#include "tlm/buffer_time.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace metabuffer::tlm {

BufferTime::BufferTime(const Config& config, ColumnTime& column) : config_(config), column_(column) {}

// ---- the bus side ----

void BufferTime::begin_frame(int frame, const ViewportRow* row, std::int64_t table_cycle, std::int64_t now) {
    // Earlier frames are settled here, not when beats of this frame come: it may have none.
    settle(now);
    newest_frame_ = frame;
    Frame& state = slot(frame);
    state = Frame{};
    state.number = frame;
    state.table_cycle = table_cycle;
    if (row == nullptr) {
        state.prefetched_cycle = table_cycle;
        return;
    }
    state.segment =
        Segment(*row, config_.raster_width_pixels, config_.raster_height_pixels, config_.smoothing);
}

std::int64_t BufferTime::frame_end_cycle(int frame) const {
    return column_.cycle_of(frame, frame_end_step());
}

void BufferTime::add(const BeatRun& beats, std::int64_t now) {
    settle(now);
    Frame& frame = slot(newest_frame_);
    const Run run{newest_frame_, beats.first_pixel, beats.pixels, beats.first_cycle + 1};
    frame.planned += run.pixels;
    newest_arrival_ = last_arrival(run);
    const std::int64_t prefetched_pixels = std::min<std::int64_t>(
        frame.pixels(), config_.capacity_pixels - config_.ready_space_pixels + std::int64_t{1});
    if (frame.prefetched_cycle == kUnknownCycle && frame.planned >= prefetched_pixels) {
        frame.prefetched_cycle = arrival(run, prefetched_pixels - 1 - run.first_pixel);
    }
    if (column_.may_stall() && column_.newest_frame() == newest_frame_) {
        report_late_arrivals(run);
        report_needed_step(frame);
    }
    runs_.push_back(run);
}

BufferTime::Release BufferTime::release_for(std::int64_t planned, int held_limit) const {
    const Frame& frame = slot(newest_frame_);
    const auto step_of = [this](const Frame& of, std::int64_t pixel) {
        return Release{of.number, config_.renderer + 1 + of.segment.last_use(pixel)};
    };
    if (planned > held_limit) {
        return step_of(frame, planned - held_limit - 1);
    }
    if (keeps(newest_frame_ - 1)) {
        const Frame& previous = slot(newest_frame_ - 1);
        const std::int64_t room = held_limit - planned;
        if (previous.pixels() > room) {
            return step_of(previous, previous.pixels() - room - 1);
        }
    }
    return {};
}

SlotTime BufferTime::slot_time(std::int64_t earliest, std::int64_t now) const {
    const Release release =
        release_for(planned_pixels(), config_.capacity_pixels - config_.ready_space_pixels);
    if (release.frame < 0) {
        return {earliest, 0, 0, 0};
    }
    const std::int64_t cycle = column_.cycle_of(release.frame, release.step);
    if (cycle == kUnknownCycle) {
        return {kUnknownCycle, column_.not_before(release.frame, release.step, now), release.frame,
                release.step};
    }
    return {std::max(earliest, cycle + 1 + config_.answer_cycles), 0, 0, 0};
}

BufferTime::Verdict BufferTime::busready_in_burst(const BurstBeat& beat, std::int64_t now) const {
    if (beat.remaining <= config_.pixels_per_beat) {
        return Verdict::kTaken;
    }
    const int margin = std::min(beat.remaining, config_.in_flight_pixels);
    const Release release = release_for(beat.first_missing, config_.capacity_pixels - margin);
    if (release.frame < 0) {
        return Verdict::kTaken;
    }
    const std::int64_t cycle = column_.cycle_of(release.frame, release.step);
    if (cycle <= beat.sampled) {
        return Verdict::kTaken;
    }
    return cycle == kUnknownCycle && beat.sampled >= now ? Verdict::kUndecided : Verdict::kDropped;
}

void BufferTime::count_drop(std::int64_t cycle) {
    ++counters_.busready_drops;
    drop_cycle_ = cycle;
    first_drop_cycle_ = std::min(first_drop_cycle_, cycle);
}

// ---- the pipeline side ----

std::int64_t BufferTime::prefetched_cycle(int frame) const {
    return keeps(frame) ? slot(frame).prefetched_cycle : kUnknownCycle;
}

std::int64_t BufferTime::table_cycle(int frame) const {
    return keeps(frame) ? slot(frame).table_cycle : kUnknownCycle;
}

std::int64_t BufferTime::arrived(int frame, std::int64_t through_cycle) const {
    std::int64_t pixels = slot(frame).planned;
    for (const Run& run : runs_) {
        if (run.frame == frame) pixels -= run.pixels - arrived(run, through_cycle);
    }
    return pixels;
}

/// Of a run's pixels.
int BufferTime::arrived(const Run& run, std::int64_t through_cycle) const {
    if (through_cycle < run.first_arrival) return 0;
    const std::int64_t beats = (through_cycle - run.first_arrival) / config_.cycles_per_beat + 1;
    return static_cast<int>(std::min<std::int64_t>(run.pixels, beats * config_.pixels_per_beat));
}

void BufferTime::start_frame(int frame) {
    if (!column_.may_stall()) {
        return;
    }
    for (const Run& run : runs_) {
        if (run.frame == frame) {
            report_late_arrivals(run);
        }
    }
    report_needed_step(slot(frame));
}

void BufferTime::report_needed_step(const Frame& frame) {
    std::int64_t step = kNoStep;
    if (frame.planned < frame.pixels()) {
        const std::int64_t needed = frame.segment.first_use(frame.planned);
        if (needed < frame.segment.never()) {
            step = config_.renderer + needed;
        }
    }
    column_.set_needed_step(config_.renderer, step);
}

/// Reports to the column each pixel that arrives later than the column needs it if nothing else delays the column.
/// Several pixels may be needed first in the same step. It waits for the last of them, so that one is reported; until it
/// has come, the step is the needed one.
void BufferTime::report_late_arrivals(const Run& run) {
    const Segment& segment = slot(run.frame).segment;
    const FrameTime& time = column_.frame(run.frame);
    if (last_arrival(run) <= time.extrapolated_cycle(config_.renderer + segment.first_use(run.first_pixel))) {
        return;
    }
    for (std::int64_t i = 0; i < run.pixels; ++i) {
        const std::int64_t k = run.first_pixel + i;
        const std::int64_t position = segment.first_use(k);
        if (position == segment.never()) {
            return;
        }
        if (k + 1 < segment.pixels() && segment.first_use(k + 1) == position) {
            continue;
        }
        const std::int64_t step = config_.renderer + position;
        const std::int64_t cycle = arrival(run, i);
        if (cycle > time.extrapolated_cycle(step)) {
            column_.add_arrival(config_.renderer, step, cycle);
        }
        if (first_stands_for_all(segment)) {
            return;
        }
    }
}

const Segment* BufferTime::segment(int frame) const {
    return keeps(frame) && slot(frame).pixels() > 0 ? &slot(frame).segment : nullptr;
}

void BufferTime::close_frame(int frame, std::int64_t limit, std::int64_t now) {
    Frame& state = slot(frame);
    if (state.closed || state.pixels() == 0) {
        return;
    }
    if (!column_.may_stall()) {
        for (const Run& run : runs_) {
            if (run.frame == frame && column_.started(frame)) count_starved_and_late(run, false);
        }
        // The rest is not even on its way.
        const Segment& segment = state.segment;
        const auto width = std::int64_t{segment.row().sdx};
        for (std::int64_t k = state.planned; k < state.pixels(); k = (k / width + 1) * width) {
            starve(state, {segment.newest_columns(static_cast<int>(k % width)).begin, segment.right()},
                   segment.newest_rows(static_cast<int>(k / width)), limit);
        }
    }
    state.closed = true;
    settle(now);
    report_decline(state, now);
    std::vector<StarvedRun>& starved = state.starved;
    std::sort(starved.begin(), starved.end(), [](const StarvedRun& a, const StarvedRun& b) {
        return std::tie(a.y, a.x_first) < std::tie(b.y, b.x_first);
    });
    std::size_t kept = 0;
    for (StarvedRun& run : starved) {
        // What the composer has not reached has not starved yet.
        const std::int64_t row_start = std::int64_t{run.y} * config_.raster_width_pixels;
        run.x_last = static_cast<int>(std::min<std::int64_t>(run.x_last, limit - 1 - row_start));
        if (run.x_last < run.x_first) {
            continue;
        }
        if (kept > 0 && starved[kept - 1].y == run.y && starved[kept - 1].x_last + 1 == run.x_first) {
            starved[kept - 1].x_last = run.x_last;
        } else {
            starved[kept++] = run;
        }
    }
    starved.resize(kept);
    if (kept > 0 && first_starved_cycle_ == kUnknownCycle) {
        const std::int64_t position =
            std::int64_t{starved[0].y} * config_.raster_width_pixels + starved[0].x_first;
        first_starved_cycle_ = column_.frame(frame).start_cycle() + config_.renderer + 1 + position;
    }
    std::int64_t replayed = replayed_positions(state.segment, limit);
    for (const StarvedRun& run : starved) {
        counters_.add_starved_run(run);
        replayed -= is_replay(state.segment, run.y) ? run.x_last - run.x_first + 1 : 0;
    }
    counters_.replayed_pixels += replayed;
}

/// Reports the level after the segment's last pixel if nothing of the next frame follows: no run of beats shows it
/// then.
void BufferTime::report_decline(const Frame& frame, std::int64_t now) {
    constexpr std::int64_t kPoints = 16;
    const std::int64_t end = std::min(frame_end_cycle(frame.number), now);
    bool next_follows = false;
    for (int next = frame.number + 1; next <= newest_frame_; ++next) {
        next_follows = next_follows || slot(next).planned > 0;
    }
    if (!on_level_ || next_follows || frame.planned < frame.pixels() || newest_arrival_ >= end) {
        return;
    }
    const auto report = [this, &frame](std::int64_t cycle) {
        on_level_(cycle, held(frame.number, frame.pixels(), cycle));
    };
    for (std::int64_t point = 1; point <= kPoints; ++point) {
        const std::int64_t cycle = newest_arrival_ + (end - newest_arrival_) * point / kPoints;
        if (wanted_level_cycle_ > newest_arrival_ && wanted_level_cycle_ < cycle) {
            report(std::exchange(wanted_level_cycle_, -1));
        }
        report(cycle);
    }
}

bool BufferTime::is_replay(const Segment& segment, int y) const {
    const ViewportRow& row = segment.row();
    const int j = (y - row.dy) / row.dmultiple;
    return y > std::max(segment.top(), row.dy + j * row.dmultiple);
}

/// Raster positions before `limit` that read a pixel again.
std::int64_t BufferTime::replayed_positions(const Segment& segment, std::int64_t limit) const {
    if (segment.row().dmultiple == 1) {
        return 0;
    }
    const std::int64_t width = segment.right() - segment.left();
    std::int64_t count = 0;
    for (int y = segment.top(); y < segment.bottom(); ++y) {
        if (is_replay(segment, y)) {
            const std::int64_t reached =
                limit - std::int64_t{y} * config_.raster_width_pixels - segment.left();
            count += std::clamp<std::int64_t>(reached, 0, width);
        }
    }
    return count;
}

// ---- counting ----

std::int64_t BufferTime::released(const Frame& frame, std::int64_t cycle) const {
    if (frame.pixels() == 0 || !column_.started(frame.number)) {
        return 0;
    }
    const std::int64_t composited = column_.frame(frame.number).step_at(cycle) - config_.renderer;
    if (composited <= 0) {
        return composited == 0 ? frame.segment.skipped_pixels() : 0;
    }
    return frame.segment.released_before(std::min(composited, column_.raster_pixels()));
}

std::int64_t BufferTime::held_of_previous(int frame, std::int64_t cycle) const {
    if (!keeps(frame - 1)) {
        return 0;
    }
    const Frame& previous = slot(frame - 1);
    return previous.pixels() - released(previous, cycle);
}

/// Counts what cannot change any more, so that little need be kept.
void BufferTime::settle(std::int64_t now) {
    std::size_t settled = 0;
    while (settled < runs_.size() && last_arrival(runs_[settled]) <= now) {
        count_run(runs_[settled++]);
    }
    if (settled > 0) {
        runs_.erase(runs_.begin(), runs_.begin() + static_cast<std::ptrdiff_t>(settled));
    }
}

const ComposerCounters& BufferTime::finish(std::int64_t through_cycle, std::int64_t stalled_cycles) {
    for (Run run : runs_) {
        if (run.first_arrival > through_cycle) {
            break;
        }
        run.pixels = arrived(run, through_cycle);
        count_run(run);
    }
    runs_.clear();
    if (drop_cycle_ > through_cycle) {
        --counters_.busready_drops;
    }
    counters_.stalled_cycles = stalled_cycles;
    return counters_;
}

/// Counts a run of beats for the last time.
void BufferTime::count_run(const Run& run) {
    if (!keeps(run.frame)) {
        throw std::logic_error("beats of a frame that is forgotten have not been counted");
    }
    count_high_water(run);
    if (on_level_) report_levels(run);
    if (column_.started(run.frame) && (!column_.may_stall() || slot(run.frame).segment.has_unused_pixels())) {
        count_starved_and_late(run, true);
    }
}

bool BufferTime::releases_one_a_clock(int frame) const {
    return !keeps(frame) || !slot(frame).segment.smooths();
}

/// On a bus with a beat each clock the number of held pixels never falls from one beat to the next, since a clock
/// releases at most one pixel, unless a segment is smoothed; so the last beat of a run stands for all.
void BufferTime::count_high_water(const Run& run) {
    if (counters_.buffer_high_water == config_.capacity_pixels) {
        return;
    }
    std::int64_t& high_water = counters_.buffer_high_water;
    const bool one_a_clock = releases_one_a_clock(run.frame) && releases_one_a_clock(run.frame - 1);
    if (!one_a_clock && held(run.frame, run.first_pixel + run.pixels, run.first_arrival) <= high_water) {
        return;  // it would not be more with all that the run releases
    }
    const int first = config_.cycles_per_beat == 1 && one_a_clock ? run.pixels : 1;
    for (int pixels = first; pixels <= run.pixels; ++pixels) {
        high_water = std::max<std::int64_t>(
            high_water, held(run.frame, run.first_pixel + pixels, arrival(run, pixels - 1)));
    }
}

void BufferTime::report_levels(const Run& run) {
    const std::int64_t before = run.first_arrival - 1;
    const std::int64_t last = last_arrival(run);
    const auto report = [this, &run](int pixels, std::int64_t cycle) {
        on_level_(cycle, held(run.frame, run.first_pixel + pixels, cycle));
    };
    // No earlier run lasts until that clock.
    const std::int64_t wanted = wanted_level_cycle_ < last ? std::exchange(wanted_level_cycle_, -1) : -1;
    if (wanted >= 0 && wanted < before) report(0, wanted);
    report(0, before);
    if (wanted > before) report(arrived(run, wanted), wanted);
    report(run.pixels, last);
}

/// The pixels held at a clock if the frame's first `pixels` pixels have arrived and nothing after them.
int BufferTime::held(int frame, std::int64_t pixels, std::int64_t cycle) const {
    const std::int64_t own = std::max<std::int64_t>(0, pixels - released(slot(frame), cycle));
    return static_cast<int>(own + held_of_previous(frame, cycle));
}

/// A raster position starves (`glitch` mode) if it is composited no later than the clock in which the newest of its
/// pixels is sampled; a pixel whose last position has passed is late. In `stall` mode none starves, but pixels that no
/// position needs may be late.
void BufferTime::count_starved_and_late(const Run& run, bool count_late) {
    Frame& frame = slot(run.frame);
    const Segment& segment = frame.segment;
    const FrameTime& time = column_.frame(run.frame);
    const auto composited_by = [&](std::int64_t cycle) {
        // Without stalls a step is a clock.
        const std::int64_t step = column_.may_stall() ? time.step_at(cycle) : cycle - time.start_cycle();
        return step - config_.renderer;
    };
    std::int64_t first_need = segment.first_use(run.first_pixel);
    if (segment.smooths()) first_need = std::min(first_need, segment.last_use(run.first_pixel));
    if (composited_by(last_arrival(run)) <= first_need) {
        return;  // all have come in time, as no pixel after the first is needed sooner
    }
    const bool note_starved = !column_.may_stall() && !frame.closed;
    for (std::int64_t i = 0; i < run.pixels; ++i) {
        const std::int64_t k = run.first_pixel + i;
        const std::int64_t missing_before =
            composited_by(arrival(run, i));  // positions before this one starve
        if (first_stands_for_all(segment) && missing_before <= segment.first_use(k)) {
            return;  // and each pixel after it has as much time or more
        }
        if (count_late && segment.last_use(k) < missing_before) {
            ++counters_.late_pixels;
        }
        if (note_starved) {
            const auto index =
                static_cast<std::uint32_t>(k);  // a 64-bit division takes several times as long
            starve(frame, segment.newest_columns(static_cast<int>(index % segment.row().sdx)),
                   segment.newest_rows(static_cast<int>(index / segment.row().sdx)), missing_before);
        }
    }
}

/// Of the positions in these columns and rows those before `missing_before` starve.
void BufferTime::starve(Frame& frame, Segment::Range columns, Segment::Range rows,
                        std::int64_t missing_before) const {
    if (columns.begin >= columns.end) {
        return;
    }
    for (int y = rows.begin; y < rows.end; ++y) {
        const std::int64_t reach = missing_before - std::int64_t{y} * config_.raster_width_pixels;
        if (reach <= columns.begin) {
            break;
        }
        add_starved(frame, y, columns.begin, static_cast<int>(std::min<std::int64_t>(columns.end, reach)));
    }
}

void BufferTime::add_starved(Frame& frame, int y, int x_begin, int x_end) const {
    if (!frame.starved.empty()) {
        StarvedRun& last = frame.starved.back();
        if (last.y == y && last.x_last + 1 == x_begin) {
            last.x_last = x_end - 1;
            return;
        }
    }
    frame.starved.push_back({frame.number, y, x_begin, x_end - 1});
}

}  // namespace metabuffer::tlm
