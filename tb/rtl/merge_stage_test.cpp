#include "rtl/merge_stage.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <climits>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "composer_scenario.h"
#include "expected_report.h"
#include "painted_raster.h"
#include "support/random_seed.h"
#include "support/traced_values.h"

namespace metabuffer::test::merge_stage_test {
namespace {

using rtl::FifoRead;
using rtl::FifoWrite;
using rtl::MergeStage;
using rtl::PipePixel;
using rtl::SegmentProgress;
using Clocks = std::vector<int>;

constexpr Size kRaster{kWidth, kHeight};
constexpr int kAddresses = 256;
constexpr int kNever = INT_MAX;

enum class Strap : std::uint8_t { kRelay, kMaster };

Scenario merge_scenario(StarvationMode mode = StarvationMode::kGlitch,
                        Smoothing smoothing = Smoothing::kReplicate) {
    Scenario scenario = composer_scenario({kAddresses, 16, 1}, mode);
    scenario.composer.smoothing = smoothing;
    return scenario;
}

/// Pixel k of the segment of a frame. Most are nearer than those from above, some are farther or tie with them.
Pixel local(int frame, std::int64_t k) {
    const auto value = static_cast<std::uint32_t>(k * 7 + frame * 1000 + 1);
    const std::uint32_t z = k % 5 == 3 ? 0x9000 : (k % 7 == 4 ? 0x8000 : 5);
    return {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value),
            static_cast<std::uint8_t>(255 - k), 255, z};
}
Pixel upstream(int position) { return {0xC0, 1, static_cast<std::uint8_t>(position), 128, 0x8000}; }

/// A frame as the test plays it. After the edge at which a pixel comes it is in the account, and on its way into the
/// FIFO.
struct Frame {
    int start = 0;  ///< the edge that sees its start, at the earliest
    std::optional<ViewportRow> row;
    std::vector<int> comes_at;  ///< by pixel, in order; pixels of one edge are a beat
    int abandoned_at = kNever;  ///< the edge that finds that something of it is lost
    std::uint32_t base_address = 250;
};

/// Every pixel comes at its own edge, first, first + 1, ...
std::vector<int> one_a_clock(const ViewportRow& row, int first) {
    return clock_range(first, first + row.sdx * row.sdy);
}

/// The composer's other parts, as far as they have no clock to themselves: its FIFO, and a column of two composers.
class Neighbours final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_signal<FifoWrite> write{"write"};
    sc_core::sc_signal<FifoRead> read{"read"}, row_read{"row_read"};
    sc_core::sc_signal<std::uint64_t> word{"word"}, next_word{"next_word"}, row_word{"row_word"},
        row_next_word{"row_next_word"};
    sc_core::sc_signal<bool> stall{"stall"}, other_stall{"other_stall"}, column_stall{"column_stall"};

    Neighbours(const sc_core::sc_module_name& name, int addresses)
        : sc_core::sc_module(name), words_(static_cast<std::size_t>(addresses)) {
        SC_METHOD(fifo_edge);
        sensitive << clk_i.pos();
        dont_initialize();
        SC_METHOD(join_stalls);
        sensitive << stall << other_stall;
    }
    SC_HAS_PROCESS(Neighbours);

  private:
    void fifo_edge() {
        for (std::uint32_t i = 0; i < write.read().count; ++i) {
            words_[(write.read().address + i) % words_.size()] = write.read().words[i];
        }
        put_out(read, word, next_word);
        put_out(row_read, row_word, row_next_word);
    }
    void put_out(const sc_core::sc_signal<FifoRead>& of, sc_core::sc_signal<std::uint64_t>& first,
                 sc_core::sc_signal<std::uint64_t>& second) {
        if (!of.read().enable) return;
        first.write(words_.at(of.read().address));
        second.write(words_.at((of.read().address + 1) % words_.size()));
    }
    void join_stalls() { column_stall.write(stall.read() || other_stall.read()); }

    std::vector<std::uint64_t> words_;
};

