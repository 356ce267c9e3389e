#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "formats/viewport_table.h"
#include "support/painted_segment.h"
#include "support/random_seed.h"

/// A column of composers and their buses, clock by clock, written from the rules in docs/design.md alone. What level
/// tlm computes is compared with what happens here.
namespace metabuffer::test {

struct NaiveComposerSetup {
    int capacity_pixels = 0;
    int ready_space_pixels = 0;
    int pixels_per_beat = 1;
    int cycles_per_beat = 1;
    int burst_pixels = 1;
    std::vector<std::optional<ViewportRow>> rows;  ///< by frame; none: no segment here
    // How the bus behaves.
    int longest_run = 1;    ///< beats until the next page
    int longest_gap = 0;    ///< clocks that opening it takes
    int longest_delay = 0;  ///< clocks of other composers' bursts before one of this
    int longest_pause = 0;  ///< clocks before a table
};

struct NaiveSetup {
    Size raster;
    bool stall = false;
    Smoothing smoothing = Smoothing::kReplicate;
    int frames = 1;
    int longest_swap = 0;  ///< clocks from the last pixel to the next PIPEREADY
    std::vector<NaiveComposerSetup> composers;
};

struct NaiveBeat {
    std::int64_t first_pixel = 0;
    int pixels = 0;
    std::int64_t cycle = 0;  ///< on the bus; sampled one clock later
    int remaining = 0;       ///< pixels of the burst after it, if it is not stopped
    bool starts_run = false;
};

struct NaiveBurst {
    std::int64_t slot_clock = -1;  ///< the first arbitration that could have given the slot
    std::int64_t granted = 0;
    int wanted_pixels = 0;
    std::vector<NaiveBeat> beats;
    std::int64_t drop_clock = -1;  ///< BUSREADY fell in the burst
};

struct NaiveFrameLog {
    std::int64_t table_sent = -1;
    std::int64_t table_cycle = -1;  ///< the composer knows the whole table
    std::int64_t prefetched = -1;
    std::vector<NaiveBurst> bursts;
};

struct NaiveStarved {
    std::int64_t clock = 0;
    int frame = 0;
    int x = 0;
    int y = 0;
};

struct NaiveArrival {
    std::int64_t clock = 0;
    int frame = 0;
};

/// What one composer did, with the clock of each event.
struct NaiveComposerLog {
    std::vector<NaiveFrameLog> frames;
    std::vector<NaiveStarved> starved;
    std::vector<std::int64_t> replayed;
    std::vector<std::int64_t> late;
    std::vector<std::int64_t> drops;
    std::vector<std::int64_t> stalls;
    std::vector<NaiveArrival> arrivals;  ///< pixel by pixel
    std::vector<int> held;               ///< at the end of each clock
};

struct NaiveColumnLog {
    std::vector<std::vector<std::int64_t>> steps;  ///< by frame: the clock of each step
    std::vector<std::int64_t> pipeready;           ///< by frame: of the output framebuffer
    std::vector<std::int64_t> stalls;
    std::vector<NaiveComposerLog> composers;
    std::int64_t clocks = 0;
    bool finished = false;
};

class NaiveColumn {
  public:
    NaiveColumn(const NaiveSetup& setup, std::uint64_t seed) : setup_(setup), random_(seed) {
        for (const NaiveComposerSetup& composer : setup_.composers) {
            composers_.emplace_back();
            composers_.back().setup = &composer;
            composers_.back().pause = 3 + random_.between(0, composer.longest_pause);
        }
        log_.composers.resize(setup_.composers.size());
        pipeready_at_ = 2;
    }

    NaiveColumnLog run() {
        constexpr std::int64_t kFarTooLong = 100'000;
        while (!finished() && clock_ < kFarTooLong) {
            tick();
            ++clock_;
        }
        log_.clocks = clock_;
        log_.finished = finished();
        return log_;
    }

