#include "rtl/input_framebuffer.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "datapath/arbitration/arbitration_table.h"
#include "dvi_waveform.h"
#include "monitors/arbiter_monitor.h"
#include "monitors/bus_monitor.h"
#include "monitors/memory_monitor.h"
#include "rtl/framebuffer_wires.h"
#include "scenario/derived_timing.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

namespace metabuffer::test::input_framebuffer_test {
namespace {

using rtl::BusBeat;
using rtl::DecodedPixel;
using rtl::DecoderEvent;
using rtl::InputFramebuffer;
using BeatKind = rtl::BusBeat::Kind;

/// An input framebuffer between a decoder and the composers of its row, all played by the test. The bus's protocol
/// monitor watches it.
struct InputBench {
    Scenario scenario;
    ClockDomain& core;
    ClockDomain& link;
    sc_core::sc_signal<DecodedPixel> pixel;
    sc_core::sc_signal<DecoderEvent> event;
    sc_core::sc_signal<bool> pair_request;
    std::vector<std::unique_ptr<sc_core::sc_signal<bool>>> busready;    ///< high unless a test drives it
    std::vector<std::unique_ptr<sc_core::sc_signal<bool>>> tableready;  ///< likewise
    sc_core::sc_signal<BusBeat> bus;
    InputFramebuffer framebuffer;
    monitors::ViolationLog violations;
    monitors::BusMonitor monitor;
    const Recording<BusBeat>& beats;
    const Recording<bool>& requests;

    InputBench(ClockedTestbench& bench, const std::string& name, Scenario with,
               ClockDomain* link_domain = nullptr)
        : scenario(std::move(with)),
          core(bench.core),
          link(link_domain != nullptr ? *link_domain : bench.core),
          framebuffer(name.c_str(), scenario, 0),
          monitor((name + "_monitor").c_str(), scenario, 0, violations),
          beats(core.record(bus)),
          requests(link.record(pair_request)) {
        framebuffer.clk_i(core.clk);
        framebuffer.reset_i(bench.reset);
        framebuffer.dvi_clk_i(link.clk);
        framebuffer.pixel_i(pixel);
        framebuffer.event_i(event);
        framebuffer.pair_request_o(pair_request);
        framebuffer.bus_o(bus);
        monitor.clk_i(core.clk);
        monitor.reset_i(bench.reset);
        monitor.bus_i(bus);
        for (int d = 0; d < scenario.displays.count(); ++d) {
            const std::string suffix = "_" + name + "_" + std::to_string(d + 1);
            busready.push_back(
                std::make_unique<sc_core::sc_signal<bool>>(("busready" + suffix).c_str(), true));
            tableready.push_back(
                std::make_unique<sc_core::sc_signal<bool>>(("tableready" + suffix).c_str(), true));
            framebuffer.busready_i[static_cast<std::size_t>(d)](*busready.back());
            framebuffer.tableready_i[static_cast<std::size_t>(d)](*tableready.back());
            monitor.busready_i[static_cast<std::size_t>(d)](*busready.back());
            monitor.tableready_i[static_cast<std::size_t>(d)](*tableready.back());
        }
        bench.trace(framebuffer);
        link.each_clock([this](int clock) {
            const auto event_now = events_.find(clock);
            event.write(event_now == events_.end() ? DecoderEvent{} : event_now->second);
            const auto pixel_now = pixels_.find(clock);
            pixel.write(pixel_now == pixels_.end() ? DecodedPixel{} : pixel_now->second);
        });
    }

    // ---- what the decoder reports, by link clock ----

