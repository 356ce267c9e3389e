#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <utility>

#include "tlm/buffer_time.h"
#include "tlm/column_time.h"
#include "unit/tlm/naive_column.h"

namespace metabuffer::test {

/// Reports to a ColumnTime and its BufferTimes what the buses of a naive column did, as their callers do: decision by
/// decision, sometimes ahead of the present. Checks every answer against what happened.
class ColumnReplay {
  public:
    /// The run ends after clock `end`.
    ColumnReplay(const NaiveSetup& setup, const NaiveColumnLog& log, std::int64_t end, std::uint64_t seed)
        : setup_(setup),
          log_(log),
          end_(end),
          random_(seed),
          column_(static_cast<int>(setup.composers.size()),
                  std::int64_t{setup.raster.width} * setup.raster.height, setup.stall) {
        for (std::size_t r = 0; r < setup.composers.size(); ++r) {
            const NaiveComposerSetup& from = setup.composers[r];
            tlm::BufferTime::Config config;
            config.renderer = static_cast<int>(r);
            config.capacity_pixels = from.capacity_pixels;
            config.ready_space_pixels = from.ready_space_pixels;
            config.pixels_per_beat = from.pixels_per_beat;
            config.in_flight_pixels = 2 * from.pixels_per_beat;
            config.cycles_per_beat = from.cycles_per_beat;
            config.raster_width_pixels = setup.raster.width;
            config.raster_height_pixels = setup.raster.height;
            config.smoothing = setup.smoothing;
            buses_.emplace_back();
            buses_.back().buffer = std::make_unique<tlm::BufferTime>(config, column_);
            buses_.back().buffer->on_level(
                [this, r](std::int64_t cycle, int held) { check_level(r, cycle, held); });
        }
        column_.on_stall([this](int frame, std::int64_t first, std::int64_t last) {
            REQUIRE(frame == column_.newest_frame());
            for (std::int64_t clock = first; clock <= last; ++clock) {
                INFO("stalled at clock " << clock);
                REQUIRE(std::binary_search(log_.stalls.begin(), log_.stalls.end(), clock));
            }
        });
        pipeready_event_ = log.pipeready.front();
        report_pipeready();
    }
    ColumnReplay(const ColumnReplay&) = delete;
    ColumnReplay& operator=(const ColumnReplay&) = delete;

    void run() {
        while (take_one()) check_column();
        check_waiters();
        finish();
    }

    /// How often the replay has met what it is meant to check.
    struct Met {
        int bursts = 0;
        int slots_unknown = 0;
        int undecided = 0;
        int drops = 0;
        int ahead = 0;
        int callbacks = 0;
        int levels = 0;
        int wrong_levels = 0;      ///< not what is held at that clock
        int unordered_levels = 0;  ///< earlier than one reported before
        std::string first_wrong_level;
        std::int64_t starved = 0;
        std::int64_t late = 0;
        std::int64_t replayed = 0;
        std::int64_t stalled = 0;
        Met& operator+=(const Met& o) {
            bursts += o.bursts;
            slots_unknown += o.slots_unknown;
            undecided += o.undecided;
            drops += o.drops;
            ahead += o.ahead;
            callbacks += o.callbacks;
            levels += o.levels;
            wrong_levels += o.wrong_levels;
            unordered_levels += o.unordered_levels;
            if (first_wrong_level.empty()) first_wrong_level = o.first_wrong_level;
            starved += o.starved;
            late += o.late;
            replayed += o.replayed;
            stalled += o.stalled;
            return *this;
        }
    };
    const Met& met() const { return met_; }

  private:
    static constexpr std::int64_t kNever = tlm::kUnknownCycle;

    struct Bus {
        std::unique_ptr<tlm::BufferTime> buffer;
        std::size_t frame = 0;  ///< to send next or under way
        bool table_sent = false;
        std::size_t burst = 0;
        std::size_t beat = 0;  ///< not 0: BUSREADY is not known yet, ask again
        std::int64_t earliest = 0;
        tlm::SlotTime slot;
        std::int64_t newest_level = -1;
    };