  private:
    enum class State { kWaiting, kHeld, kGone };
    struct Frame {
        int number = 0;
        bool has_row = false;
        std::shared_ptr<PaintedSegment> painted;
        std::vector<State> pixels;
        std::int64_t arrived = 0;
        bool table_complete = false;
        bool prefetched = false;
    };
    struct Wires {
        bool busready = false;
        bool tableready = false;
        bool startframe = false;
        bool pipeready = false;
        bool stall = false;
    };
    struct Composer {
        const NaiveComposerSetup* setup = nullptr;
        Wires wires;
        // Pipeline and buffer.
        bool running = false;
        bool was_running = false;
        std::int64_t position = 0;
        int composited_frames = 0;
        std::deque<std::shared_ptr<Frame>> kept;
        std::shared_ptr<Frame> receiving;
        int held = 0;
        int announced = 0;
        bool cut = false;
        // Its bus.
        enum class Bus { kPause, kTable, kSend, kDone } bus = Bus::kPause;
        int pause = 0;
        int next_table = 0;
        std::int64_t table_ends = 0;
        std::int64_t left = 0;  ///< pixels of the frame
        std::int64_t next_pixel = 0;
        int burst_left = 0;
        bool in_burst = false;
        int beats_of_burst = 0;
        bool stopped_moving = false;
        int gap = 0;
        int run_left = 0;
        int moving = 0;  ///< clocks until the beat is on the bus
        int delay = 0;
        bool pass_over = false;
        int told = 0;  ///< pixels announced after the newest beat; below: one and two clocks ago
        int told_before = 0;
        int told_seen = 0;
        std::int64_t slot_clock = -1;
        bool starts_run = false;
        NaiveBeat beat;  ///< being moved
        std::optional<NaiveBeat> on_bus;
        bool start_on_bus = false;
        int beat_remaining = 0;  ///< what the beat on the bus announces
    };

    std::int64_t raster_pixels() const { return std::int64_t{setup_.raster.width} * setup_.raster.height; }
    bool finished() const {
        return static_cast<int>(frames_out_) == setup_.frames &&
               std::all_of(composers_.begin(), composers_.end(),
                           [](const Composer& c) { return c.bus == Composer::Bus::kDone && !c.on_bus; });
    }

    void tick() {
        std::vector<Wires> before;
        for (Composer& composer : composers_) before.push_back(composer.wires);
        const bool output_pipeready = output_pipeready_;
        const bool standing =
            setup_.stall && std::any_of(before.begin(), before.end(), [](const Wires& w) { return w.stall; });
        if (standing) log_.stalls.push_back(clock_);
        for (std::size_t r = 0; r < composers_.size(); ++r) {
            composers_[r].was_running = composers_[r].running;
            if (standing) {
                if (before[r].stall) log_.composers[r].stalls.push_back(clock_);
                continue;
            }
            const bool start =
                !composers_[r].running && (r == 0 ? before[0].pipeready : before[r - 1].startframe);
            if (composers_[r].running) composite(r);
            if (start) {
                composers_[r].running = true;
                composers_[r].position = 0;
                release(composers_[r], -1);  // what no position needs
            }
            composers_[r].wires.startframe = start;
            if (start && r == 0) log_.steps.emplace_back();
        }
        if (!standing && !log_.steps.empty() &&
            log_.steps.back().size() <= composers_.size() + static_cast<std::size_t>(raster_pixels())) {
            log_.steps.back().push_back(clock_);
        }
        output_clock(standing, before.back().startframe);
        for (std::size_t r = 0; r < composers_.size(); ++r) {
            sample_bus(r);
            const bool below = r + 1 < composers_.size() ? before[r + 1].pipeready : output_pipeready;
            drive_wires(r, below);
            bus_clock(r, before[r]);
            log_.composers[r].held.push_back(composers_[r].held);
        }
    }

    // ---- pipeline ----

    void composite(std::size_t r) {
        Composer& c = composers_[r];
        Frame& frame = *c.kept.front();
        if (frame.has_row) {
            const RasterStep& step = frame.painted->steps[static_cast<std::size_t>(c.position)];
            if (step.covered) {
                const std::int64_t newest = frame.painted->newest[static_cast<std::size_t>(c.position)];
                const State state = frame.pixels[static_cast<std::size_t>(newest)];
                const auto x = static_cast<int>(c.position % setup_.raster.width);
                const auto y = static_cast<int>(c.position / setup_.raster.width);
                if (state == State::kWaiting) {
                    log_.composers[r].starved.push_back({clock_, frame.number, x, y});
                } else if (step.replayed) {
                    log_.composers[r].replayed.push_back(clock_);
                }
                release(c, c.position);
            }
        }
        if (++c.position == raster_pixels()) {
            c.running = false;
            c.kept.pop_front();
        }
    }

    /// The pixels of the frame composited whose last use that position is.
    static void release(Composer& c, std::int64_t position) {
        Frame& frame = *c.kept.front();
        for (std::size_t k = 0; k < frame.pixels.size(); ++k) {
            if (frame.painted->last[k] != position) continue;
            if (frame.pixels[k] == State::kHeld) --c.held;
            frame.pixels[k] = State::kGone;
        }
    }

