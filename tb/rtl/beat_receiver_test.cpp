#include "rtl/beat_receiver.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "composer_records.h"
#include "composer_scenario.h"
#include "expected_report.h"
#include "lockstep/lockstep.h"
#include "pixel_beat.h"
#include "support/painted_segment.h"
#include "support/random_seed.h"
#include "support/traced_values.h"

namespace metabuffer::test::beat_receiver_test {
namespace {

using rtl::BeatReceiver;
using rtl::BusBeat;
using rtl::FifoRelease;
using rtl::FifoWrite;
using rtl::HeadSegment;
using rtl::PixelUse;
using rtl::SegmentProgress;

constexpr Size kRaster{kWidth, kHeight};
constexpr int kNoUse = Segment::kNoPixel;
constexpr int kClocksToSleep = rtl::Clocked::kIdleEdges + 1;

BusBeat pixels(int frame, std::int64_t first, int count, int remaining = 0, int destination = 1) {
    return pixel_beat(frame, destination, first, count, remaining, [frame](std::int64_t k) {
        return 0x5A00'0000U + static_cast<std::uint64_t>(frame) * 1000 + static_cast<std::uint64_t>(k);
    });
}

/// A frame's start and its table.
std::vector<BusBeat> table(int frame, const ViewportTable& rows) {
    const auto number = static_cast<std::uint32_t>(frame);
    std::vector<BusBeat> beats{BusBeat::frame_start(number, rows.empty())};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const bool last = i + 1 == rows.size();
        beats.push_back(BusBeat::table_row(number, static_cast<std::uint32_t>(i), rows[i], last));
    }
    return beats;
}

/// The receiver of a composer of display 1, and its pins.
struct Records {
    std::array<Record, 2> records;
};
class Receiver : protected Records, public Lockstep<BeatReceiver> {
  protected:
    Receiver(LockstepBench& bench, const std::string& name, const Scenario& scenario)
        : Lockstep(bench, name, [this, &scenario](const char* dut, rtl::ClockGating gating) {
              Record& record = records[gating == rtl::ClockGating::kOn ? 0 : 1];
              return std::make_unique<BeatReceiver>(dut, scenario, 1, record);
          }) {}

    Input<BusBeat>& bus_ = in(&BeatReceiver::bus_i);
    Input<bool>& stall_ = in(&BeatReceiver::column_stall_i);
    Input<bool>& start_ = in(&BeatReceiver::start_i);
    Input<bool>& uses_ = in(&BeatReceiver::uses_i);
    Input<PixelUse>& use_ = in(&BeatReceiver::use_i);
    Output<bool>& busready_ = out(&BeatReceiver::busready_o);
    Output<bool>& tableready_ = out(&BeatReceiver::tableready_o);
    Output<HeadSegment>& segment_ = out(&BeatReceiver::segment_o);
    Output<SegmentProgress>& progress_ = out(&BeatReceiver::progress_o);
    Output<bool>& fetched_ = out(&BeatReceiver::fetched_o);
    Output<FifoWrite>& write_ = out(&BeatReceiver::write_o);
    Output<FifoRelease>& release_ = out(&BeatReceiver::release_o);
};

/// A machine, and what docs/design.md makes of its bus and memory.
struct Machine {
    const char* name;
    ComposerSizes sizes;
    StarvationMode mode;
    Smoothing smoothing;
    int bus_bits, register_stages, read_latency, page_miss, refresh;
    int loop;         ///< clocks that read latency and bus registers add
    int in_flight;    ///< pixels that may still come when BUSREADY falls
    int longest_gap;  ///< clocks between the beats of a burst
    int addresses;    ///< of the FIFO