    // ---- what comes next ----

    const NaiveFrameLog* frame_log(std::size_t r) const {
        const auto& frames = log_.composers[r].frames;
        return buses_[r].frame < frames.size() ? &frames[buses_[r].frame] : nullptr;
    }
    /// The clock of a bus's next decision.
    std::int64_t head(std::size_t r) const {
        const Bus& bus = buses_[r];
        const NaiveFrameLog* const frame = frame_log(r);
        if (frame == nullptr) return kNever;
        if (!bus.table_sent) return frame->table_sent;
        const NaiveBurst& burst = frame->bursts[bus.burst];
        return bus.beat > 0 ? burst.beats[bus.beat - 1].cycle + 1 : burst.granted;
    }
    std::int64_t composited_event() const {
        const int frame = column_.newest_frame();
        return frame < 0 || frame < frames_composited_ ? kNever
                                                       : column_.frame(frame).cycle_of(column_.last_step());
    }

    bool take_one() {
        std::int64_t first = std::min(composited_event(), pipeready_event_);
        for (std::size_t r = 0; r < buses_.size(); ++r) first = std::min(first, head(r));
        if (first > end_ || first == kNever) return false;
        REQUIRE(first >= now_);
        std::vector<std::size_t> candidates;
        for (std::size_t r = 0; r < buses_.size(); ++r) {
            if (head(r) <= end_) candidates.push_back(r);
        }
        if (!candidates.empty() && random_.one_in(3)) {
            const std::size_t r = candidates[static_cast<std::size_t>(
                random_.between(0, static_cast<int>(candidates.size()) - 1))];
            now_ += random_.between(0, static_cast<int>(first - now_));
            if (head(r) > now_ && may_run_ahead(r)) {
                ++met_.ahead;
                decide(r);
                return true;
            }
        }
        now_ = first;
        // What happens in the same clock comes in any order.
        std::vector<int> same;
        if (composited_event() == first) same.push_back(-1);
        if (pipeready_event_ == first) same.push_back(-2);
        for (std::size_t r = 0; r < buses_.size(); ++r) {
            if (head(r) == first) same.push_back(static_cast<int>(r));
        }
        const int chosen =
            same[static_cast<std::size_t>(random_.between(0, static_cast<int>(same.size()) - 1))];
        if (chosen == -1) {
            take_composited();
        } else if (chosen == -2) {
            report_pipeready();
        } else {
            decide(static_cast<std::size_t>(chosen));
        }
        return true;
    }

    /// Nothing that is not known yet can change the decision.
    bool may_run_ahead(std::size_t r) {
        Bus& bus = buses_[r];
        if (bus.beat > 0) return false;
        if (!bus.table_sent) {
            return bus.frame < 2 || bus.buffer->frame_end_cycle(static_cast<int>(bus.frame) - 2) != kNever;
        }
        ask_for_slot(r);
        return bus.slot.cycle != kNever;
    }

    // ---- the bus side ----

    void decide(std::size_t r) {
        INFO("composer " << r << ", frame " << buses_[r].frame << ", burst " << buses_[r].burst << ", now "
                         << now_);
        if (!buses_[r].table_sent) {
            send_table(r);
        } else if (buses_[r].beat > 0) {
            look_again(r);
        } else {
            start_burst(r);
        }
        try_start();
    }

    void send_table(std::size_t r) {
        Bus& bus = buses_[r];
        const NaiveFrameLog& frame = *frame_log(r);
        const auto number = static_cast<int>(bus.frame);
        if (number >= 2) {
            // TABLEREADY rises where the composer lets go of the frame two before, and is read a clock later.
            const std::int64_t end = bus.buffer->frame_end_cycle(number - 2);
            REQUIRE(end < frame.table_sent);
            REQUIRE(end == log_.steps[static_cast<std::size_t>(number) - 2]
                                     [static_cast<std::size_t>(bus.buffer->frame_end_step())]);
        }
        const auto& row = setup_.composers[r].rows[bus.frame];
        bus.buffer->begin_frame(number, row ? &*row : nullptr, frame.table_cycle, now_);
        REQUIRE(bus.buffer->table_cycle(number) == frame.table_cycle);
        bus.table_sent = true;
        bus.burst = 0;
        bus.earliest = frame.table_cycle;
        if (frame.bursts.empty()) {
            next_frame(bus);
        } else {
            ask_for_slot(r);
        }
    }