    void output_clock(bool standing, bool startframe) {
        if (!standing) {
            if (receiving_) {
                if (++output_position_ == raster_pixels()) {
                    receiving_ = false;
                    ++frames_out_;
                    pipeready_at_ = clock_ + 1 + random_.between(0, setup_.longest_swap);
                }
            } else if (startframe) {
                receiving_ = true;
                output_position_ = 0;
                output_pipeready_ = false;
            }
        }
        if (clock_ == pipeready_at_) {
            output_pipeready_ = true;
            log_.pipeready.push_back(clock_);
        }
    }

    // ---- buffer ----

    void sample_bus(std::size_t r) {
        Composer& c = composers_[r];
        if (c.start_on_bus) {
            c.start_on_bus = false;
            c.receiving = std::make_shared<Frame>();
            c.receiving->number = c.next_table - 1;
            const auto& row = c.setup->rows[static_cast<std::size_t>(c.receiving->number)];
            if (row) {
                c.receiving->has_row = true;
                c.receiving->painted =
                    std::make_shared<PaintedSegment>(*row, setup_.raster, setup_.smoothing);
                c.receiving->pixels.assign(c.receiving->painted->last.size(), State::kWaiting);
            }
            c.kept.push_back(c.receiving);
        }
        if (c.receiving && clock_ >= c.table_ends + 1) c.receiving->table_complete = true;
        if (c.on_bus) {
            Frame& frame = *c.receiving;
            for (int i = 0; i < c.on_bus->pixels; ++i) {
                State& state = frame.pixels[static_cast<std::size_t>(frame.arrived++)];
                log_.composers[r].arrivals.push_back({clock_, frame.number});
                if (state == State::kGone) {
                    log_.composers[r].late.push_back(clock_);
                } else {
                    state = State::kHeld;
                    ++c.held;
                }
            }
            c.announced = c.beat_remaining;
            c.on_bus.reset();
        }
    }

    void drive_wires(std::size_t r, bool pipeready_below) {
        Composer& c = composers_[r];
        const int free = c.setup->capacity_pixels - c.held;
        if (c.cut) {
            c.cut = false;
            c.announced = 0;
        }
        if (c.announced > c.setup->pixels_per_beat) {
            c.wires.busready = free >= std::min(c.announced, 2 * c.setup->pixels_per_beat);
            if (!c.wires.busready) {
                c.cut = true;
                log_.composers[r].drops.push_back(clock_);
                log_.composers[r].frames.back().bursts.back().drop_clock = clock_;
            }
        } else {
            c.wires.busready = free - c.announced >= c.setup->ready_space_pixels;
        }
        c.wires.tableready = c.kept.size() < 2;
        for (const auto& frame : c.kept) {
            // What the frame before it holds is released before this one can start.
            const bool full =
                c.setup->capacity_pixels - static_cast<int>(frame->arrived) < c.setup->ready_space_pixels;
            const bool whole =
                !frame->has_row || frame->arrived == static_cast<std::int64_t>(frame->pixels.size());
            if (frame->table_complete && !frame->prefetched && (whole || full)) {
                frame->prefetched = true;
                log_.composers[r].frames[static_cast<std::size_t>(frame->number)].prefetched = clock_;
            }
        }
        bool prefetched = false;
        if (!c.running && !c.kept.empty() && c.kept.front()->table_complete) {
            const Frame& frame = *c.kept.front();
            prefetched = !frame.has_row || frame.arrived == static_cast<std::int64_t>(frame.pixels.size()) ||
                         free < c.setup->ready_space_pixels;
        }
        c.wires.pipeready = !c.running && !c.was_running && !c.wires.startframe &&
                            (c.wires.pipeready || (prefetched && pipeready_below));
        c.wires.stall = false;
        if (c.running && c.kept.front()->has_row) {
            const std::int64_t k = c.kept.front()->painted->newest[static_cast<std::size_t>(c.position)];
            c.wires.stall = k != PaintedSegment::kNone &&
                            c.kept.front()->pixels[static_cast<std::size_t>(k)] == State::kWaiting;
        }
    }

    // ---- bus ----

    void bus_clock(std::size_t r, const Wires& wires) {
        Composer& c = composers_[r];
        switch (c.bus) {
            case Composer::Bus::kPause:
                if (c.pause > 0) {
                    --c.pause;
                    return;
                }
                if (!wires.tableready) return;
                send_table(r);
                return;
            case Composer::Bus::kTable:
                if (clock_ <= c.table_ends) return;
                c.bus = Composer::Bus::kSend;
                break;
            case Composer::Bus::kSend:
                break;
            case Composer::Bus::kDone:
                return;
        }
        send_clock(r, wires);
    }