/// A merge stage whose walker, receiver and upstream neighbour the test plays. check() follows from the frames alone.
struct MergeBench {
    Scenario scenario;
    ClockDomain& core;
    bool may_stall;
    Record record;
    Neighbours around;
    sc_core::sc_signal<bool> pipemaster, running;
    sc_core::sc_signal<PipePixel> pipe_in, pipe_out;
    sc_core::sc_signal<RasterStep> ahead;
    sc_core::sc_signal<SegmentProgress> progress;
    MergeStage dut;
    const Recording<PipePixel>& pipes;     ///< what stands after each edge
    const Recording<bool>& stalls;         ///< as each edge samples it
    const Recording<bool>& column_stalls;  ///< the same
    const Recording<FifoRead>& reads;      ///< the same
    const Recording<FifoRead>& row_reads;
    std::vector<Frame> frames;
    std::set<int> other_stalls;  ///< edges at which another composer of the column stalls
    std::set<int> lost_above;    ///< raster positions that come from above marked as lost
    int restart_at = kNever;     ///< the first edge after a reset: the frame under way is over

    explicit MergeBench(ClockedTestbench& bench, Scenario with = merge_scenario(),
                        const std::string& name = "merge_stage", Strap strap = Strap::kRelay)
        : scenario(std::move(with)),
          core(bench.core),
          may_stall(scenario.composer.on_starvation == StarvationMode::kStall),
          around((name + "_neighbours").c_str(), scenario.composer.buffer_pixels),
          pipemaster((name + "_pipemaster").c_str(), strap == Strap::kMaster),
          dut(name.c_str(), scenario, record),
          pipes(core.record(pipe_out)),
          stalls(core.record_sampled(around.stall)),
          column_stalls(core.record_sampled(around.column_stall)),
          reads(core.record_sampled(around.read)),
          row_reads(core.record_sampled(around.row_read)) {
        around.clk_i(core.clk);
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.pipemaster_i(pipemaster);
        dut.pipe_i(pipe_in);
        dut.pipe_o(pipe_out);
        dut.column_stall_i(around.column_stall);
        dut.stall_o(around.stall);
        dut.running_i(running);
        dut.ahead_i(ahead);
        dut.progress_i(progress);
        dut.write_i(around.write);
        dut.read_o(around.read);
        dut.word_i(around.word);
        if (dut.second_row != nullptr) {
            dut.second_row->next_word_i(around.next_word);
            dut.second_row->row_read_o(around.row_read);
            dut.second_row->row_word_i(around.row_word);
            dut.second_row->row_next_word_i(around.row_next_word);
        }
        bench.trace(dut);
        core.each_clock([this](int clock) { play(clock); });
    }