    static void next_frame(Bus& bus) {
        ++bus.frame;
        bus.table_sent = false;
    }

    void ask_for_slot(std::size_t r) {
        Bus& bus = buses_[r];
        const NaiveBurst& burst = frame_log(r)->bursts[bus.burst];
        bus.slot = bus.buffer->slot_time(bus.earliest, now_);
        if (bus.slot.cycle != kNever) {
            REQUIRE(bus.slot.cycle == burst.slot_clock);
            return;
        }
        ++met_.slots_unknown;
        REQUIRE(bus.slot.not_before <= burst.slot_clock);
        // It depends on a step of the column: the slot is taken a clock after it.
        const std::int64_t step =
            log_.steps[static_cast<std::size_t>(bus.slot.frame)][static_cast<std::size_t>(bus.slot.step)];
        REQUIRE(std::max(bus.earliest, step + 1) == burst.slot_clock);
        if (random_.one_in(4)) wait_for(bus.slot.frame, bus.slot.step);
    }

    void start_burst(std::size_t r) {
        Bus& bus = buses_[r];
        const NaiveBurst& burst = frame_log(r)->bursts[bus.burst];
        ask_for_slot(r);
        REQUIRE(bus.slot.cycle != kNever);
        REQUIRE(bus.slot.cycle <= burst.granted);
        ++met_.bursts;
        go_on(r);
    }

    void look_again(std::size_t r) {
        Bus& bus = buses_[r];
        const NaiveBurst& burst = frame_log(r)->bursts[bus.burst];
        const NaiveBeat& beat = burst.beats[bus.beat - 1];
        REQUIRE(bus.buffer->newest_arrival_cycle() == beat.cycle + 1);
        REQUIRE(bus.buffer->planned_pixels() == beat.first_pixel + beat.pixels);
        const auto verdict = bus.buffer->busready_in_burst(
            {bus.buffer->planned_pixels(), bus.buffer->newest_arrival_cycle(), beat.remaining}, now_);
        REQUIRE(verdict != tlm::BufferTime::Verdict::kUndecided);
        check_verdict(r, beat, verdict);
        go_on(r);
    }

    void check_verdict(std::size_t r, const NaiveBeat& beat, tlm::BufferTime::Verdict verdict) {
        const NaiveBurst& burst = frame_log(r)->bursts[buses_[r].burst];
        INFO("beat on the bus in clock " << beat.cycle << ", drop at " << burst.drop_clock);
        const bool dropped = burst.drop_clock == beat.cycle + 1;
        REQUIRE((verdict == tlm::BufferTime::Verdict::kDropped) == dropped);
        if (dropped) {
            ++met_.drops;
            buses_[r].buffer->count_drop(beat.cycle + 1);
        }
    }