    DecoderEvent& event_at(int clock) { return events_[clock]; }
    void colour_start(int clock, std::uint32_t number) {
        event_at(clock).colour_start = true;
        event_at(clock).number = number;
    }
    void pair_good(int clock, std::uint32_t number) {
        event_at(clock).pair_good = true;
        event_at(clock).number = number;
    }
    void pair_lost(int clock, std::uint32_t number) {
        event_at(clock).pair_lost = true;
        event_at(clock).lost_number = number;
    }
    /// One frame's pixels, one a clock. Returns the clock after the last.
    int put_pixels(int clock, const PixelImage& image, FrameKind kind) {
        std::uint32_t address = 0;
        for (const auto& line : image_lines(image, kind)) {
            for (const std::uint32_t data : line)
                pixels_[clock++] = DecodedPixel{true, kind, address++, data};
        }
        return clock;
    }
    /// A colour frame's verdict, rows and pixels. Returns the clock after the last pixel.
    int put_colour(int clock, std::uint32_t number, const ViewportTable& table, const PixelImage& image) {
        colour_start(clock, number);
        int row_clock = clock;
        for (const ViewportRow& row : table) {
            event_at(++row_clock).row = true;
            event_at(row_clock).table_row = row;
        }
        return std::max(put_pixels(clock + 1, image, FrameKind::kColour), row_clock + 1);
    }
    /// The slot table that the host sends with a depth frame.
    void put_slots(int clock, const ViewportTable& table) {
        constexpr std::size_t kRoomBytes = 4096;
        const std::vector<std::uint8_t> payload =
            slot_payload(scenario.bus.arbitration,
                         validate_table(table, scenario.limits(scenario.renderers.front())), kRoomBytes);
        for (std::size_t byte = 0; byte < payload.size(); ++byte) {
            DecoderEvent& event = event_at(clock + static_cast<int>(byte) / kLinkBytesPerPixel);
            event.payload[event.payload_bytes++] = payload[byte];
        }
    }
    /// A whole pair from `clock` on. Returns the clock of its verdict: good. pause: clocks before that one.
    int put_pair(int clock, std::uint32_t number, const ViewportTable& table, const PixelImage& image,
                 int pause = 0) {
        const int depth = put_colour(clock, number, table, image);
        put_slots(depth, table);
        const int verdict = put_pixels(depth, image, FrameKind::kDepth) + pause;
        pair_good(verdict, number);
        return verdict;
    }
    /// The same, such that the verdict comes at a given clock.
    void put_pair_until(int verdict, std::uint32_t number, const ViewportTable& table,
                        const PixelImage& image) {
        put_pair(verdict - 1 - 2 * static_cast<int>(image.values.size()), number, table, image);
    }

    /// Display d (from 1) takes no slot at edge `clock`.
    void drop_busready(int d, int clock, int clocks = 1) {
        core.drive(*busready[static_cast<std::size_t>(d - 1)], clock, false);
        core.drive(*busready[static_cast<std::size_t>(d - 1)], clock + clocks, true);
    }

    /// A reset: what was to come from a clock on does not come.
    void forget_link_from(int clock) {
        events_.erase(events_.lower_bound(clock), events_.end());
        pixels_.erase(pixels_.lower_bound(clock), pixels_.end());
    }

    // ---- what came out ----

    RendererCounters counters() const { return framebuffer.counters(); }

    std::vector<int> clocks_of(BeatKind kind) const {
        return beats.clocks_where([kind](const BusBeat& beat) { return beat.kind == kind; });
    }