    Scenario scenario() const {
        Scenario scenario = composer_scenario(sizes, mode);
        scenario.composer.smoothing = smoothing;
        scenario.bus.width_bits = bus_bits;
        scenario.bus.register_stages = register_stages;
        scenario.memory.read_latency_cycles = read_latency;
        scenario.memory.page_miss_cycles = page_miss;
        scenario.memory.refresh_cycles = refresh;
        return scenario;
    }
};

/// A receiver as its header describes it, in sets and lists. It is on a bus that loses beats, and on a raster that does not
/// wait for pixels.
class RandomTraffic final : public Receiver {
  public:
    RandomTraffic(LockstepBench& bench, const Machine& machine)
        : Receiver(bench, machine.name, machine.scenario()),
          machine_(machine),
          may_stall_(machine.mode == StarvationMode::kStall) {}

    void stimulate() override {
        Random& random = bench_.random;
        const bool stood = may_stall_ && stall_;
        // A raster that stands still shows the same once more.
        if (!stood) move_raster();
        if (stall_left_ == 0 && random.one_in(10)) stall_left_ = random.between(1, 4);
        stall_ = stall_left_ > 0;
        if (stall_) --stall_left_;
        bus_ = next_beat();
    }
    /// Of a segment that does not show only that is known.
    void expect() override {
        if (segment_->shown && !progress_->abandoned) return;
        SegmentProgress any = dut().progress_o.read();
        any.abandoned = progress_->abandoned;
        progress_ = any;
    }
    void edge() override {
        written_.count = 0;  // the address stands
        released_ = FifoRelease{};
        if (moves()) {
            release_through(last_release());
            if (uses_ && use_->ends_frame) ++composited_;
        }
        const BusBeat& beat = bus_;
        if (beat.kind != BusBeat::Kind::kNone) receive(beat);
        if (beat.kind == BusBeat::Kind::kPixels && beat.destination == 1) {
            announced_ = static_cast<int>(beat.remaining);
            silent_ = 0;
        } else if (announced_ > 0 && ++silent_ == machine_.longest_gap) {
            announced_ = 0;
            ++bench_.happened["a burst ended in silence"];
        }
        busready_ = busready();
        tableready_ = frames_heard() - composited_ < 2;
        const Frame none;
        const Frame& frame = composited_ < frames_heard() ? head() : none;
        segment_ = frame.row ? HeadSegment{true, Segment(*frame.row, kWidth, kHeight, machine_.smoothing)}
                             : HeadSegment{};
        progress_ = {frame.abandoned, frame.arrived, static_cast<std::uint32_t>(frame.base)};
        const bool whole = !frame.row || frame.abandoned || frame.arrived == frame.pixels();
        fetched_ = frame.complete && (whole || free() < machine_.sizes.ready_space);
        write_ = written_;
        release_ = released_;
        counts_.buffer_high_water = std::max<std::int64_t>(counts_.buffer_high_water, held());
    }
    void reset() override {
        busready_ = false;
        tableready_ = false;
        fetched_ = false;
        segment_ = HeadSegment{};
        progress_ = SegmentProgress{};
        write_ = written_ = FifoWrite{};
        release_ = FifoRelease{};
        frames_.clear();
        composited_ = announced_ = silent_ = cut_ = next_address_ = 0;
        to_send_.clear();
        pixels_to_send_ = first_ = left_in_burst_ = sent_frames_ = 0;
        start_ = false;
        uses_ = false;
        position_ = -1;
        quiet_left_ = 0;
    }
    /// What both have counted, at the end of the run.
    void check_counts() const {
        for (const Record& record : records) {
            const ComposerCounters& counts = record.counters();
            CHECK(counts.late_pixels == counts_.late_pixels);
            CHECK(counts.lost_pixels == counts_.lost_pixels);
            CHECK(counts.lost_tables == counts_.lost_tables);
            CHECK(counts.busready_drops == counts_.busready_drops);
            CHECK(counts.buffer_high_water == counts_.buffer_high_water);
            CHECK(record.first_busready_drop_cycle() == first_drop_cycle_);
        }
        // What a waveform shows besides the pins.
        const std::string bits = std::to_string(rtl::bits_for(machine_.longest_gap));
        const std::vector<std::string> shown = traced_values(dut());
        for (const std::string& value : {".silent_cycles[" + bits + "]=" + std::to_string(silent_),
                                         ".writes[1]=" + std::to_string(written_.count > 0 ? 1 : 0)}) {
            INFO(value);
            CHECK(std::count(shown.begin(), shown.end(), dut().name() + value) == 1);
        }
        bench_.happened["a pixel was late"] += counts_.late_pixels;
        bench_.happened["a pixel was lost"] += counts_.lost_pixels;
        bench_.happened["a table was lost"] += counts_.lost_tables;
        bench_.happened["a burst was cut"] += counts_.busready_drops;
    }