    void add_frame(int start, const std::optional<ViewportRow>& row, std::vector<int> comes_at) {
        frames.push_back({start, row, std::move(comes_at)});
    }
    /// All of the segment has come by edge `start` - 3.
    void add_whole_frame(int start, const ViewportRow& row) {
        add_frame(start, row, one_a_clock(row, start - 2 - row.sdx * row.sdy));
    }
    PaintedRaster painted(const Frame& frame) const {
        return {frame.row, kRaster, scenario.composer.smoothing};
    }
    /// The edges at which a frame's positions are composited, given the one that sees its start.
    Clocks check_frame(std::size_t index, int start) const {
        const Frame& frame = frames[index];
        const PaintedRaster due = painted(frame);
        Clocks edges;
        int clock = start + 1;
        for (int position = 0; position < kPixels; ++position, ++clock) {
            const RasterStep& step = due.steps[static_cast<std::size_t>(position)];
            bool missing;
            while (missing = is_missing(frame, step, clock), may_stall) {
                INFO("clock " << clock << ", position " << position);
                REQUIRE(stalls.at(clock) == missing);
                if (!missing && other_stalls.count(clock) == 0) break;
                REQUIRE(pipes.at(clock) == pipes.at(clock - 1));
                ++clock;
            }
            const bool lost = frame.abandoned_at < clock;
            const bool master = pipemaster.read();
            const Pixel above = master ? Pixel(0, 0, 0, 0, 0xFFFF) : upstream(position);
            const bool shows = step.covered && !missing && !lost;
            INFO("clock " << clock << ", position " << position << ": " << step);
            REQUIRE(pipes.at(clock) ==
                    PipePixel{shows ? merged(mixed(static_cast<int>(index), step), above) : above, true,
                              lost || (!master && lost_above.count(position) != 0)});
            edges.push_back(clock);
        }
        return edges;
    }
    /// All frames, each of which starts when it is asked for or a clock after the one before.
    void check_frames() const {
        int free = 0;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            int start = std::max(frames[i].start, free);
            while (may_stall && other_stalls.count(start) != 0) ++start;
            INFO("frame " << i << " from clock " << start);
            free = check_frame(i, start).back() + 1;
            if (i + 1 < frames.size() && frames[i + 1].start <= free) continue;
            int after = free;  // the last pixel stands as long as the column does
            while (may_stall && other_stalls.count(after) != 0) ++after;
            CHECK(pipes.at(after) == PipePixel{});
        }
    }
    static bool is_missing(const Frame& frame, const RasterStep& step, int clock) {
        if (!step.covered || frame.abandoned_at < clock) return false;
        std::int64_t newest = step.pixel;
        for (const std::int64_t across : {0, step.across}) {
            for (const int beside : {0, step.beside}) newest = std::max(newest, step.pixel + across + beside);
        }
        return frame.comes_at.at(static_cast<std::size_t>(newest)) >= clock;
    }
    /// The reads of the first port: edge and address.
    std::vector<std::pair<int, std::uint32_t>> all_reads() const {
        std::vector<std::pair<int, std::uint32_t>> found;
        for (const int clock : reads.clocks_where([](const FifoRead& read) { return read.enable; })) {
            found.emplace_back(clock, reads.at(clock).address);
        }
        return found;
    }

  private:
    /// The formula of docs/design.md.
    static Pixel mixed(int frame, const RasterStep& step) {
        const auto channel = [&](std::uint8_t (Pixel::*of)() const) {
            const auto at = [&](std::int64_t k) { return (local(frame, k).*of)(); };
            const int wx = step.weight_x;
            const int wy = step.weight_y;
            const int sum = at(step.pixel) * (256 - wx) * (256 - wy) +
                            at(step.pixel + step.beside) * wx * (256 - wy) +
                            at(step.pixel + step.across) * (256 - wx) * wy +
                            at(step.pixel + step.beside + step.across) * wx * wy;
            return static_cast<std::uint8_t>((sum + 32768) / 65536);
        };
        return {channel(&Pixel::r), channel(&Pixel::g), channel(&Pixel::b), channel(&Pixel::a),
                local(frame, step.pixel).z()};
    }
    static Pixel merged(Pixel ours, Pixel above) { return ours.z() < above.z() ? ours : above; }

    /// What edge `clock` samples.
    void play(int clock) {
        const bool stood = may_stall && clock > 0 && column_stalls.at(clock - 1);
        if (clock == restart_at) {
            position_ = -1;
            ++frame_;
        } else if (!stood) {
            move(clock);
        }
        const bool runs = position_ >= 0;
        running.write(runs);
        if (frame_ < frames.size()) {
            const PaintedRaster raster = painted(frames[frame_]);
            const auto next = static_cast<std::size_t>(position_ + 1);
            ahead.write(next < raster.steps.size() ? raster.steps[next] : RasterStep{});
        } else {
            ahead.write(RasterStep{});
        }
        // Outside a frame there is what does not belong to one.
        pipe_in.write(runs ? PipePixel{upstream(position_), true, lost_above.count(position_) != 0}
                           : PipePixel{Pixel(0xABCDEF), true, true});
        play_receiver(clock);
        around.other_stall.write(other_stalls.count(clock) != 0);
    }
    void move(int clock) {
        if (position_ >= 0) {
            if (++position_ == kPixels) {
                position_ = -1;
                ++frame_;
            }
        } else if (frame_ < frames.size() && frames[frame_].start < clock && clock > last_end_ + 1) {
            position_ = 0;
            record.frame_started(clock - 1 + core.reset_clocks());  // the walker does
        }
        if (position_ < 0 && last_frame_ != frame_) {
            last_frame_ = frame_;
            last_end_ = clock - 1;
        }
    }
    void play_receiver(int clock) {
        SegmentProgress now;
        if (frame_ < frames.size()) {
            const Frame& frame = frames[frame_];
            now.base_address = frame.base_address;
            now.abandoned = frame.abandoned_at < clock;
            now.arrived = std::count_if(frame.comes_at.begin(), frame.comes_at.end(),
                                        [clock](int edge) { return edge < clock; });
        }
        progress.write(now);
        FifoWrite write;
        for (std::size_t f = 0; f < frames.size(); ++f) {
            for (std::size_t k = 0; k < frames[f].comes_at.size(); ++k) {
                if (frames[f].comes_at[k] != clock - 1) continue;
                if (write.count == 0) {
                    write.address = (frames[f].base_address + static_cast<std::uint32_t>(k)) %
                                    static_cast<std::uint32_t>(scenario.composer.buffer_pixels);
                }
                write.words.at(write.count++) =
                    local(static_cast<int>(f), static_cast<std::int64_t>(k)).word();
            }
        }
        around.write.write(write);
    }

    int position_ = -1;  ///< composited at the next edge; -1: no frame runs
    std::size_t frame_ = 0;
    std::size_t last_frame_ = 0;
    int last_end_ = -2;
};