  private:
    std::map<int, DecoderEvent> events_;
    std::map<int, DecodedPixel> pixels_;
};

/// With link and core on one clock, the pair's verdict is answered in its clock and crosses two registers. The
/// broadcast begins in the clock after that.
constexpr int kVerdictToFrameStart = 3;
constexpr int kVerdict = 400;  ///< of the first pair
constexpr int kFrameStart = kVerdict + kVerdictToFrameStart;

constexpr int kImageWidth = 16;
constexpr int kImageHeight = 4;

struct BusSpeed {
    int width_bits = 64;
    int words_per_cycle = 1;
    int burst = 8;
    int page_words = 4096;
    int page_miss = 0;
};

Scenario input_scenario(const BusSpeed& speed, int displays = 1, int frames = 1) {
    Scenario scenario = small_scenario(64, 64, displays);
    scenario.frames = frames;
    scenario.bus.width_bits = speed.width_bits;
    scenario.bus.burst_pixels = speed.burst;
    scenario.bus.arbitration = Arbitration::kRoundRobin;
    scenario.memory.words_per_cycle = speed.words_per_cycle;
    scenario.memory.page_words = speed.page_words;
    scenario.memory.page_miss_cycles = speed.page_miss;
    scenario.composer.buffer_pixels = 1024;
    scenario.composer.ready_space_pixels = 16;
    scenario.link_timeout_pairs = 1;
    scenario.renderers.push_back(renderer_of({PixelImage(kImageWidth, kImageHeight)}));
    return scenario;
}

PixelImage image_of(std::uint64_t seed) { return noise_image(seed, kImageWidth, kImageHeight); }

/// Rows of 16 x 1 pixels each for displays 1, 2, ...: source row d to display d.
ViewportTable one_line_each(int displays) {
    ViewportTable table;
    for (int d = 1; d <= displays; ++d) {
        table.push_back(table_row(d, {0, d - 1}, {kImageWidth, 1}, {0, 0}));
    }
    return table;
}

std::vector<Pixel> segment_pixels(const PixelImage& image, const ViewportRow& row) {
    std::vector<Pixel> pixels;
    for (int y = row.sy; y < row.sy + row.sdy; ++y) {
        for (int x = row.sx; x < row.sx + row.sdx; ++x) pixels.push_back(image.at(x, y));
    }
    return pixels;
}

/// All pixels that were sent to a display from a clock on, and before another.
std::vector<Pixel> sent_to(const InputBench& dut, int destination, int from, int to) {
    std::vector<Pixel> pixels;
    for (int clock = from; clock < to; ++clock) {
        const BusBeat& beat = dut.beats.at(clock);
        if (beat.kind != BeatKind::kPixels || beat.destination != destination) continue;
        for (int i = 0; i < beat.count; ++i) pixels.emplace_back(beat.words[static_cast<std::size_t>(i)]);
    }
    return pixels;
}

/// A machine whose second pair is whole long before it is asked for.
struct Crossing {
    static constexpr int kFirstVerdict = 300;
    ClockedTestbench& bench;
    ClockDomain& link;
    InputBench dut;
    int verdict;
    int last_beat;  ///< of the first frame, which a low BUSREADY holds back until then

    Crossing(ClockedTestbench& of, const std::string& name, int period)
        : bench(of),
          link(of.add_clock((name + "_link").c_str(), period)),
          dut(of, name, input_scenario({}, 1, 2), &link) {
        dut.put_pair_until(kFirstVerdict, 0, one_line_each(1), image_of(84));
        verdict = dut.put_pair(kFirstVerdict + 1, 1, one_line_each(1), image_of(85));
        const int hold = static_cast<int>((verdict + 10) * std::int64_t{period} /
                                          ClockedTestbench::kCorePeriodPicoseconds);
        dut.drop_busready(1, 0, hold);
        last_beat = hold + kImageWidth - 1;
    }
    void check() const {
        const int answered = seen_at(bench.core, last_beat + 1, link);
        CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
              std::vector<int>{seen_at(link, kFirstVerdict, bench.core) + 1,
                               seen_at(link, answered, bench.core) + 1});
        CHECK(dut.requests.falls() == std::vector<int>{verdict});
        CHECK(dut.requests.rises() == std::vector<int>{0, answered});
    }
};

TEST_CASE("input framebuffer: timing: a request or an answer changes domains registers of the receiver") {
    ClockedTestbench bench;
    constexpr int kFasterPeriod = 6'100;
    constexpr int kSlowerPeriod = 33'300;
    const Crossing faster(bench, "faster", kFasterPeriod);
    const Crossing slower(bench, "slower", kSlowerPeriod);
    bench.run_through(slower.last_beat + 150);
    faster.check();
    slower.check();
}

TEST_CASE(
    "input framebuffer: timing: shared ports last pixel of a block to its half full half full to the first "
    "clock that may write it") {
    ClockedTestbench bench;
    Scenario scenario = input_scenario({});
    scenario.memory.ports = MemoryPorts::kShared;
    scenario.memory.write_block_words = 8;
    InputBench dut(bench, "dut", scenario);
    const auto& full = bench.core.record(dut.framebuffer.inner_wires()->write_full[0]);
    const auto& commands = bench.core.record_sampled(dut.framebuffer.inner_wires()->command);
    dut.put_colour(10, 0, {}, image_of(86));  // edge 18 reads the block's last pixel
    bench.run_through(30);
    CHECK(full.rises() == std::vector<int>{19});
    CHECK(commands
              .clocks_where([](const rtl::MemoryCommand& command) {
                  return command.kind != rtl::MemoryCommand::Kind::kNone;
              })
              .front() == 22);
}

TEST_CASE("input framebuffer: rows that break a rule are dropped and counted, the others are broadcast") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 2));
    const ViewportRow good = table_row(2, {0, 0}, {4, 1}, {0, 0});
    dut.put_pair_until(kVerdict, 0,
                       {table_row(3, {0, 0}, {1, 1}, {0, 0}), good, table_row(2, {0, 1}, {4, 1}, {0, 0}),
                        table_row(1, {14, 0}, {4, 1}, {0, 0})},
                       image_of(89));
    bench.run_through(kFrameStart + 50);
    const int row_clock = kFrameStart + 2;
    REQUIRE(dut.clocks_of(BeatKind::kTableRow) == std::vector<int>{row_clock});
    CHECK(dut.beats.at(row_clock).row() == good);
    CHECK(dut.beats.at(row_clock).last);
    const auto& rejected = dut.counters().rejected_rows;
    CHECK(rejected[static_cast<std::size_t>(RowDefect::kDisplay)] == 1);
    CHECK(rejected[static_cast<std::size_t>(RowDefect::kDuplicate)] == 1);
    CHECK(rejected[static_cast<std::size_t>(RowDefect::kSource)] == 1);
    CHECK(dut.counters().rejected_row_messages.size() == 3);
}

