#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "datapath/segment.h"
#include "report/report.h"
#include "scenario/scenario.h"
#include "tlm/column_time.h"

namespace metabuffer::tlm {

/// Beats of a burst that follow each other without a gap, each of pixels_per_beat pixels except for the last.
struct BeatRun {
    std::int64_t first_pixel = 0;  ///< index in the segment
    int pixels = 0;
    std::int64_t first_cycle = 0;  ///< the clock in which the first beat is on the bus
};

/// A beat of a burst, at which a composer decides whether BUSREADY stays high.
struct BurstBeat {
    std::int64_t first_missing = 0;  ///< pixels of the newest frame from this one on have not been sampled
    std::int64_t sampled = 0;        ///< the clock that samples the beat
    int remaining = 0;               ///< pixels of the burst after it
};

/// The clock from which the bus may give a slot to a composer.
struct SlotTime {
    std::int64_t cycle = kUnknownCycle;  ///< BUSREADY is high for an arbitration at this clock or later
    std::int64_t not_before = 0;         ///< if it is not known: it is no earlier than this
    /// The step of the column that the cycle depends on, if it is not known.
    int frame = 0;
    std::int64_t step = 0;
};

/// A composer's buffer (section 5.2 of the paper) as arithmetic. The bus says which pixels are on their way or have
/// arrived; the column's time says which have been used. From both follow, without simulating a clock, the pixels held,
/// the changes of BUSREADY and the raster pixels that starve. The rules are those of the timing table in
/// docs/design.md.
///
/// Frames come in order; the table of frame f may come when frame f - 2 has been composited. "now" is the
/// present clock: all that happens before it has been decided.
class BufferTime {
  public:
    struct Config {
        int renderer = 0;             ///< index in the column, from 0
        int capacity_pixels = 0;      ///< of the buffer
        int ready_space_pixels = 0;   ///< free space that a slot needs
        int pixels_per_beat = 1;      ///< 1..8
        int cycles_per_beat = 1;      ///< more than 1 on a bus narrower than a pixel
        int in_flight_pixels = 2;     ///< that may come once BUSREADY falls, with the beat it falls at
        int answer_cycles = 0;        ///< registers on the way back: BUSREADY is read that many clocks later
        int raster_width_pixels = 0;  ///< of the display
        int raster_height_pixels = 0;
        Smoothing smoothing = Smoothing::kReplicate;
    };
    /// The column must outlive the buffer.
    BufferTime(const Config& config, ColumnTime& column);
    const Config& config() const { return config_; }

    // ---- the bus side ----

    /// The frame's table has been sent: its row for this composer, null if it has none, and the clock in which
    /// the composer knows the whole table.
    void begin_frame(int frame, const ViewportRow* row, std::int64_t table_cycle, std::int64_t now);
    /// The clock in which the composer releases a frame; in it TABLEREADY rises for the table two frames later.
    std::int64_t frame_end_cycle(int frame) const;
    std::int64_t frame_end_step() const { return config_.renderer + column_.raster_pixels(); }

    /// What happens to BUSREADY at a beat of a burst.
    enum class Verdict : std::uint8_t { kTaken, kDropped, kUndecided };
    /// Whether BUSREADY stays high at a beat. For a beat that is still to come that may be undecided.
    Verdict busready_in_burst(const BurstBeat& beat, std::int64_t now) const;
    /// Counts a drop of BUSREADY at that clock.
    void count_drop(std::int64_t cycle);
    /// Pixels of the newest frame on their way or arrived.
    std::int64_t planned_pixels() const { return slot(newest_frame_).planned; }
    /// Beats that are certain to be sent: `first_pixel` continues the segment.
    void add(const BeatRun& beats, std::int64_t now);
    /// The clock from which another slot is taken. earliest: the first clock in which BUSREADY counts all that was
    /// sent.
    SlotTime slot_time(std::int64_t earliest, std::int64_t now) const;

    // ---- the pipeline side ----

    /// The clock in which the composer is prefetched for the frame, if that is known.
    std::int64_t prefetched_cycle(int frame) const;
    /// The clock in which it knows the frame's whole table, if that is known.
    std::int64_t table_cycle(int frame) const;
    /// Pixels of a frame that have arrived by the end of a clock, which must be the present one.
    std::int64_t arrived(int frame, std::int64_t through_cycle) const;
    /// The column starts the newest frame whose table has been sent, or the one before it. In `stall` mode this reports
    /// to the column what the buffer needs.
    void start_frame(int frame);
    /// The frame has been composited up to raster position `limit` by the clock `now`: counts what starved.
    void close_frame(int frame, std::int64_t limit, std::int64_t now);
    /// A frame's segment, null if there is none, and its starved raster pixels: in raster order, in runs as long as
    /// possible. Valid from close_frame until a later frame takes this frame's entry.
    const Segment* segment(int frame) const;
    const std::vector<StarvedRun>& starved(int frame) const { return slot(frame).starved; }