  private:
    struct Frame {
        std::optional<ViewportRow> row;
        std::uint32_t rows = 0;
        bool complete = false, abandoned = false, table_lost = false;
        std::int64_t arrived = 0, released = 0;
        std::int64_t base = 0;  ///< address of pixel 0
        std::set<std::int64_t> held;
        std::int64_t pixels() const { return row ? std::int64_t{row->sdx} * row->sdy : 0; }
    };

    // ---- the reference ----

    int frames_heard() const { return static_cast<int>(frames_.size()); }
    const Frame& head() const { return frames_[static_cast<std::size_t>(composited_)]; }
    Frame& head() { return frames_[static_cast<std::size_t>(composited_)]; }
    int held() const {
        std::size_t held = 0;
        for (const Frame& frame : frames_) held += frame.held.size();
        return static_cast<int>(held);
    }
    int free() const { return machine_.sizes.buffer - held(); }
    bool moves() const { return !may_stall_ || !stall_; }
    /// The last pixel that this edge's frame start and raster position release.
    std::int64_t last_release() const {
        return std::max(start_ ? raster_->skipped - 1 : kNoUse, uses_ ? use_->last_use : kNoUse);
    }
    void release_through(std::int64_t last) {
        if (composited_ == frames_heard()) return;
        Frame& frame = head();
        for (; frame.released <= last; ++frame.released) {
            released_.oldest += static_cast<std::uint32_t>(frame.held.erase(frame.released));
        }
    }
    void lose_table(Frame& frame) {
        if (frame.complete) return;
        ++counts_.lost_tables;
        frame.row.reset();
        frame.complete = frame.abandoned = frame.table_lost = true;
    }
    void lose_pixels(std::int64_t count) {
        Frame& frame = frames_.back();
        counts_.lost_pixels += count;
        frame.arrived += count;
        if (frames_heard() == composited_) return;  // it is over: nothing of it is waited for
        released_.newest += static_cast<std::uint32_t>(frame.held.size());
        frame.held.clear();
        frame.abandoned = true;
    }
    void add_frame() {
        frames_.emplace_back();
        frames_.back().base = next_address_;
    }
    void receive(const BusBeat& beat) {
        const auto number = static_cast<int>(beat.frame);
        const bool begins = beat.kind == BusBeat::Kind::kFrameStart;
        if (number >= frames_heard()) {
            if (!frames_.empty()) {
                Frame& newest = frames_.back();
                lose_table(newest);
                if (newest.arrived < newest.pixels()) lose_pixels(newest.pixels() - newest.arrived);
            }
            while (frames_heard() < number + (begins ? 0 : 1)) {
                add_frame();
                lose_table(frames_.back());
            }
            if (begins) add_frame();
        }
        Frame& frame = frames_.back();
        if (begins) {
            frame.complete = beat.last;
        } else if (beat.kind == BusBeat::Kind::kTableRow) {
            if (frame.table_lost) return;
            if (beat.first != frame.rows) return lose_table(frame);
            ++frame.rows;
            if (beat.destination == 1) frame.row = beat.row();
            frame.complete = beat.last;
        } else {
            lose_table(frame);
            if (beat.destination == 1 && !frame.table_lost) receive_pixels(frame, beat);
        }
    }
    void receive_pixels(Frame& frame, const BusBeat& beat) {
        if (beat.first > frame.arrived) lose_pixels(beat.first - frame.arrived);
        for (std::size_t i = 0; i < beat.count; ++i) {
            const std::int64_t k = frame.arrived++;
            const int address = next_address_;
            next_address_ = (next_address_ + 1) % machine_.addresses;
            if (frame.abandoned) continue;
            if (k < frame.released) {
                ++counts_.late_pixels;
                continue;
            }
            frame.held.insert(k);
            if (written_.count == 0) written_.address = static_cast<std::uint32_t>(address);
            written_.words[written_.count++] = beat.words[i];
        }
    }
    bool busready() {
        if (cut_ > 0 && --cut_ == 0) announced_ = 0;
        if (cut_ > 0) return false;
        if (announced_ <= machine_.sizes.beat) return free() - announced_ >= machine_.sizes.ready_space;
        if (free() >= std::min(announced_, machine_.in_flight)) return true;
        cut_ = 1 + machine_.loop;
        if (counts_.busready_drops++ == 0) first_drop_cycle_ = bench_.clock() + 2;
        return false;
    }