/// DVI input clocks after which a pair is given up: the pair times, and the vertical sync of a link that comes up.
constexpr int kTimeout =
    2 * frame_clocks(kImageWidth, kImageHeight + 1) + kSyncLines * line_clocks(kImageWidth);
constexpr int kLastBeat = kFrameStart + 2 + kImageWidth;  ///< of the first frame with one_line_each(1)

TEST_CASE(
    "input framebuffer: lockstep repeats the last pair in the clock that reports the wanted one as lost") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 2));
    InputBench other(bench, "other", input_scenario({}, 1, 2));
    constexpr int kLost = kLastBeat + 200;
    for (InputBench* const each : {&dut, &other}) {
        each->put_pair_until(kVerdict, 0, one_line_each(1), image_of(99));
    }
    dut.pair_lost(kLost, 1);
    other.pair_lost(kLost, 2);  // not the one that is waited for
    bench.run_through(kLost + 20);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, kLost + kVerdictToFrameStart});
    CHECK(other.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart});
    CHECK(dut.framebuffer.frame_sources()[1].pair == 0);
    CHECK_FALSE(dut.framebuffer.frame_sources()[1].fresh);
}

TEST_CASE("input framebuffer: lockstep gives a pair up when its time is over, not a clock earlier or later") {
    ClockedTestbench bench;
    InputBench never(bench, "never", input_scenario({}, 2, 2));
    InputBench second(bench, "second", input_scenario({}, 1, 2));
    second.put_pair_until(kVerdict, 0, one_line_each(1), image_of(100));
    bench.run_through(2 * kTimeout + 50);
    // The first link clock is clock 0: the timeout is over at clock kTimeout - 1. A renderer that has had no pair
    // contributes an empty table.
    constexpr int kFirst = kTimeout - 1 + kVerdictToFrameStart;
    CHECK(never.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFirst, kFirst + kTimeout});
    CHECK(never.beats.at(kFirst).last);
    CHECK(never.framebuffer.frame_sources()[0].pair == -1);
    // The next one's time runs from the answer before it.
    CHECK(second.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, kVerdict + kTimeout + kVerdictToFrameStart});
}