TEST_CASE(
    "merge stage: the pixel from above leaves a clock later, merged, and between frames there is none") {
    ClockedTestbench bench;
    MergeBench dut(bench);
    dut.add_whole_frame(40, segment_row({3, 2}, {2, 1}));
    dut.add_whole_frame(90, whole_raster());
    bench.run_through(120);
    CHECK(dut.check_frame(0, 40) == clock_range(41, 41 + kPixels));
    dut.check_frames();
    for (const int clock : {10, 40, 41 + kPixels, 89}) CHECK(dut.pipes.at(clock) == PipePixel{});
    // Covered pixels show unless they are no nearer.
    CHECK(dut.pipes.at(41 + kWidth + 2).pixel == local(0, 0));
    CHECK(dut.pipes.at(91 + 3).pixel == upstream(3));
    CHECK(dut.pipes.at(91 + 4).pixel == upstream(4));
    CHECK(dut.record.counters().starved_pixels == 0);
}

TEST_CASE("merge stage: it composites as the scenario says") {
    ClockedTestbench bench;
    Scenario scenario = merge_scenario();
    scenario.composition = Composition::kOver;
    MergeBench dut(bench, scenario);
    dut.add_whole_frame(40, whole_raster());
    bench.run_through(70);
    CHECK(dut.pipes.at(41).pixel == local(0, 0));  // opaque and in front
    // Behind: what is in front lets 127 of 255 through.
    const Pixel back = local(0, 3);
    const auto over = [](int front, int behind) {
        return static_cast<std::uint8_t>(std::min(255.0, front + std::floor(behind * 127 / 255.0 + 0.5)));
    };
    CHECK(dut.pipes.at(44).pixel ==
          Pixel(over(0xC0, back.r()), over(1, back.g()), over(3, back.b()), over(128, back.a()), 0x8000));
}

/// Its background is not black.
Scenario coloured_scenario() {
    Scenario scenario = merge_scenario();
    scenario.displays.background[0] = 10;
    scenario.displays.background[1] = 20;
    scenario.displays.background[2] = 30;
    return scenario;
}
const PipePixel kColouredBackground{Pixel(10, 20, 30, 0, 0xFFFF), true, false};

TEST_CASE("merge stage: a PIPEMASTER makes the pixels from above itself, and a strap changes in reset only") {
    ClockedTestbench bench;
    MergeBench plain(bench, merge_scenario(), "plain", Strap::kMaster);
    MergeBench coloured(bench, coloured_scenario(), "coloured", Strap::kMaster);
    for (MergeBench* dut : {&plain, &coloured}) {
        dut->lost_above = {2, 5};
        dut->add_whole_frame(40, segment_row({1, 1}, {2, 1}));
    }
    bench.core.drive(coloured.pipemaster, 20, false);
    bench.run_through(70);
    plain.check_frames();
    CHECK(coloured.pipes.at(41) == kColouredBackground);
    CHECK(coloured.pipes.at(41 + kWidth + 2).pixel == local(0, 0));
}