    /// The rest of a burst, run by run, as far as BUSREADY is known.
    void go_on(std::size_t r) {
        Bus& bus = buses_[r];
        const NaiveBurst& burst = frame_log(r)->bursts[bus.burst];
        const bool may_cut = bus.buffer->config().ready_space_pixels < burst.wanted_pixels;
        REQUIRE((may_cut || burst.drop_clock < 0));
        while (bus.beat < burst.beats.size()) {
            const NaiveBeat& first = burst.beats[bus.beat];
            tlm::BeatRun run{first.first_pixel, 0, first.cycle};
            bool undecided = false;
            do {
                const NaiveBeat& beat = burst.beats[bus.beat++];
                run.pixels += beat.pixels;
                // Beats on their way when BUSREADY falls are sent without another check of it.
                const bool looks = may_cut && (burst.drop_clock < 0 || beat.cycle < burst.drop_clock);
                if (looks) {
                    const auto verdict = bus.buffer->busready_in_burst(
                        {run.first_pixel + run.pixels, beat.cycle + 1, beat.remaining}, now_);
                    undecided = verdict == tlm::BufferTime::Verdict::kUndecided;
                    if (!undecided) check_verdict(r, beat, verdict);
                }
                if (undecided || (looks && burst.drop_clock == beat.cycle + 1)) break;
            } while (bus.beat < burst.beats.size() && !burst.beats[bus.beat].starts_run);
            bus.buffer->add(run, burst.granted, now_);
            REQUIRE(bus.buffer->planned_pixels() == run.first_pixel + run.pixels);
            REQUIRE(bus.buffer->newest_arrival_cycle() == burst.beats[bus.beat - 1].cycle + 1);
            try_start();
            if (setup_.stall && column_.started(static_cast<int>(bus.frame))) {
                column_.advance(now_);
                column_.tell();
            }
            if (undecided) {
                ++met_.undecided;
                return;
            }
        }
        end_burst(r, burst);
    }

    void end_burst(std::size_t r, const NaiveBurst& burst) {
        Bus& bus = buses_[r];
        const NaiveBeat& last = burst.beats.back();
        if (burst.drop_clock >= 0) {
            bus.earliest = std::max(burst.drop_clock, last.cycle) + 2;
        } else {
            const tlm::BufferTime::Config& config = bus.buffer->config();
            const bool trusted =
                burst.beats.size() > 1 && config.capacity_pixels - last.pixels >= config.ready_space_pixels;
            bus.earliest = last.cycle + (trusted ? 1 : 2);
        }
        bus.beat = 0;
        if (++bus.burst == frame_log(r)->bursts.size()) {
            next_frame(bus);
        } else {
            ask_for_slot(r);
        }
    }

    // ---- the pipeline side ----

    void report_pipeready() {
        column_.set_pipeready_cycle(log_.pipeready[static_cast<std::size_t>(frames_composited_)]);
        pipeready_told_ = true;
        pipeready_event_ = kNever;
        try_start();
    }

    void try_start() {
        const int frame = column_.newest_frame() + 1;
        if (!pipeready_told_ || frame >= setup_.frames) return;
        std::int64_t pipeready = log_.pipeready[static_cast<std::size_t>(frame)];
        for (std::size_t r = buses_.size(); r-- > 0;) {
            const std::int64_t prefetched = buses_[r].buffer->prefetched_cycle(frame);
            if (prefetched == kNever) return;
            INFO("composer " << r << ", prefetched with frame " << frame);
            REQUIRE(prefetched == log_.composers[r].frames[static_cast<std::size_t>(frame)].prefetched);
            pipeready = std::max(prefetched, pipeready + 1);
        }
        pipeready_told_ = false;
        INFO("start of frame " << frame);
        REQUIRE(pipeready + 1 == log_.steps[static_cast<std::size_t>(frame)].front());
        column_.start(frame, pipeready + 1);
        for (Bus& bus : buses_) bus.buffer->start_frame(frame);
        if (setup_.stall) column_.advance(now_);
        column_.tell();
    }

    void take_composited() {
        const int frame = column_.newest_frame();
        column_.note_composited();
        const std::vector<std::int64_t>& steps = log_.steps[static_cast<std::size_t>(frame)];
        REQUIRE(column_.first_pixel_cycle(frame) == steps[1]);
        REQUIRE(column_.last_pixel_cycle(frame) == steps[steps.size() - 2]);
        for (std::size_t r = 0; r < buses_.size(); ++r) {
            buses_[r].buffer->close_frame(frame, column_.raster_pixels(), now_);
            check_starved(r, frame, kNever);
        }
        ++frames_composited_;
        if (frames_composited_ < setup_.frames) {
            pipeready_event_ = log_.pipeready[static_cast<std::size_t>(frames_composited_)];
            if (random_.one_in(2)) report_pipeready();
        }
    }