TEST_CASE(
    "input framebuffer: lockstep drops a pair that comes after it was given up, and frees its bank at once") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 3));
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(103));
    constexpr int kGivenUp = kVerdict + kTimeout;
    constexpr int kLate = kGivenUp + 400;
    dut.put_pair_until(kLate, 1, one_line_each(1), image_of(104));
    const int next = dut.put_pair(kLate + 1, 2, one_line_each(1), image_of(105));
    bench.run_through(next + 20);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, kGivenUp + kVerdictToFrameStart, next + kVerdictToFrameStart});
    CHECK(dut.counters().dropped_frames == 1);
    CHECK(dut.counters().repeated_frames == 1);
    CHECK(dut.requests.falls().empty());
}

// ---- under a random host ----

/// The monitors of the blocks inside, which judge arbiter and memory at each clock.
struct InnerMonitors {
    monitors::ArbiterMonitor arbiter;
    monitors::MemoryMonitor memory;

    InnerMonitors(ClockedTestbench& bench, InputBench& dut, const std::string& name)
        : arbiter((name + "_arbiter_monitor").c_str(), dut.scenario, 0, dut.violations),
          memory((name + "_memory_monitor").c_str(), dut.scenario, 0, dut.violations) {
        rtl::FramebufferWires& wires = *dut.framebuffer.inner_wires();
        arbiter.clk_i(dut.core.clk);
        arbiter.reset_i(bench.reset);
        arbiter.start_i(wires.start);
        arbiter.table_i(wires.table);
        arbiter.take_i(wires.take);
        arbiter.grant_valid_i(wires.grant_valid);
        arbiter.search_i(wires.search);
        arbiter.lost_i(wires.lost);
        arbiter.recovered_i(wires.recovered);
        arbiter.slot_i(wires.slot);
        for (std::size_t line = 0; line < wires.pending.size(); ++line) {
            arbiter.pending_i[line](wires.pending[line]);
            arbiter.ready_i[line](wires.ready[line]);
            arbiter.grant_i[line](wires.grant[line]);
            if (wires.deadline.size() > 0) arbiter.deadline_i[line](wires.deadline[line]);
        }
        memory.clk_i(dut.core.clk);
        memory.reset_i(bench.reset);
        memory.write_clk_i(dut.link.clk);
        memory.write_i(wires.write);
        memory.front_i(wires.front);
        memory.command_i(wires.command);
        memory.data_i(wires.data);
        if (dut.scenario.memory.shared()) memory.write_data_i[0](wires.write_data);
    }
};

/// A host that sends pair after pair, and loses some. It begins one only while it is asked for.
class RandomHost {
  public:
    struct Pair {
        ViewportTable table;
        PixelImage image;
    };
    /// From one reset to the next.
    struct Round {
        int from_clock = 0;  ///< of the core
        std::vector<Pair> pairs;
        std::vector<FrameSource> frames;
    };

    RandomHost(ClockedTestbench& bench, InputBench& dut, std::uint64_t seed)
        : bench_(bench), dut_(dut), random_(seed), rounds_(1) {
        dut.link.each_clock([this](int clock) { link_clock(clock); });
        for (std::size_t d = 0; d < dut.busready.size(); ++d) {
            const int odds = random_.between(1, 6);
            dut.core.each_clock([this, d, odds](int) {
                dut_.busready[d]->write(odds == 1 || !random_.one_in(odds));
                dut_.tableready[d]->write(!random_.one_in(odds));
            });
        }
    }