    // ---- counting ----

    /// The clock of the first BUSREADY drop in a burst, and (`glitch` mode) that of the first starved pixel of the
    /// frames that are closed; kUnknownCycle if there is none.
    std::int64_t first_drop_cycle() const { return first_drop_cycle_; }
    std::int64_t first_starved_cycle() const { return first_starved_cycle_; }

    /// Called with the pixels held before and after each run of beats and while a frame runs out, in order of time,
    /// once they are certain. Also called for the clock `wanted_cycle`, unless that is -1.
    void on_level(std::function<void(std::int64_t cycle, int held_pixels)> callback,
                  std::int64_t wanted_cycle = -1) {
        on_level_ = std::move(callback);
        wanted_level_cycle_ = wanted_cycle;
    }
    /// What has been counted so far; of starved pixels, only those of closed frames.
    const ComposerCounters& counters() const { return counters_; }
    /// Counts all that has happened up to a clock, which must be the present one. Call it once.
    const ComposerCounters& finish(std::int64_t through_cycle, std::int64_t stalled_cycles);

  private:
    struct Frame {
        int number = -1;
        std::int64_t table_cycle = 0;
        Segment segment;           ///< without pixels: there is none
        std::int64_t planned = 0;  ///< pixels whose arrival is known
        std::int64_t prefetched_cycle = kUnknownCycle;
        bool closed = false;
        std::vector<StarvedRun> starved;

        std::int64_t pixels() const { return segment.pixels(); }
    };
    struct Run {
        int frame = 0;
        std::int64_t first_pixel = 0;
        int pixels = 0;
        std::int64_t first_arrival = 0;  ///< the clock in which the composer samples the first beat
    };
    /// A condition: some pixel has been released, which `step` of `frame` does.
    struct Release {
        int frame = -1;  ///< -1: nothing need be released
        std::int64_t step = 0;
    };

    const Frame& slot(int frame) const { return frames_[static_cast<std::size_t>(frame % kFramesKept)]; }
    Frame& slot(int frame) { return frames_[static_cast<std::size_t>(frame % kFramesKept)]; }
    bool keeps(int frame) const { return frame >= 0 && slot(frame).number == frame; }

    std::int64_t arrival(const Run& run, std::int64_t index) const {
        return run.first_arrival + index / config_.pixels_per_beat * config_.cycles_per_beat;
    }
    std::int64_t last_arrival(const Run& run) const { return arrival(run, run.pixels - 1); }
    int arrived(const Run& run, std::int64_t through_cycle) const;
    /// On a bus with a beat each clock a pixel of a run has at least as much time as the one before it: it is needed at
    /// least a step later.
    bool first_stands_for_all(const Segment& segment) const {
        return config_.cycles_per_beat == 1 && !segment.smooths();
    }
    std::int64_t released(const Frame& frame, std::int64_t cycle) const;
    std::int64_t held_of_previous(int frame, std::int64_t cycle) const;
    Release release_for(std::int64_t planned, int held_limit) const;
    void report_needed_step(const Frame& frame);
    void report_late_arrivals(const Run& run);
    void settle(std::int64_t now);
    void count_run(const Run& run);
    void report_levels(const Run& run);
    void report_decline(const Frame& frame, std::int64_t now);
    void count_high_water(const Run& run);
    int held(int frame, std::int64_t pixels, std::int64_t cycle) const;
    void count_starved_and_late(const Run& run, bool count_late);
    void starve(Frame& frame, Segment::Range columns, Segment::Range rows, std::int64_t missing_before) const;
    bool releases_one_a_clock(int frame) const;
    void add_starved(Frame& frame, int y, int x_begin, int x_end) const;
    std::int64_t replayed_positions(const Segment& segment, std::int64_t limit) const;
    bool is_replay(const Segment& segment, int y) const;

    Config config_;
    ColumnTime& column_;
    int newest_frame_ = -1;
    Frame frames_[kFramesKept];
    std::vector<Run> runs_;  ///< not counted yet, in order of arrival
    std::int64_t newest_arrival_ = 0;
    std::int64_t drop_cycle_ = -1;
    std::int64_t first_drop_cycle_ = kUnknownCycle;
    std::int64_t first_starved_cycle_ = kUnknownCycle;
    std::function<void(std::int64_t, int)> on_level_;
    std::int64_t wanted_level_cycle_ = -1;
    ComposerCounters counters_;
};

}  // namespace metabuffer::tlm