    void send_table(std::size_t r) {
        Composer& c = composers_[r];
        NaiveFrameLog frame;
        frame.table_sent = clock_;
        c.table_ends = clock_ + random_.between(0, 3);
        frame.table_cycle = c.table_ends + 1;
        log_.composers[r].frames.push_back(frame);
        const auto& row = c.setup->rows[static_cast<std::size_t>(c.next_table++)];
        c.left = row ? std::int64_t{row->sdx} * row->sdy : 0;
        c.next_pixel = 0;
        c.start_on_bus = true;
        c.slot_clock = -1;
        c.told = c.told_before = 0;
        c.delay = random_.between(0, c.setup->longest_delay);
        c.bus = Composer::Bus::kTable;
    }

    void send_clock(std::size_t r, const Wires& wires) {
        Composer& c = composers_[r];
        c.told_seen = c.told_before;
        c.told_before = c.told;
        const bool passed_over = c.pass_over;
        c.pass_over = false;
        // BUSREADY is the answer to what was announced to the composer two clocks ago.
        if (c.in_burst && c.told_seen > c.setup->pixels_per_beat && !wires.busready) {
            c.stopped_moving = c.moving > 0;
            c.in_burst = false;
            c.burst_left = 0;
            c.told = 0;
            c.gap = 0;
        }
        if (c.moving > 0) {
            if (--c.moving == 0) put_on_bus(r);
            return;
        }
        if (!c.in_burst) {
            if (c.left == 0) {
                if (c.next_table == setup_.frames) {
                    c.bus = Composer::Bus::kDone;
                } else {
                    c.bus = Composer::Bus::kPause;
                    c.pause = random_.between(0, c.setup->longest_pause);
                }
                return;
            }
            const bool may_have_it = wires.busready && !passed_over;
            if (may_have_it && c.slot_clock < 0) c.slot_clock = clock_;
            if (c.delay > 0) {
                --c.delay;
                return;
            }
            if (!may_have_it) return;
            grant(r);
        }
        if (c.gap > 0) {
            --c.gap;
            return;
        }
        start_beat(r);
    }

    void grant(std::size_t r) {
        Composer& c = composers_[r];
        NaiveBurst burst;
        burst.slot_clock = c.slot_clock;
        burst.granted = clock_;
        c.slot_clock = -1;
        c.in_burst = true;
        c.burst_left = static_cast<int>(std::min<std::int64_t>(c.setup->burst_pixels, c.left));
        c.beats_of_burst = 0;
        burst.wanted_pixels = c.burst_left;
        log_.composers[r].frames.back().bursts.push_back(burst);
        next_run(c);
    }

    void next_run(Composer& c) {
        c.run_left = random_.between(1, c.setup->longest_run * c.setup->pixels_per_beat);
        c.gap = random_.between(0, c.setup->longest_gap);
        c.starts_run = true;
    }

    void start_beat(std::size_t r) {
        Composer& c = composers_[r];
        c.beat = NaiveBeat{};
        c.beat.first_pixel = c.next_pixel;
        c.beat.pixels = std::min({c.setup->pixels_per_beat, c.run_left, c.burst_left});
        c.beat.starts_run = c.starts_run;
        c.starts_run = false;
        c.next_pixel += c.beat.pixels;
        c.left -= c.beat.pixels;
        c.run_left -= c.beat.pixels;
        c.burst_left -= c.beat.pixels;
        c.beat.remaining = c.burst_left;
        if (c.run_left == 0) next_run(c);
        c.moving = c.setup->cycles_per_beat - 1;
        if (c.moving == 0) put_on_bus(r);
    }

    void put_on_bus(std::size_t r) {
        Composer& c = composers_[r];
        c.beat.cycle = clock_;
        c.on_bus = c.beat;
        c.beat_remaining = c.burst_left;
        c.told = c.burst_left;
        ++c.beats_of_burst;
        log_.composers[r].frames.back().bursts.back().beats.push_back(c.beat);
        if (c.burst_left == 0) {
            c.pass_over = c.beats_of_burst == 1 || c.stopped_moving;
            c.stopped_moving = false;
            c.in_burst = false;
            c.delay = random_.between(0, c.setup->longest_delay);
        }
    }

    NaiveSetup setup_;
    Random random_;
    std::int64_t clock_ = 0;
    std::vector<Composer> composers_;
    bool receiving_ = false;
    bool output_pipeready_ = false;
    std::int64_t output_position_ = 0;
    std::int64_t pipeready_at_ = 0;
    int frames_out_ = 0;
    NaiveColumnLog log_;
};

}  // namespace metabuffer::test