    /// Every frame has the pixels of one whole pair, by that pair's table. Returns how many were of new pairs.
    int check_frames() {
        rounds_.back().frames = dut_.framebuffer.frame_sources();
        const std::vector<int> starts = dut_.clocks_of(BeatKind::kFrameStart);
        int fresh = 0;
        for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
            const auto after = std::find_if(rounds_.begin(), rounds_.end(),
                                            [&](const Round& round) { return round.from_clock > starts[i]; });
            const Round& round = *std::prev(after);
            const std::uint32_t frame = dut_.beats.at(starts[i]).frame;
            if (dut_.beats.at(starts[i + 1]).frame != frame + 1) continue;  // a reset has cut it off
            INFO("frame " << frame << " at clock " << starts[i]);
            const int pair = round.frames.at(frame).pair;
            for (int d = 1; d <= dut_.scenario.displays.count(); ++d) {
                std::vector<Pixel> due;
                if (pair >= 0) {
                    const Pair& of = round.pairs.at(static_cast<std::size_t>(pair));
                    for (const ViewportRow& row : of.table) {
                        if (row.dcomp == d) due = segment_pixels(of.image, row);
                    }
                }
                REQUIRE(sent_to(dut_, d, starts[i], starts[i + 1]) == due);
            }
            const bool in_step = dut_.scenario.pacing == Pacing::kLockstep;
            if (round.frames[frame].fresh && in_step) CHECK(pair == static_cast<int>(frame));
            fresh += round.frames[frame].fresh ? 1 : 0;
        }
        check_counters();
        return fresh;
    }

  private:
    /// Of each round's whole pairs, one may still wait for its frame when the round ends.
    void check_counters() const {
        int repeated = 0;
        int fresh = 0;
        for (const Round& round : rounds_) {
            for (const FrameSource& frame : round.frames) ++(frame.fresh ? fresh : repeated);
        }
        const auto whole = std::count_if(verdicts_.begin(), verdicts_.end(),
                                         [this](int verdict) { return verdict < dut_.link.clock(); });
        const RendererCounters counters = dut_.framebuffer.counters();
        CHECK(counters.repeated_frames == repeated);
        CHECK(counters.rejected_slot_tables == 0);
        CHECK(counters.dropped_frames <= whole - fresh);
        CHECK(counters.dropped_frames >= whole - fresh - static_cast<int>(rounds_.size()));
    }
    void link_clock(int clock) {
        if (bench_.reset.read()) {
            if (!in_reset_) {
                rounds_.back().frames = dut_.framebuffer.frame_sources();
                rounds_.push_back({dut_.core.clock() + 1, {}, {}});
                dut_.forget_link_from(clock);
                while (!verdicts_.empty() && verdicts_.back() >= clock) verdicts_.pop_back();
            }
            in_reset_ = true;
            free_from_ = clock + 2;
            return;
        }
        if (in_reset_) dut_.framebuffer.forget_frames();
        in_reset_ = false;
        if (clock < free_from_ || !dut_.requests.at(clock - 1) || !random_.one_in(20)) return;
        const auto number = static_cast<std::uint32_t>(rounds_.back().pairs.size());
        Pair pair{{}, noise_image(random_, kImageWidth, kImageHeight)};
        for (int d = 1; d <= dut_.scenario.displays.count(); ++d) {
            if (random_.one_in(4)) continue;
            const int x = random_.between(0, kImageWidth - 1);
            const int y = random_.between(0, kImageHeight - 1);
            pair.table.push_back(table_row(
                d, {x, y}, {random_.between(1, kImageWidth - x), random_.between(1, kImageHeight - y)},
                {0, 0}, random_.between(1, 3)));
        }
        rounds_.back().pairs.push_back(pair);
        if (random_.one_in(12)) {
            dut_.pair_lost(clock + 1, number);  // it does not come at all
            free_from_ = clock + 2 + (random_.one_in(2) ? 2000 : 0);
        } else if (random_.one_in(8)) {
            const int depth = dut_.put_colour(clock + 1, number, pair.table, pair.image);
            dut_.event_at(depth).rejected = true;
            dut_.pair_lost(depth, number);
            free_from_ = depth + 1;
        } else {
            // The words that wait in a write buffer must be in the memory by then.
            const int pause = dut_.scenario.memory.shared() ? 40 : 0;
            verdicts_.push_back(dut_.put_pair(clock + 1, number, pair.table, pair.image, pause));
            free_from_ = verdicts_.back() + 1;
        }
    }

    ClockedTestbench& bench_;
    InputBench& dut_;
    Random random_;
    std::vector<Round> rounds_;
    std::vector<int> verdicts_;  ///< clocks at which a pair turns out good
    bool in_reset_ = false;
    int free_from_ = 2;
};

