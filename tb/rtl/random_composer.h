#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "expected_report.h"
#include "lockstep/lockstep.h"
#include "monitors/bus_timing.h"
#include "monitors/composer_observer.h"
#include "monitors/delay_line.h"
#include "pixel_beat.h"
#include "report/counters.h"
#include "rtl/composer.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "support/scenarios.h"

namespace metabuffer::test {

/// Depths that meet or are the farthest, alphas and channels whose products lie where rounding changes, and any others.
inline Pixel random_pixel(Random& random) {
    const std::uint64_t bits = random.bits();
    const auto channel = [bits](int shift) { return static_cast<std::uint8_t>(bits >> shift); };
    const std::array<std::uint32_t, 6> depths{0,      1,         0xFFFE,
                                              0xFFFF, 0xFF'FFFF, static_cast<std::uint32_t>(bits >> 40)};
    const std::array<std::uint8_t, 6> alphas{0, 128, 254, 255, channel(24), channel(24)};
    const std::array<std::uint8_t, 4> reds{1, 127, channel(0), channel(0)};
    return {one_of(random, reds), channel(8), channel(16), one_of(random, alphas), one_of(random, depths)};
}

/// How a bus behaves. What happens, happens once in so many clocks or beats, or never if that is 0.
struct BusHabits {
    int slowness = 0;            ///< the most clocks between two bursts
    int laziness = 4;            ///< nothing new begins
    int pixel_beats_a_loss = 0;  ///< that do not arrive
    int table_beats_a_loss = 0;
    int clocks_to_blackout = 0;    ///< nothing arrives for some time
    int clocks_to_wrong_beat = 0;  ///< one that no protocol allows
};

/// An input framebuffer and the bus to one of its composers. It keeps the protocol of docs/design.md and otherwise does
/// everything that it may: frames with and without a segment for the composer, bursts and beats of any length, gaps as of
/// page misses, other composers' traffic.
class RandomBus {
  public:
    RandomBus(const Scenario& scenario, int display, const BusHabits& habits, Random& random)
        : scenario_(scenario),
          display_(display),
          habits_(habits),
          random_(random),
          timing_(scenario),
          loop_(static_cast<int>(timing_.loop_cycles)),
          busready_(1 + scenario.bus.register_stages),
          tableready_(1 + scenario.bus.register_stages),
          answered_(loop_),
          to_composer_(scenario.memory.read_latency_cycles + scenario.bus.register_stages) {}

    void reset() {
        busready_.fill(false);
        tableready_.fill(false);
        answered_.fill(0);
        to_composer_.fill({});
        table_.clear();
        burst_ = beat_left_ = pause_ = idle_ = left_ = announced_ = uncounted_ = table_uncounted_ =
            blackout_ = 0;
        judged_ = 0;
        bursting_ = first_beat_ = stopped_ = false;
        frame_ = -1;
        next_ = 0;
    }

    /// What the composer's next edge samples. releases: that edge may make room in the composer. resting: nothing new
    /// begins.
    rtl::BusBeat edge(const monitors::ComposerObserver& composer, bool releases, bool resting) {
        const bool busready = busready_.pass(composer.expected().busready);
        const bool tableready = tableready_.pass(composer.expected().tableready);
        const rtl::BusBeat beat = to_composer_.pass(send(busready, tableready, resting));
        wrong_ = false;
        if (beat.kind == rtl::BusBeat::Kind::kNone) {
            return habits_.clocks_to_wrong_beat > 0 && random_.one_in(habits_.clocks_to_wrong_beat)
                       ? wrong_beat(composer, releases)
                       : beat;
        }
        if (blackout_ == 0 && habits_.clocks_to_blackout > 0 && random_.one_in(habits_.clocks_to_blackout)) {
            blackout_ = random_.between(1, 80);
        }
        if (blackout_ > 0) --blackout_;
        const int beats_a_loss = beat.kind == rtl::BusBeat::Kind::kPixels ? habits_.pixel_beats_a_loss
                                                                          : habits_.table_beats_a_loss;
        const bool lost = blackout_ > 0 || (beats_a_loss > 0 && random_.one_in(beats_a_loss));
        if (lost) return {};
        note_delivered(beat);
        return beat;
    }
    /// The last beat breaks the protocol: the composer must report it.
    bool wrong() const { return wrong_; }

  private:
    /// The framebuffer's edge. Returns what it drives.
    rtl::BusBeat send(bool busready, bool tableready, bool resting) {
        const bool counted = uncounted_ == 0;
        const bool table_counted = table_uncounted_ == 0;
        uncounted_ = std::max(uncounted_ - 1, 0);
        table_uncounted_ = std::max(table_uncounted_ - 1, 0);
        const bool stop = bursting_ && judged_ > timing_.beat_pixels && !busready;
        judged_ = answered_.pass(announced_);
        if (stop) {
            stopped_ = beat_left_ > 0;
            bursting_ = false;
            announced_ = burst_ = 0;
            uncounted_ = loop_;
        }
        if (beat_left_ > 0) return --beat_left_ == 0 ? finish(beat_) : rtl::BusBeat{};
        if (!table_.empty()) {
            beat_ = table_.front();
            table_.pop_front();
            beat_left_ = row_cycles_ - 1;
            return beat_left_ == 0 ? beat_ : rtl::BusBeat{};
        }
        if (!bursting_) {
            if (resting || random_.one_in(habits_.laziness)) return {};
            if (left_ == 0 && random_.one_in(4)) {
                if (!tableready || !table_counted) return {};
                begin_frame();
                table_uncounted_ = 1 + loop_;
                return start_;
            }
            if (idle_ > 0) --idle_;
            if (left_ == 0 || idle_ > 0 || !busready || !counted) return for_another();
            idle_ = random_.between(0, habits_.slowness);
            bursting_ = first_beat_ = true;
            burst_ = static_cast<int>(
                std::min<std::int64_t>(left_, random_.between(1, scenario_.bus.burst_pixels)));
            pause_ = page_wait();
        }
        if (pause_ > 0) {
            --pause_;
            return {};
        }
        const int count = std::min(burst_, random_.between(1, static_cast<int>(timing_.beat_pixels)));
        beat_ = pixels(display_, next_, count);
        burst_ -= count;
        left_ -= count;
        next_ += count;
        pause_ = page_wait();
        beat_left_ = static_cast<int>(timing_.beat_cycles) - 1;
        return beat_left_ == 0 ? finish(beat_) : rtl::BusBeat{};
    }

    rtl::BusBeat finish(rtl::BusBeat beat) {
        if (beat.kind != rtl::BusBeat::Kind::kPixels) return beat;
        beat.remaining = static_cast<std::uint32_t>(burst_);
        announced_ = burst_;
        if (burst_ == 0) {
            // BUSREADY cannot count this beat yet.
            if (first_beat_ || stopped_ || loop_ > 0) uncounted_ = 1 + loop_;
            bursting_ = stopped_ = false;
        }
        first_beat_ = false;
        return beat;
    }

    void begin_frame() {
        ++frame_;
        left_ = next_ = 0;
        const int rows = random_.one_in(8) ? 0 : random_.between(1, 3);
        const int own = rows == 0 || random_.one_in(8) ? -1 : random_.between(0, rows - 1);
        start_ = rtl::BusBeat::frame_start(static_cast<std::uint32_t>(frame_), rows == 0);
        for (int i = 0; i < rows; ++i) {
            ViewportRow row = random_segment();
            if (i != own) row.dcomp = static_cast<std::uint16_t>(display_ + 1 + i);
            if (i == own) left_ = std::int64_t{row.sdx} * row.sdy;
            table_.push_back(rtl::BusBeat::table_row(static_cast<std::uint32_t>(frame_),
                                                     static_cast<std::uint32_t>(i), row, i + 1 == rows));
        }
    }

    ViewportRow random_segment() {
        ViewportLimits limits;
        limits.displays = display_;
        limits.image_width_pixels = limits.image_height_pixels = 1 << 14;
        limits.raster_width_pixels = scenario_.displays.raster_width_pixels();
        limits.raster_height_pixels = scenario_.displays.raster_height_pixels();
        limits.buffer_pixels = scenario_.composer.buffer_pixels;
        limits.ready_space_pixels = scenario_.composer.ready_space_pixels;
        limits.smoothing = scenario_.composer.smoothing;
        for (;;) {
            int m = 1;
            if (random_.one_in(2)) m = random_.between(2, random_.one_in(4) ? kMaximumMultiple : 5);
            const auto count = [&](int size) {
                const int most = size / m + 2;
                return random_.one_in(2) ? most : random_.between(1, most);
            };
            const auto position = [&](int size) { return random_.between(1 - 2 * m, size - 1); };
            const Size raster{limits.raster_width_pixels, limits.raster_height_pixels};
            const ViewportRow row =
                segment_row({count(raster.width), count(raster.height)},
                            {position(raster.width), position(raster.height)}, m, display_);
            if (row_defect(row, limits) == RowDefect::kNone) return row;
        }
    }

    /// As of a page miss, and whatever may come between.
    int page_wait() {
        return random_.one_in(habits_.laziness)
                   ? random_.between(0, static_cast<int>(timing_.longest_wait_cycles))
                   : 0;
    }

    rtl::BusBeat for_another() {
        if (frame_ < 0 || !random_.one_in(4)) return {};
        rtl::BusBeat beat = pixels(display_ + 1, random_.between(0, 20), 1);
        beat.remaining = static_cast<std::uint32_t>(random_.between(0, 20));
        return beat;
    }

    rtl::BusBeat pixels(int destination, std::int64_t first, int count) {
        return pixel_beat(frame_, destination, first, count, 0,
                          [this](std::int64_t) { return random_pixel(random_).word(); });
    }

    // ---- beats that no protocol allows, on a bus that loses none ----

    void note_delivered(const rtl::BusBeat& beat) {
        switch (beat.kind) {
            case rtl::BusBeat::Kind::kNone:
                break;
            case rtl::BusBeat::Kind::kFrameStart:
                rows_come_ = pixels_come_ = 0;
                table_ends_ = beat.last;
                own_row_ = false;
                break;
            case rtl::BusBeat::Kind::kTableRow:
                ++rows_come_;
                table_ends_ = beat.last;
                own_row_ = own_row_ || beat.destination == display_;
                break;
            case rtl::BusBeat::Kind::kPixels:
                if (beat.destination == display_) pixels_come_ += beat.count;
                break;
        }
    }

    rtl::BusBeat wrong_beat(const monitors::ComposerObserver& composer, bool releases) {
        constexpr int kTooFarAhead = 65536;
        const int newest = composer.newest_frame();
        const bool of_segment = newest >= 0 && table_ends_ && own_row_;
        std::vector<rtl::BusBeat> choice;
        const auto add = [&](rtl::BusBeat beat, int frame) {
            beat.frame = static_cast<std::uint32_t>(frame);
            choice.push_back(beat);
        };
        for (const rtl::BusBeat& beat :
             {pixels(display_, pixels_come_, 1), rtl::BusBeat::frame_start(0, true),
              rtl::BusBeat::table_row(0, 0, random_segment(), true)}) {
            add(beat, newest - 1);
            add(beat, newest + kTooFarAhead);
        }
        add(rtl::BusBeat::frame_start(0, false), newest);
        if (!releases && !composer.has_room_for_table()) add(rtl::BusBeat::frame_start(0, true), newest + 1);
        if (newest < 0 || table_ends_ || rows_come_ > 0) {
            const int row = random_.between(0, std::max(rows_come_ - 1, 0));
            add(rtl::BusBeat::table_row(0, static_cast<std::uint32_t>(row), random_segment(), true), newest);
        }
        if (newest < 0) add(pixels(display_, 0, 1), newest);
        if (of_segment && pixels_come_ > 0)
            add(pixels(display_, random_.between(0, pixels_come_ - 1), 1), newest);
        const bool full = !releases && composer.free_pixels() == 0 && composer.missing_pixels() > 0;
        if (of_segment && full) {
            choice.clear();
            add(pixels(display_, pixels_come_, 1), newest);
        }
        wrong_ = true;
        rtl::BusBeat beat =
            choice[static_cast<std::size_t>(random_.between(0, static_cast<int>(choice.size()) - 1))];
        beat.remaining = static_cast<std::uint32_t>(random_.between(0, 20));
        return beat;
    }

    const Scenario& scenario_;
    int display_;
    BusHabits habits_;
    Random& random_;
    monitors::BusTiming timing_;
    int loop_;
    int row_cycles_ = std::max(1, 128 / scenario_.bus.width_bits);

    // The framebuffer.
    monitors::DelayLine<bool> busready_;
    monitors::DelayLine<bool> tableready_;
    monitors::DelayLine<int> answered_;  ///< the rest of the burst that BUSREADY answers for
    std::deque<rtl::BusBeat> table_;
    rtl::BusBeat start_, beat_;
    int frame_ = -1;
    std::int64_t left_ = 0, next_ = 0;  ///< of the segment
    int beat_left_ = 0, pause_ = 0, idle_ = 0, burst_ = 0, announced_ = 0, judged_ = 0;
    bool bursting_ = false, first_beat_ = false, stopped_ = false;
    int uncounted_ = 0, table_uncounted_ = 0;  ///< clocks in which the ready wires do not count what was sent

    monitors::DelayLine<rtl::BusBeat> to_composer_;
    int blackout_ = 0;
    bool wrong_ = false;

    // What the composer has been sent of the newest frame.
    int rows_come_ = 0, pixels_come_ = 0;
    bool table_ends_ = false, own_row_ = false;
};

/// A small raster, and everything else at random within the limits of a scenario.
inline Scenario random_composer_scenario(Random& random, Smoothing smoothing) {
    constexpr int kDisplays = 3;
    Scenario scenario = small_scenario(random.between(3, 14), random.between(2, 9), kDisplays);
    scenario.composition =
        one_of(random, std::array{Composition::kZ, Composition::kZAlphaKey, Composition::kOver});
    scenario.depth_format = random.one_in(2) ? DepthFormat::kA8Z16 : DepthFormat::kZ24;
    for (std::uint8_t& channel : scenario.displays.background)
        channel = static_cast<std::uint8_t>(random.bits());
    scenario.bus.width_bits = random.one_in(4) ? 16 << random.between(0, 1) : 64 << random.between(0, 3);
    scenario.bus.burst_pixels = random.between(1, 40);
    scenario.bus.register_stages = random.one_in(3) ? random.between(1, 3) : 0;
    MemoryConfig& memory = scenario.memory;
    memory.words_per_cycle = random.one_in(2) ? 1 : 2 << random.between(0, 2);
    memory.read_latency_cycles = random.one_in(3) ? random.between(1, 5) : 0;
    memory.page_miss_cycles = random.between(0, random.one_in(3) ? 30 : 6);
    if (random.one_in(4)) {
        memory.refresh_cycles = random.between(1, 6);
        memory.refresh_interval_cycles = 1000;
    }
    ComposerConfig& composer = scenario.composer;
    composer.smoothing = smoothing;
    composer.on_starvation = random.one_in(2) ? StarvationMode::kGlitch : StarvationMode::kStall;
    const auto in_flight = static_cast<int>(monitors::BusTiming(scenario).in_flight_pixels);
    composer.ready_space_pixels = in_flight + (random.one_in(2) ? 0 : random.between(0, 10));
    const int width = scenario.displays.raster_width_pixels();
    composer.buffer_pixels =
        composer.ready_space_pixels + 4 + random.between(0, random.one_in(2) ? 4 : 3 * width);
    return scenario;
}

/// A composer between random neighbours. Its reference is the observer of the protocol monitors.
class RandomComposer final : public Lockstep<rtl::Composer> {
  public:
    RandomComposer(LockstepBench& bench, const std::string& name, Scenario scenario, int display,
                   const BusHabits& habits)
        : Lockstep(bench, name,
                   [&scenario, display](const char* dut, rtl::ClockGating) {
                       return std::make_unique<rtl::Composer>(dut, scenario, display);
                   }),
          scenario_(std::move(scenario)),
          observer_(scenario_, 0, display - 1),
          bus_master_(scenario_, display, habits, bench.random) {
        dut().on_starved_pixel([this](const StarvedPixel& pixel) { starved_pixels_.push_back(pixel); });
        observer_.on_starved_pixel(
            [this](const StarvedPixel& pixel) { due_starved_pixels_.push_back(pixel); });
    }

    void stimulate() override {
        Random& random = bench_.random;
        if (random.one_in(bench_.pausing() ? 20 : 8)) below_ = !below_;
        if (random.one_in(20)) pipemaster_ = !pipemaster_;
        if (bench_.in_reset()) {
            bus_master_.reset();
            position_ = kIdle;
            hold_ = 0;
            return;  // what stands at the other inputs has no meaning
        }
        drive_column_stall();
        drive_upstream();
        const bool starts = master_ ? observer_.expected().pipeready : startframe_in_.value();
        bus_ = bus_master_.edge(observer_, observer_.running() || starts, bench_.pausing());
        if (bus_master_.wrong()) ++bench_.happened["the bus broke a rule"];
    }
    void expect() override {
        const monitors::ComposerOutputs& due = observer_.expected();
        busready_ = due.busready;
        tableready_ = due.tableready;
        startframe_ = due.startframe;
        pipeready_ = due.pipeready;
        stall_ = due.stall;
        // A pixel that is not valid has any value, and no mark.
        pipe_ = due.pipe.valid ? due.pipe : rtl::PipePixel{dut().pipe_o.read().pixel, false, false};
    }
    void edge() override {
        was_held_ = scenario_.composer.may_stall() && column_stall_;
        was_reset_ = false;
        const bool was_ready = observer_.expected().pipeready;
        observer_.edge({bus_, startframe_in_, pipe_in_, below_, column_stall_}, cycle());
        if ((observer_.overflowed() || observer_.table_refused()) && !bus_master_.wrong()) {
            ++bench_.happened["the bus broke a rule by itself"];
        }
        if (observer_.expected().pipeready && !was_ready) ++bench_.happened["PIPEREADY"];
        if (observer_.expected().stall) ++bench_.happened["STALL"];
    }
    void reset() override {
        if (!std::exchange(was_reset_, true)) check_record();
        dut().forget_frames();
        observer_.forget_frames();
        observer_.reset(pipemaster_);
        master_ = pipemaster_;
        was_held_ = false;
    }

    /// Compares what the composer has counted with what the observer has.
    void check_record() {
        INFO(dut().name() << " before clock " << bench_.clock());
        const ComposerCounters& counters = dut().counters();
        const ComposerCounters& due = observer_.counters();
        for (const Counter<ComposerCounters>& counter : Counters<ComposerCounters>::kTable) {
            INFO(counter.name);
            CHECK(counters.*counter.member == due.*counter.member);
        }
        CHECK(counters.first_glitch == due.first_glitch);
        CHECK(counters.last_glitch == due.last_glitch);
        CHECK(counters.starved_runs == due.starved_runs);
        CHECK(counters.starved_run_count == due.starved_run_count);
        CHECK(counters.starved_by_frame == due.starved_by_frame);
        CHECK(starved_pixels_ == due_starved_pixels_);
        CHECK(dut().first_busready_drop_cycle() == observer_.first_busready_drop_cycle());
        CHECK(dut().first_starved_cycle() == observer_.first_starved_cycle());
        const auto same = [](const ComposerRecord::FrameSpan& a, const ComposerRecord::FrameSpan& b) {
            return a.startframe_cycle == b.startframe_cycle && a.start_cycle == b.start_cycle &&
                   a.end_cycle == b.end_cycle;
        };
        CHECK(std::equal(dut().frame_spans().begin(), dut().frame_spans().end(),
                         observer_.frame_spans().begin(), observer_.frame_spans().end(), same));
    }
    const ComposerCounters& counters() const { return observer_.counters(); }

  private:
    static constexpr int kIdle = -1;

    /// Edges are counted from the beginning of the run.
    int cycle() const { return bench_.clock() + 2; }

    /// The column stands still for this composer, or for another.
    void drive_column_stall() {
        Random& random = bench_.random;
        if (!scenario_.composer.may_stall()) {
            if (!bench_.pausing()) column_stall_ = random.one_in(2);  // nobody reads it
            return;
        }
        if (hold_ > 0) --hold_;
        if (hold_ == 0 && random.one_in(30)) hold_ = random.between(1, random.one_in(4) ? 40 : 5);
        column_stall_ = observer_.expected().stall || hold_ > 0;
    }

    /// The composer above: a STARTFRAME, then a raster without a gap. Its registers stand still with the column.
    void drive_upstream() {
        Random& random = bench_.random;
        if (master_) {
            // It reads none of this.
            if (bench_.pausing()) return;
            startframe_in_ = random.one_in(4);
            pipe_in_ = random_pipe_pixel(random.one_in(2));
            return;
        }
        if (was_held_) return;
        if (position_ == kIdle) {
            const bool ready = observer_.expected().pipeready && random.one_in(6);
            const bool unready = !observer_.running() && observer_.table_complete() && random.one_in(200);
            startframe_in_ = !bench_.pausing() && (ready || unready);
            if (startframe_in_) position_ = 0;
            if (!bench_.pausing()) pipe_in_ = random_pipe_pixel(false);
            return;
        }
        startframe_in_ = false;
        pipe_in_ = random_pipe_pixel(true);
        if (++position_ ==
            scenario_.displays.raster_width_pixels() * scenario_.displays.raster_height_pixels()) {
            position_ = kIdle;
        }
    }

    rtl::PipePixel random_pipe_pixel(bool valid) {
        return {random_pixel(bench_.random), valid, bench_.random.one_in(40)};
    }

    Scenario scenario_;
    monitors::ComposerObserver observer_;
    RandomBus bus_master_;
    std::vector<StarvedPixel> starved_pixels_, due_starved_pixels_;
    int position_ = kIdle;  ///< of the raster that comes from above
    int hold_ = 0;          ///< clocks in which another composer holds the column
    bool master_ = false;   ///< the strap, as reset has read it
    bool was_held_ = false;
    bool was_reset_ = false;

    Input<bool>& pipemaster_ = in(&rtl::Composer::pipemaster_i);
    Input<rtl::BusBeat>& bus_ = in(&rtl::Composer::bus_i);
    Output<bool>& busready_ = out(&rtl::Composer::busready_o);
    Output<bool>& tableready_ = out(&rtl::Composer::tableready_o);
    Input<bool>& startframe_in_ = in(&rtl::Composer::startframe_i);
    Output<bool>& startframe_ = out(&rtl::Composer::startframe_o);
    Input<rtl::PipePixel>& pipe_in_ = in(&rtl::Composer::pipe_i);
    Output<rtl::PipePixel>& pipe_ = out(&rtl::Composer::pipe_o);
    Input<bool>& below_ = in(&rtl::Composer::pipeready_i);
    Output<bool>& pipeready_ = out(&rtl::Composer::pipeready_o);
    Input<bool>& column_stall_ = in(&rtl::Composer::column_stall_i);
    Output<bool>& stall_ = out(&rtl::Composer::stall_o);
};

/// Composers of all kinds, each with a bus and a column of its own, in lockstep with their references. A third of the buses
/// lose beats, and a third carry beats that no protocol allows. Demands that everything has happened that a
/// composer counts.
inline void run_random_composers(LockstepBench& bench, Smoothing smoothing, int composers, int clocks) {
    ExpectedReport report("/metabuffer/composer/protocol");
    std::vector<std::unique_ptr<RandomComposer>> duts;
    for (int i = 0; i < composers; ++i) {
        BusHabits habits;
        habits.slowness = bench.random.one_in(2) ? 40 : 0;
        habits.laziness = bench.random.between(2, 12);
        if (i % 3 == 1) {
            habits.pixel_beats_a_loss = 40;
            habits.table_beats_a_loss = 8;
            habits.clocks_to_blackout = 300;
        } else if (i % 3 == 2) {
            habits.clocks_to_wrong_beat = 30;
        }
        duts.push_back(std::make_unique<RandomComposer>(bench, "composer_" + std::to_string(i),
                                                        random_composer_scenario(bench.random, smoothing),
                                                        bench.random.between(1, 3), habits));
    }
    bench.clocks_to_reset = 1000;
    bench.clocks_to_pause = 150;
    bench.run(clocks, {{"PIPEREADY", 1000}, {"STALL", 300}, {"the bus broke a rule", 500}});
    ComposerCounters sum;
    for (const auto& dut : duts) {
        dut->check_record();
        for (const Counter<ComposerCounters>& counter : Counters<ComposerCounters>::kTable) {
            sum.*counter.member += dut->counters().*counter.member;
        }
    }
    // Each was reported by the composer with clock gating and by the one without, and nothing else was.
    CHECK(report.count() == 2 * bench.happened["the bus broke a rule"]);
    CHECK(bench.happened["the bus broke a rule by itself"] == 0);
    // Everything has happened, and often.
    constexpr int kOften = 30;
    for (const Counter<ComposerCounters>& counter : Counters<ComposerCounters>::kTable) {
        INFO(counter.name);
        CHECK(sum.*counter.member >= kOften);
    }
}

}  // namespace metabuffer::test