    // ---- checks ----

    const std::vector<std::int64_t>& steps_of(int frame) const {
        return log_.steps[static_cast<std::size_t>(frame)];
    }

    void check_column() {
        const int newest = column_.newest_frame();
        INFO("newest frame " << newest << ", now " << now_);
        const std::int64_t known = column_.known_through(now_);
        if (newest + 1 < setup_.frames) {
            REQUIRE(steps_of(newest + 1).front() > known);
            const std::int64_t step = random_.between(0, static_cast<int>(column_.last_step()));
            REQUIRE(column_.not_before(newest + 1, step, now_) <=
                    steps_of(newest + 1)[static_cast<std::size_t>(step)]);
            if (random_.one_in(4)) wait_for(newest + 1, step);
        }
        if (newest < 0) return;
        const std::vector<std::int64_t>& steps = steps_of(newest);
        const tlm::FrameTime& time = column_.frame(newest);
        const std::int64_t last_known = std::min(time.last_known_step(), column_.last_step());
        for (int i = 0; i < 4; ++i) {
            const std::int64_t step = random_.between(0, static_cast<int>(column_.last_step()));
            const std::int64_t cycle = steps[static_cast<std::size_t>(step)];
            INFO("step " << step << ", last known " << last_known);
            REQUIRE(column_.not_before(newest, step, now_) <= cycle);
            REQUIRE(time.extrapolated_cycle(step) <= cycle);
            REQUIRE(time.cycle_of(step) == (step <= last_known ? cycle : kNever));
            REQUIRE((step <= last_known || cycle > known));
        }
        const std::int64_t last_cycle = steps[static_cast<std::size_t>(last_known)];
        const auto back = static_cast<int>(last_cycle - steps.front() + 3);
        const std::int64_t cycle = last_cycle - random_.between(0, back);
        INFO("clock " << cycle);
        const auto behind = std::upper_bound(steps.begin(), steps.end(), cycle);
        REQUIRE(time.step_at(cycle) == behind - steps.begin() - 1);
    }

    void wait_for(int frame, std::int64_t step) {
        waiting_.push_back({frame, step, false});
        const std::size_t index = waiting_.size() - 1;
        column_.when_known(frame, step, [this, index] {
            REQUIRE_FALSE(waiting_[index].told);
            waiting_[index].told = true;
            ++met_.callbacks;
            REQUIRE(column_.frame(waiting_[index].frame).cycle_of(waiting_[index].step) ==
                    steps_of(waiting_[index].frame)[static_cast<std::size_t>(waiting_[index].step)]);
        });
        column_.tell();
    }

    void check_waiters() {
        for (const Waiting& waiting : waiting_) {
            const bool known = column_.started(waiting.frame) &&
                               (waiting.frame < column_.newest_frame() ||
                                column_.frame(waiting.frame).cycle_of(waiting.step) != kNever);
            REQUIRE(waiting.told == known);
        }
    }

    void check_level(std::size_t r, std::int64_t cycle, int held) {
        const std::vector<int>& truth = log_.composers[r].held;
        // After the last clock simulated everything has been released.
        const int wanted =
            cycle < static_cast<std::int64_t>(truth.size()) ? truth[static_cast<std::size_t>(cycle)] : 0;
        ++met_.levels;
        if (held != wanted) {
            ++met_.wrong_levels;
            if (met_.first_wrong_level.empty()) {
                met_.first_wrong_level = "composer " + std::to_string(r) + ", clock " +
                                         std::to_string(cycle) + ": " + std::to_string(held) + " told, " +
                                         std::to_string(wanted) + " held";
            }
        }
        met_.unordered_levels += cycle < buses_[r].newest_level ? 1 : 0;
        buses_[r].newest_level = cycle;
    }