TEST_CASE(
    "merge stage: a pixel that comes at the edge before its use bypasses the FIFO, at its use it starves") {
    ClockedTestbench bench;
    MergeBench dut(bench);
    const ViewportRow row = segment_row({kWidth, 2}, {0, 1});
    auto comes = one_a_clock(row, 40 + kWidth);  // position p is composited at edge 41 + p
    comes[8] = comes[9] = comes[10] =
        comes[10] + 1;  // a beat: the first two of it are too late by two clocks and one
    comes[11] = comes[11] + 1;
    dut.add_frame(40, row, comes);
    bench.run_through(41 + kWidth + 8);
    CHECK(shows(dut.dut, "starved[1]=1"));
    bench.run_through(70);
    CHECK(shows(dut.dut, "starved[1]=0"));  // between frames nothing leaves that could lack a pixel
    dut.check_frames();
    CHECK(dut.pipes.at(41 + kWidth).pixel == local(0, 0));
    CHECK(dut.record.counters().starved_pixels == 4);
    CHECK(dut.record.counters().starved_run_count == 1);
    CHECK(dut.record.first_starved_cycle() == 41 + kWidth + 8 + bench.core.reset_clocks());
    CHECK(dut.all_reads().empty());  // each was taken from the beat
}

TEST_CASE("merge stage: the FIFO is read one position ahead, and not while a column is replicated") {
    ClockedTestbench bench;
    MergeBench dut(bench);
    const ViewportRow row = segment_row({2, 2}, {1, 0}, 2);
    dut.add_whole_frame(40, row);
    bench.run_through(70);
    dut.check_frames();
    // A read is two edges before the use: one for the word, one for the position. Each raster row reads its two pixels.
    std::vector<std::pair<int, std::uint32_t>> due;
    for (int y = 0; y < 4; ++y) {
        for (int i = 0; i < 2; ++i) {
            due.emplace_back(41 + y * kWidth + 1 + 2 * i - 1, (250 + y / 2 * 2 + i) % kAddresses);
        }
    }
    CHECK(dut.all_reads() == due);
    CHECK(dut.record.counters().replayed_pixels == 8);
}

TEST_CASE("merge stage: addresses go on with the first after the last one, in the FIFO and in a beat") {
    ClockedTestbench bench;
    MergeBench dut(bench);
    auto comes = std::vector<int>(kPixels);
    for (int k = 0; k < kPixels; ++k) comes[static_cast<std::size_t>(k)] = 40 + k / 8 * 8;  // beats of eight
    dut.add_frame(40, whole_raster(), comes);
    // Here the last pixel of each beat is just in time. The first beat's lies beyond the last address.
    for (int& edge : comes) edge += 67;
    dut.add_frame(100, whole_raster(), comes);
    bench.run_through(140);
    dut.check_frames();
    CHECK(dut.record.counters().starved_pixels_of(0) == 0);
    CHECK(dut.record.counters().starved_pixels_of(1) == 21);
    CHECK(dut.all_reads().front() == std::pair<int, std::uint32_t>{41, 251});
    CHECK(dut.reads.at(46).address == 0);
}

TEST_CASE("merge stage: in stall mode STALL is high until the pixel has come, and falls in that clock") {
    ClockedTestbench bench;
    MergeBench dut(bench, merge_scenario(StarvationMode::kStall));
    const ViewportRow row = segment_row({kWidth, 1}, {0, 1});
    auto comes = one_a_clock(row, 10);
    for (std::size_t k = 2; k < comes.size(); ++k) comes[k] = 60;
    dut.add_frame(40, row, comes);
    bench.run_through(120);
    const int due = 41 + kWidth + 2;  // the edge that would composite pixel 2
    CHECK(dut.stalls.high() == clock_range(due, 61));
    dut.check_frames();
    CHECK(dut.record.counters().stalled_cycles == 61 - due);
    CHECK(dut.record.counters().starved_pixels == 0);
    CHECK(dut.record.first_starved_cycle() == due - 1 + bench.core.reset_clocks());
}