    // ---- bus and raster ----

    BusBeat next_beat() {
        Random& random = bench_.random;
        if (quiet_left_ > 0) {
            --quiet_left_;
            return {};
        }
        if (!random.one_in(bench_.pausing() ? 25 : pace_)) return {};
        if (to_send_.empty() && first_ == pixels_to_send_ && frames_heard() - composited_ < 2 &&
            random.one_in(2)) {
            plan_frame();
        }
        BusBeat beat;
        if (!to_send_.empty()) {
            beat = to_send_.front();
            to_send_.erase(to_send_.begin());
        } else if (left_in_burst_ == 0 && random.one_in(4) && sent_frames_ > 0) {
            beat = pixels(sent_frames_ - 1, 0, 1, 3, 2);  // another composer's
        } else if (first_ < pixels_to_send_) {
            beat = own_pixels();
        }
        return random.one_in(120) ? BusBeat{} : beat;
    }
    BusBeat own_pixels() {
        Random& random = bench_.random;
        if (left_in_burst_ == 0) {
            if (!busready_ && !random.one_in(10)) return {};
            left_in_burst_ = std::min(random.between(1, 24), pixels_to_send_ - first_);
        }
        const int count = std::min(left_in_burst_, random.between(1, machine_.sizes.beat));
        int room = free();
        if (moves() && composited_ < frames_heard()) {
            const std::set<std::int64_t>& held = head().held;
            room += static_cast<int>(std::distance(held.begin(), held.upper_bound(last_release())));
        }
        const bool dropped = !frames_.empty() && frames_.back().abandoned;
        if (room < count && !dropped) return {};
        // A burst may end early, for BUSREADY's fall or not. Its last beat may announce that.
        const bool ends = random.one_in(cut_ > 0 ? 3 : 20);
        const int rest = left_in_burst_ - count;
        const BusBeat beat = pixels(sent_frames_ - 1, first_, count, ends && random.one_in(2) ? 0 : rest);
        first_ += count;
        left_in_burst_ = ends ? 0 : rest;
        if (ends || random.one_in(20)) {
            quiet_left_ = random.between(0, std::max(machine_.longest_gap + 4, 2 * kClocksToSleep));
            raster_rests_ = random.one_in(2);
        }
        return beat;
    }
    void plan_frame() {
        Random& random = bench_.random;
        while (random.one_in(30)) ++sent_frames_;  // nothing of that frame comes
        pace_ = random.between(1, 4);
        const bool smooths = machine_.smoothing == Smoothing::kBilinear;
        ViewportTable rows;
        first_ = pixels_to_send_ = 0;
        for (int display = 1; display <= 3; ++display) {
            if (random.one_in(5)) continue;
            rows.push_back(smooths ? random_smoothed_row(random, kRaster, 5)
                                   : random_valid_row(random, kRaster, 5));
            rows.back().dcomp = static_cast<std::uint16_t>(display);
            if (display == 1) pixels_to_send_ = rows.back().sdx * rows.back().sdy;
        }
        shuffle_rows(random, rows);
        to_send_ = table(sent_frames_++, rows);
        if (random.one_in(6)) {  // the rest is lost
            to_send_.resize(static_cast<std::size_t>(random.between(1, static_cast<int>(to_send_.size()))));
            pixels_to_send_ = 0;
        }
    }
    void move_raster() {
        Random& random = bench_.random;
        const bool rests =
            !random.one_in(bench_.pausing() ? 25 : pace_) || (quiet_left_ > 0 && raster_rests_);
        const bool started = start_;
        start_ = false;
        uses_ = false;
        if (started) position_ = 0;
        if (position_ < 0) {
            if (rests || composited_ == frames_heard() || !head().complete || !random.one_in(4)) return;
            start_ = true;
            if (random.one_in(3)) stall_left_ = quiet_left_ = random.between(kClocksToSleep, 20);
            raster_ = PaintedSegment(head().row, kRaster, machine_.smoothing);
            return;
        }
        if (rests) return;
        const auto n = static_cast<std::size_t>(position_);
        const std::int64_t before = n == 0 ? raster_->skipped : raster_->released[n - 1];
        PixelUse use;
        if (raster_->released[n] > before || random.one_in(8)) use.last_use = raster_->released[n] - 1;
        use.ends_frame = ++position_ == kPixels;
        if (use.ends_frame) position_ = -1;
        uses_ = use.any();
        if (uses_) use_ = use;
    }