    /// The runs of a closed frame against the pixels that starved up to a clock.
    void check_starved(std::size_t r, int frame, std::int64_t through) {
        std::vector<StarvedRun> wanted;
        for (const NaiveStarved& pixel : log_.composers[r].starved) {
            if (pixel.frame != frame || pixel.clock > through) continue;
            if (!wanted.empty() && wanted.back().y == pixel.y && wanted.back().x_last + 1 == pixel.x) {
                ++wanted.back().x_last;
            } else {
                wanted.push_back({frame, pixel.y, pixel.x, pixel.x});
            }
        }
        INFO("composer " << r << ", starved in frame " << frame);
        REQUIRE(buses_[r].buffer->starved(frame) == wanted);
    }

    static std::int64_t through(const std::vector<std::int64_t>& clocks, std::int64_t end) {
        return std::count_if(clocks.begin(), clocks.end(),
                             [end](std::int64_t clock) { return clock <= end; });
    }

    void finish() {
        INFO("the run ends after clock " << end_);
        REQUIRE(column_.stalled_cycles(end_) == through(log_.stalls, end_));
        for (std::size_t r = 0; r < buses_.size(); ++r) {
            INFO("composer " << r);
            tlm::BufferTime& buffer = *buses_[r].buffer;
            const NaiveComposerLog& log = log_.composers[r];
            const int started = column_.newest_frame();
            const int begun = static_cast<int>(buses_[r].frame) - (buses_[r].table_sent ? 0 : 1);
            for (int frame = std::max(0, begun - 1); frame <= begun; ++frame) {
                const auto arrived =
                    std::count_if(log.arrivals.begin(), log.arrivals.end(), [&](const NaiveArrival& arrival) {
                        return arrival.frame == frame && arrival.clock <= end_;
                    });
                INFO("arrived of frame " << frame);
                REQUIRE(buffer.arrived(frame, end_) == arrived);
            }
            if (started >= 0) {
                const std::int64_t position =
                    column_.frame(started).step_at(end_) - static_cast<std::int64_t>(r);
                buffer.close_frame(started, std::clamp<std::int64_t>(position, 0, column_.raster_pixels()),
                                   end_);
                check_starved(r, started, end_);
            }
            const std::int64_t stalled = column_.stalled_cycles_for(static_cast<int>(r), end_);
            const ComposerCounters& counters = buffer.finish(end_, stalled);
            ComposerCounters wanted;
            for (const NaiveStarved& pixel : log.starved) {
                if (pixel.clock <= end_) wanted.add_starved_pixel({pixel.frame, pixel.x, pixel.y});
            }
            REQUIRE(counters.starved_pixels == wanted.starved_pixels);
            REQUIRE(counters.starved_run_count == wanted.starved_run_count);
            REQUIRE(counters.starved_runs == wanted.starved_runs);
            REQUIRE(counters.first_glitch == wanted.first_glitch);
            REQUIRE(counters.last_glitch == wanted.last_glitch);
            REQUIRE(counters.late_pixels == through(log.late, end_));
            REQUIRE(counters.replayed_pixels == through(log.replayed, end_));
            REQUIRE(counters.busready_drops == through(log.drops, end_));
            REQUIRE(counters.stalled_cycles == through(log.stalls, end_));
            int high_water = 0;
            for (std::int64_t clock = 0; clock < static_cast<std::int64_t>(log.held.size()) && clock <= end_;
                 ++clock) {
                high_water = std::max(high_water, log.held[static_cast<std::size_t>(clock)]);
            }
            REQUIRE(counters.buffer_high_water == high_water);
            met_.starved += counters.starved_pixels;
            met_.late += counters.late_pixels;
            met_.replayed += counters.replayed_pixels;
            met_.stalled += counters.stalled_cycles;
        }
    }

    struct Waiting {
        int frame;
        std::int64_t step;
        bool told;
    };