TEST_CASE(
    "merge stage: while the column stands still the FIFO may be read over a pixel that is still to be used") {
    ClockedTestbench bench;
    MergeBench stall(bench, merge_scenario(StarvationMode::kStall), "stall");
    MergeBench glitch(bench, merge_scenario(), "glitch");
    for (MergeBench* dut : {&stall, &glitch}) {
        dut->add_whole_frame(40, whole_raster());
        dut->other_stalls = {39, 40, 44, 45, 46, 50, 52, 60};
    }
    bench.run_through(100);
    stall.check_frames();
    CHECK(stall.stalls.high().empty());
    CHECK(stall.record.counters().stalled_cycles == 0);  // they are another composer's
    // Position 2 waits at the edges 44 to 46 while position 3 is read.
    CHECK(stall.reads.at(44) == FifoRead{true, 250 + 3});
    CHECK_FALSE(stall.reads.at(45).enable);
    glitch.check_frames();  // nothing ever raises it there, so it is not read
}

TEST_CASE(
    "merge stage: from the clock in which the frame is abandoned all passes marked as lost, without "
    "waiting") {
    ClockedTestbench bench;
    MergeBench stall(bench, merge_scenario(StarvationMode::kStall), "stall");
    MergeBench glitch(bench, merge_scenario(), "glitch");
    for (MergeBench* dut : {&stall, &glitch}) {
        auto comes = one_a_clock(whole_raster(), 10);
        for (std::size_t k = 6; k < comes.size(); ++k) comes[k] = k < 8 ? 80 : kNever;
        dut->add_frame(40, whole_raster(), comes);
        dut->frames[0].abandoned_at = dut == &stall ? 52 : 44;
    }
    bench.run_through(100);
    stall.check_frames();
    glitch.check_frames();
    CHECK(stall.stalls.high() == clock_range(47, 53));  // from the edge of position 6 on
    CHECK(stall.pipes.at(53) == PipePixel{upstream(6), true, true});
    CHECK(glitch.pipes.at(44) == PipePixel{upstream(3), true, false});
    CHECK(glitch.pipes.at(45) == PipePixel{upstream(4), true, true});
    CHECK(glitch.record.counters().starved_pixels == 0);
    for (const auto& [clock, address] : glitch.all_reads()) CHECK(clock <= 44);
}

TEST_CASE("merge stage: a pixel that comes marked as lost leaves marked as lost") {
    ClockedTestbench bench;
    MergeBench dut(bench);
    dut.lost_above = {0, 7, kPixels - 1};
    dut.add_whole_frame(40, segment_row({3, 2}, {0, 1}));
    bench.run_through(80);
    dut.check_frames();
    CHECK(dut.pipes.at(41).lost);
    CHECK(dut.pipes.at(48) == PipePixel{local(0, 1), true, true});
}

TEST_CASE("merge stage: smoothed, a raster pixel is mixed of four pixels and waits for the newest of them") {
    ClockedTestbench bench;
    MergeBench whole(bench, merge_scenario(StarvationMode::kGlitch, Smoothing::kBilinear), "whole");
    MergeBench late(bench, merge_scenario(StarvationMode::kGlitch, Smoothing::kBilinear), "late");
    MergeBench stalls(bench, merge_scenario(StarvationMode::kStall, Smoothing::kBilinear), "stalls");
    const ViewportRow row = segment_row({4, 3}, {-1, -1}, 2);
    whole.add_whole_frame(40, row);
    // The second source row comes as the raster's second row needs it, at m = 2 from its very beginning.
    auto comes = one_a_clock(row, 10);
    for (std::size_t k = 4; k < comes.size(); ++k) comes[k] = 36 + static_cast<int>(k);
    late.add_frame(40, row, comes);
    stalls.add_frame(40, row, comes);
    bench.run_through(120);
    whole.check_frames();
    late.check_frames();
    stalls.check_frames();
    CHECK(whole.record.counters().starved_pixels == 0);
    CHECK(late.record.counters().starved_pixels > 0);
    // Both rows are read, each once for two columns of a source pixel.
    CHECK_FALSE(whole.row_reads.clocks_where([](const FifoRead& read) { return read.enable; }).empty());
}