Scenario random_scenario(Random& random, std::int64_t link_period_picoseconds) {
    BusSpeed speed;
    speed.width_bits = 16 << random.between(0, 5);
    speed.words_per_cycle = random.between(1, 8);
    speed.burst = random.between(1, 20);
    speed.page_words = random.between(4, 40);
    speed.page_miss = random.between(1, 6);
    Scenario scenario = input_scenario(speed, random.between(1, 3), 1000);
    scenario.bus.arbitration = kArbitrationTable[static_cast<std::size_t>(random.between(0, 3))].value;
    scenario.bus.grant_cycles = random.one_in(3) ? random.between(1, 3) : 0;
    scenario.bus.slot_table = random.one_in(3) ? SlotTableMaker::kBuilt : SlotTableMaker::kHost;
    scenario.pacing = random.one_in(2) ? Pacing::kFreeRunning : Pacing::kLockstep;
    scenario.memory.banks = random.between(1, 3);
    scenario.memory.precharge_cycles = random.between(0, speed.page_miss - 1);
    scenario.memory.read_latency_cycles = random.one_in(3) ? random.between(1, 4) : 0;
    scenario.bus.register_stages = random.one_in(3) ? random.between(1, 2) : 0;
    if (random.one_in(2)) {
        scenario.memory.refresh_interval_cycles = 60;
        scenario.memory.refresh_cycles = random.between(1, 6);
    }
    const bool slow = link_period_picoseconds > ClockedTestbench::kCorePeriodPicoseconds;
    if (slow && random.one_in(2)) {
        scenario.memory.ports = MemoryPorts::kShared;
        scenario.memory.page_words = 16 * random.between(1, 3);
        scenario.memory.write_block_words = 8 * random.between(1, 2);
    }
    scenario.composer.ready_space_pixels = in_flight_pixels(scenario.bus, scenario.memory);
    return scenario;
}

TEST_CASE(
    "input framebuffer: under a random host no monitor complains, and each frame is of one whole pair") {
    const auto seed = random_seed(121);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ClockedTestbench bench;
    constexpr std::array kLinkPeriods{6'100, 12'000, 33'300};
    std::vector<ClockDomain*> links;
    for (const int period : kLinkPeriods)
        links.push_back(&bench.add_clock(("link_" + std::to_string(period)).c_str(), period));
    struct Run {
        std::unique_ptr<InputBench> dut;
        std::unique_ptr<InnerMonitors> monitors;
        std::unique_ptr<RandomHost> host;
    };
    std::vector<Run> runs;
    std::vector<std::string> complaints;
    constexpr int kRuns = 24;
    constexpr int kClocks = 4000;
    for (int i = 0; i < kRuns; ++i) {
        const auto link = static_cast<std::size_t>(i) % links.size();
        const std::string name = "dut_" + std::to_string(i);
        Run& run = runs.emplace_back();
        run.dut = std::make_unique<InputBench>(bench, name, random_scenario(random, kLinkPeriods[link]),
                                               links[link]);
        run.monitors = std::make_unique<InnerMonitors>(bench, *run.dut, name);
        run.host = std::make_unique<RandomHost>(bench, *run.dut, random.bits());
        run.dut->violations.on_violation([&complaints, name](const monitors::Violation& violation) {
            complaints.push_back(name + ": " + violation.rule + " at " + std::to_string(violation.cycle) +
                                 ": " + violation.detail);
        });
    }
    for (int clock = 700; clock < kClocks; clock += random.between(700, 2500)) {
        bench.core.drive(bench.reset, clock, true);
        bench.core.drive(bench.reset, clock + 10, false);  // a few clocks of the slowest link
    }
    bench.run_through(kClocks);
    if (!complaints.empty()) FAIL(complaints.front());
    int fresh = 0;
    for (const Run& run : runs) {
        INFO(run.dut->framebuffer.name());
        fresh += run.host->check_frames();
    }
    CHECK(fresh > 50);
}

}  // namespace
}  // namespace metabuffer::test::input_framebuffer_test