    Machine machine_;
    bool may_stall_;

    std::vector<Frame> frames_;
    int composited_ = 0;
    int announced_ = 0, silent_ = 0, cut_ = 0;
    int next_address_ = 0;
    FifoWrite written_;
    FifoRelease released_;
    ComposerCounters counts_;
    std::int64_t first_drop_cycle_ = ComposerRecord::kNever;

    std::vector<BusBeat> to_send_;  ///< of a frame's start and table
    int pixels_to_send_ = 0, first_ = 0, left_in_burst_ = 0;
    int sent_frames_ = 0;
    int quiet_left_ = 0, stall_left_ = 0;  ///< clocks
    bool raster_rests_ = false;            ///< while the bus is quiet
    int pace_ = 1;                         ///< clocks to a beat, and to a raster position
    int position_ = -1;
    std::optional<PaintedSegment> raster_;
};

TEST_CASE("beat receiver: in lockstep with its reference") {
    constexpr auto kGlitch = StarvationMode::kGlitch;
    constexpr auto kStall = StarvationMode::kStall;
    constexpr auto kReplicate = Smoothing::kReplicate;
    constexpr auto kBilinear = Smoothing::kBilinear;
    // The longest gap of the first one, and the loop of the last one, are longer than a block takes to sleep.
    const std::vector<Machine> machines{
        {"narrow", {20, 4, 1}, kGlitch, kReplicate, 64, 0, 0, 30, 0, 0, 2, 31, 32},
        {"wide", {20, 8, 4}, kStall, kBilinear, 256, 0, 0, 6, 0, 0, 8, 7, 32},
        {"slow_bus", {16, 6, 1}, kStall, kReplicate, 32, 1, 0, 6, 3, 2, 3, 6 + 2 + 3 + 6, 16},
        {"far", {16, 6, 1}, kGlitch, kReplicate, 16, 4, 8, 6, 0, 8 + 2 * 4, 2 + 4, 6 + 4, 16}};
    LockstepBench bench(2221);
    std::vector<std::unique_ptr<RandomTraffic>> receivers;
    receivers.reserve(machines.size());
    for (const Machine& made : machines) receivers.push_back(std::make_unique<RandomTraffic>(bench, made));
    bench.run(60'000);
    for (const auto& receiver : receivers) receiver->check_counts();
    bench.run(60'001, {{"a pixel was late", 50},
                       {"a pixel was lost", 30},
                       {"a table was lost", 50},
                       {"a burst was cut", 40},
                       {"a burst ended in silence", 50}});
}

// ---- errors ----

/// Beats one a clock, and later one that breaks the bus's protocol. It must leave everything as it was.
struct Wrong {
    const char* name;
    std::vector<BusBeat> before;
    BusBeat beat;
    int reports = 1;
    bool ends_frame = false;  ///< the frame is composited before that
};
class Sent final : public Receiver {
  public:
    Sent(LockstepBench& bench, const Scenario& scenario, const Wrong& wrong, int clock)
        : Receiver(bench, wrong.name, scenario), wrong_(wrong), wrong_clock_(clock) {}