TEST_CASE("merge stage: its window has registers for each column of each row, and they know what has come") {
    ClockedTestbench bench;
    MergeBench replicates(bench, merge_scenario(), "replicates");
    MergeBench smooths(bench, merge_scenario(StarvationMode::kGlitch, Smoothing::kBilinear), "smooths");
    for (MergeBench* dut : {&replicates, &smooths}) dut->add_whole_frame(40, segment_row({1, 1}, {}, 8));
    bench.run_through(50);
    const auto values = [](const MergeBench& dut, const std::string& of) {
        std::vector<std::string> found;
        for (const std::string& line : traced_values(dut.dut)) {
            if (line.find(of) != std::string::npos) found.push_back(line.substr(line.find('=') + 1));
        }
        return found;
    };
    // The only pixel is at hand, and no other one.
    const int bits = rtl::segment_pixel_bits(smooths.scenario);
    const std::string none = std::to_string((1ULL << bits) - 1);
    CHECK(values(replicates, ".word_pixel") == std::vector<std::string>{"0"});
    CHECK(values(smooths, ".word_pixel") == std::vector<std::string>{"0", none, none, none});
    CHECK(values(replicates, ".bypass_pixel") == std::vector<std::string>(1, none));
    CHECK(values(smooths, ".bypass_pixel") == std::vector<std::string>(4, none));
    CHECK(values(replicates, ".bypass_word") == std::vector<std::string>(1, "0"));
    CHECK(values(smooths, ".bypass_word") == std::vector<std::string>(4, "0"));
}

TEST_CASE("merge stage: a pixel that has come and is neither in the FIFO nor in the beat is reported") {
    ExpectedReport report("/metabuffer/merge_stage/pixel");
    ClockedTestbench bench;
    MergeBench dut(bench);
    const ViewportRow row = segment_row({kWidth, 1}, {0, 1});
    dut.add_frame(40, row, one_a_clock(row, 40 + kWidth));  // each just in time
    bench.core.each_clock([&dut](int clock) {
        // In the place of pixel 3's beat comes that of pixel 2 again.
        if (clock == 41 + kWidth + 3) dut.around.write.write(FifoWrite{1, 250 + 2, {}});
    });
    bench.run_through(70);
    CHECK(report.count() == 1);
}

TEST_CASE("merge stage: what is at hand at a frame's end is not taken for the next frame's") {
    ClockedTestbench bench;
    MergeBench dut(bench);
    // A frame of a single source pixel each, so that it has the same index.
    const ViewportRow row = segment_row({1, 1}, {}, 8);
    dut.add_whole_frame(20, row);
    dut.add_frame(20 + kPixels + 1, row, {30});  // at once
    dut.add_frame(100, row, {100});              // at the very edge that sees the start
    dut.frames[1].base_address = 251;
    dut.frames[2].base_address = 252;
    bench.run_through(140);
    dut.check_frames();
    CHECK(dut.record.counters().starved_pixels == 0);
}

TEST_CASE("merge stage: reset in a frame leaves what power-up leaves") {
    ClockedTestbench bench;
    MergeBench replicates(bench, merge_scenario(StarvationMode::kStall), "replicates");
    MergeBench smooths(bench, merge_scenario(StarvationMode::kStall, Smoothing::kBilinear), "smooths");
    for (MergeBench* dut : {&replicates, &smooths}) {
        const ViewportRow row = segment_row({1, 1}, {}, 8);
        dut->add_whole_frame(20, row);
        dut->add_frame(60, row, {55});
        dut->frames[1].base_address = 251;
        dut->restart_at = 32;
    }
    bench.core.drive(bench.reset, 30, true);
    bench.core.drive(bench.reset, 32, false);
    bench.run_through(100);
    for (MergeBench* dut : {&replicates, &smooths}) {
        CHECK(dut->pipes.at(29).valid);
        for (int clock = 30; clock < 61; ++clock) CHECK(dut->pipes.at(clock) == PipePixel{});
        CHECK(dut->check_frame(1, 60) == clock_range(61, 61 + kPixels));
    }
}

TEST_CASE("merge stage: a reset wakes a block that sleeps, and it reads its strap") {
    ClockedTestbench bench;
    MergeBench dut(bench, coloured_scenario());
    dut.add_whole_frame(60, segment_row({1, 1}, {2, 1}));
    bench.core.drive(dut.pipemaster, 5, true);
    bench.core.drive(bench.reset, 40, true);
    bench.core.drive(bench.reset, 42, false);
    bench.run_through(90);
    CHECK(dut.pipes.at(61) == kColouredBackground);
}