    const NaiveSetup& setup_;
    const NaiveColumnLog& log_;
    std::int64_t end_;
    Random random_;
    tlm::ColumnTime column_;
    std::vector<Bus> buses_;
    std::int64_t now_ = 0;
    int frames_composited_ = 0;
    bool pipeready_told_ = false;
    std::int64_t pipeready_event_ = kNever;
    std::deque<Waiting> waiting_;
    Met met_;
};

/// A random column, its buses, and what they send.
struct SetupRange {
    int most_composers = 4;
    int most_frames = 4;
    int largest_width = 14;
    int largest_height = 10;
    int largest_multiple = 4;
    bool stall = false;
    Smoothing smoothing = Smoothing::kReplicate;
    int most_spare_pixels = 60;  ///< of a buffer, beyond what it must have
    int least_ready_beats = 2;
    int most_ready_beats = 6;
    int least_delay = 0;        ///< clocks of other composers' bursts, at most; with them a bus is slow
    bool tight_bursts = false;  ///< bursts longer than the ready space
};

inline NaiveSetup random_setup(Random& random, const SetupRange& range) {
    NaiveSetup setup;
    setup.stall = range.stall;
    setup.smoothing = range.smoothing;
    setup.raster = {random.between(1, range.largest_width), random.between(1, range.largest_height)};
    setup.frames = random.between(1, range.most_frames);
    setup.longest_swap = random.one_in(2) ? 3 : 200;
    const int composers = random.between(1, range.most_composers);
    for (int r = 0; r < composers; ++r) {
        NaiveComposerSetup composer;
        if (random.one_in(3)) {
            composer.cycles_per_beat = random.one_in(2) ? 2 : 4;
        } else {
            composer.pixels_per_beat = random.between(1, 8);
        }
        composer.ready_space_pixels =
            random.between(range.least_ready_beats, range.most_ready_beats) * composer.pixels_per_beat +
            random.between(0, composer.pixels_per_beat - 1);
        int needed = composer.ready_space_pixels;
        for (int frame = 0; frame < setup.frames; ++frame) {
            if (random.one_in(6)) {
                composer.rows.emplace_back();
                continue;
            }
            const ViewportRow row = range.smoothing == Smoothing::kBilinear
                                        ? random_smoothed_row(random, setup.raster, range.largest_multiple)
                                        : random_valid_row(random, setup.raster, range.largest_multiple);
            composer.rows.emplace_back(row);
            needed = std::max(
                needed, composer.ready_space_pixels + window_rows(range.smoothing, row.dmultiple) * row.sdx);
        }
        composer.capacity_pixels =
            needed + (random.one_in(3) ? 0 : random.between(0, range.most_spare_pixels));
        composer.burst_pixels = range.tight_bursts ? composer.ready_space_pixels + random.between(1, 40)
                                                   : random.between(1, 2 * composer.ready_space_pixels);
        composer.longest_run = random.between(1, 8);
        composer.longest_gap = random.one_in(2) ? random.between(0, 3) : random.between(0, 12);
        composer.longest_delay = range.least_delay + (random.one_in(2) ? 0 : random.between(0, 30));
        composer.longest_pause = random.one_in(2) ? 2 : 100;
        setup.composers.push_back(composer);
    }
    return setup;
}

/// Replays random columns. The ends of the runs are random too; every other one lies after all events.
inline ColumnReplay::Met replay_random_columns(std::uint64_t seed, int cases, const SetupRange& range) {
    Random random(seed);
    ColumnReplay::Met met;
    for (int i = 0; i < cases; ++i) {
        const NaiveSetup setup = random_setup(random, range);
        const NaiveColumnLog log = NaiveColumn(setup, random.bits()).run();
        INFO("case " << i << ": " << setup.composers.size() << " composers, " << setup.frames
                     << " frames, raster " << setup.raster.width << " x " << setup.raster.height << ", "
                     << log.clocks << " clocks");
        REQUIRE(log.finished);
        const std::int64_t end =
            random.one_in(2) ? log.clocks + 5 : random.between(0, static_cast<int>(log.clocks));
        ColumnReplay replay(setup, log, end, random.bits());
        replay.run();
        met += replay.met();
        if (met.wrong_levels > 0 && met.first_wrong_level.rfind("case", 0) != 0) {
            met.first_wrong_level = "case " + std::to_string(i) + ", " + met.first_wrong_level;
        }
    }
    return met;
}

}  // namespace metabuffer::test