    void stimulate() override {
        const auto clock = static_cast<std::size_t>(bench_.clock());
        bus_ = clock < wrong_.before.size() ? wrong_.before[clock] : BusBeat{};
        if (bench_.clock() == wrong_clock_) bus_ = wrong_.beat;
        use_ = PixelUse{true, kNoUse};
        uses_ = wrong_.ends_frame && clock == wrong_.before.size();
    }
    void expect() override {
        expect_no_change(busready_);
        expect_no_change(tableready_);
        expect_no_change(segment_);
        expect_no_change(progress_);
        expect_no_change(fetched_);
        expect_no_change(write_);
        expect_no_change(release_);
    }
    const ComposerCounters& counters() const { return records[0].counters(); }

  private:
    template <typename Value>
    void expect_no_change(Output<Value>& output) const {
        if (bench_.clock() == wrong_clock_ + 1 && wrong_.reports > 0) {
            output = Value(output.seen());
        } else {
            output.ignore();
        }
    }

    Wrong wrong_;
    int wrong_clock_;
};

TEST_CASE("beat receiver: a beat that breaks the protocol is reported and leaves everything as it was") {
    const ExpectedReport report("/metabuffer/composer/protocol");
    const auto after = [](std::vector<BusBeat> beats, const std::vector<BusBeat>& more) {
        beats.insert(beats.end(), more.begin(), more.end());
        return beats;
    };
    const std::vector<BusBeat> first = table(0, {segment_row({2, 1}, {}, 1, 2), whole_raster()});
    const std::vector<BusBeat> second = after(table(0, {}), table(1, {whole_raster()}));
    const int most_ahead = 65535;
    const std::vector<Wrong> wrongs{
        {"full", after(first, {pixels(0, 0, 8), pixels(0, 8, 8)}), pixels(0, 16, 1)},
        {"pixel_again", after(first, {pixels(0, 0, 3)}), pixels(0, 2, 1)},
        {"row_again", {first[0], first[1]}, first[1]},
        {"row_after_the_last", first, first[2]},
        {"begun_again", first, first[0]},
        {"frame_before", second, pixels(0, 0, 1)},
        {"third_table", second, BusBeat::frame_start(2, true)},
        {"no_table", table(0, {}), pixels(0, 0, 1), 1, true},
        {"too_far_ahead", first, pixels(most_ahead + 1, 0, 1, 0, 2)},
        {"as_far_ahead_as_can_be", first, pixels(most_ahead, 0, 1, 0, 2), 0},
    };
    const Scenario scenario = composer_scenario();
    constexpr int kFirstWrong = 20;
    LockstepBench bench;
    std::vector<std::unique_ptr<Sent>> receivers;
    for (const Wrong& wrong : wrongs) {
        const int clock = kFirstWrong + static_cast<int>(receivers.size());
        receivers.push_back(std::make_unique<Sent>(bench, scenario, wrong, clock));
    }
    int reports = 0;
    for (std::size_t i = 0; i < wrongs.size(); ++i) {
        INFO(wrongs[i].name);
        const int clock = kFirstWrong + static_cast<int>(i);
        bench.run(clock);
        CHECK(report.count() == reports);
        reports += 2 * wrongs[i].reports;  // there are two of each
        bench.run(clock + 1);
        CHECK(report.count() == reports);
        CHECK(receivers[i]->counters().lost_tables == (wrongs[i].reports > 0 ? 0 : most_ahead));
        CHECK(receivers[i]->counters().lost_pixels == (wrongs[i].reports > 0 ? 0 : kPixels));
    }
    bench.run(kFirstWrong + static_cast<int>(wrongs.size()) + 1);
}

}  // namespace
}  // namespace metabuffer::test::beat_receiver_test