TEST_CASE(
    "merge stage: random segments, arrivals and stalls give the pixels that are due, each at its clock") {
    const auto seed = random_seed(2219);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kFrames = 4;
    ClockedTestbench bench;
    std::vector<std::unique_ptr<MergeBench>> duts;
    for (int i = 0; i < 24; ++i) {
        const bool smooths = i % 2 == 1;
        const bool may_stall = i % 4 < 2;
        duts.push_back(std::make_unique<MergeBench>(
            bench,
            merge_scenario(may_stall ? StarvationMode::kStall : StarvationMode::kGlitch,
                           smooths ? Smoothing::kBilinear : Smoothing::kReplicate),
            "dut_" + std::to_string(i)));
        MergeBench& dut = *duts.back();
        int clock = 5;
        int comes = 0;
        auto address = static_cast<std::uint32_t>(random.between(0, kAddresses - 1));
        for (int frame = 0; frame < kFrames; ++frame) {
            std::optional<ViewportRow> row;
            if (!random.one_in(8)) {
                row =
                    smooths ? random_smoothed_row(random, kRaster, 6) : random_valid_row(random, kRaster, 6);
            }
            const int pixels = row ? row->sdx * row->sdy : 0;
            clock += random.between(0, 40);
            comes = std::max(comes + 1, clock + random.between(-60, 20));
            const int pace = random.between(1, 4);
            std::vector<int> arrivals;
            while (static_cast<int>(arrivals.size()) < pixels) {
                const int count = std::min(random.between(1, random.one_in(2) ? 8 : 1),
                                           pixels - static_cast<int>(arrivals.size()));
                arrivals.insert(arrivals.end(), static_cast<std::size_t>(count), comes);
                comes += random.between(1, random.one_in(6) ? 12 : pace);
            }
            dut.add_frame(clock, row, arrivals);
            dut.frames.back().base_address = address % kAddresses;
            address += static_cast<std::uint32_t>(pixels);
            if (random.one_in(6)) dut.frames.back().abandoned_at = clock + random.between(0, 40);
            // The next frame's pixels may come in this one. In `glitch` mode it ends here; a stalled one later.
            clock += kPixels + 1;
        }
        for (int edge = 0; edge < 600; ++edge) {
            if (random.one_in(5)) dut.other_stalls.insert(edge);
        }
    }
    bench.run_through(1200);
    std::int64_t starved = 0;
    std::int64_t stalled = 0;
    for (std::size_t i = 0; i < duts.size(); ++i) {
        INFO("device " << i);
        duts[i]->check_frames();
        starved += duts[i]->record.counters().starved_pixels;
        stalled += duts[i]->record.counters().stalled_cycles;
    }
    CHECK(starved > 0);
    CHECK(stalled > 0);
}

TEST_CASE("merge stage: a pixel that has not come is not the one that is being written at its address") {
    ClockedTestbench bench;
    constexpr int kFew = 16;
    constexpr int kAbove = kFew + 1;  // pixels above the raster: the first one in it has pixel 1's address
    constexpr int kPixelsPerBeat = 4;
    Scenario scenario = merge_scenario();
    scenario.composer.buffer_pixels = kFew;
    MergeBench dut(bench, scenario);
    // No table has a row so far above the raster, but all that the stage sees of it is which pixel is wanted.
    // One pixel wide and twice as large: each pixel is shown in two rows, and none other comes in between.
    constexpr int kStart = 40;
    const ViewportRow row = segment_row({1, kAbove + 2}, {2, -2 * kAbove}, 2);
    std::vector<int> comes_at;
    for (int k = 0; k < row.sdy; ++k) comes_at.push_back(kStart + 1 + k / kPixelsPerBeat);
    dut.add_frame(kStart, row, comes_at);
    dut.frames.front().base_address = 0;
    bench.run_through(kStart + kPixels + 4);
    dut.check_frames();
    const int first_row = kStart + 1 + row.dx;
    CHECK(dut.pipes.at(first_row).pixel == upstream(row.dx));  // it starves, while pixel 1 is written
    CHECK(dut.pipes.at(first_row + kWidth).pixel == local(0, kAbove));
}

}  // namespace
}  // namespace metabuffer::test::merge_stage_test
