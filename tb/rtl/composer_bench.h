#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "monitors/composer_monitor.h"
#include "rtl/composer.h"
#include "support/scenarios.h"

namespace metabuffer::test {

enum class Strap : std::uint8_t { kRelay, kMaster };
enum class StallWire : std::uint8_t { kOwn, kDriven };

/// A frame as the bus has brought it to the composer.
struct FrameOnBus {
    std::optional<ViewportRow> row;
    bool table_lost = false;                 ///< a beat of its table did not arrive
    std::map<std::int64_t, int> sampled_at;  ///< by the pixel's index in the segment
    std::optional<int>
        loss_seen_at;  ///< the edge of the beat that shows the loss of a pixel; for a table, of its lost beat
};

/// A composer of display 1 between a bus, a pipeline above and a pipeline below, all played by the test. The test uses
/// its ports alone, except for the counters of `composer`. A protocol monitor watches everything that the test drives.
struct ComposerBench {
    Scenario scenario;
    ClockDomain& core;
    sc_core::sc_signal<bool> pipemaster;
    sc_core::sc_signal<rtl::BusBeat> bus;
    sc_core::sc_signal<bool> busready;
    sc_core::sc_signal<bool> tableready;
    sc_core::sc_signal<bool> startframe_in;
    sc_core::sc_signal<bool> startframe_out;
    sc_core::sc_signal<rtl::PipePixel> pipe_in;
    sc_core::sc_signal<rtl::PipePixel> pipe_out;
    sc_core::sc_signal<bool> pipeready_in;
    sc_core::sc_signal<bool> pipeready_out;
    sc_core::sc_signal<bool> column_stall;  ///< unused with StallWire::kOwn
    sc_core::sc_signal<bool> stall;
    rtl::Composer composer;
    monitors::ViolationLog violations;
    monitors::ComposerMonitor monitor;
    const Recording<bool>& busreadies;
    const Recording<bool>& tablereadies;
    const Recording<bool>& startframes;
    const Recording<rtl::PipePixel>& pipes;
    const Recording<bool>& pipereadies;
    const Recording<bool>& stalls;

    ComposerBench(ClockedTestbench& bench, const std::string& name, Scenario with,
                  Strap strap = Strap::kRelay, StallWire stall_wire = StallWire::kOwn)
        : scenario(std::move(with)),
          core(bench.core),
          pipemaster((name + "_pipemaster").c_str(), strap == Strap::kMaster),
          bus((name + "_bus").c_str()),
          startframe_in((name + "_startframe_in").c_str()),
          composer(name.c_str(), scenario, 1),
          monitor((name + "_monitor").c_str(), scenario, 0, 0, violations),
          busreadies(core.record(busready)),
          tablereadies(core.record(tableready)),
          startframes(core.record(startframe_out)),
          pipes(core.record(pipe_out)),
          pipereadies(core.record(pipeready_out)),
          stalls(core.record(stall)),
          stall_wire_(stall_wire) {
        composer.clk_i(core.clk);
        composer.reset_i(bench.reset);
        composer.pipemaster_i(pipemaster);
        composer.bus_i(bus);
        composer.busready_o(busready);
        composer.tableready_o(tableready);
        composer.startframe_i(startframe_in);
        composer.startframe_o(startframe_out);
        composer.pipe_i(pipe_in);
        composer.pipe_o(pipe_out);
        composer.pipeready_i(pipeready_in);
        composer.pipeready_o(pipeready_out);
        composer.column_stall_i(stall_wire == StallWire::kOwn ? stall : column_stall);
        composer.stall_o(stall);
        bind_monitor(bench);
        bench.trace(composer);
        core.each_clock([this, &bench](int clock) {
            if (bus_master) bus_master(clock);
            bus.write(beat_at(clock, bench.reset.read()));
            play_upstream(clock);
        });
    }

    int raster_pixels() const {
        return scenario.displays.raster_width_pixels() * scenario.displays.raster_height_pixels();
    }

    // ---- the bus: what edge `clock` samples ----

    /// Called before each edge, to put() what the edge samples.
    std::function<void(int)> bus_master;

    /// The pixel of a segment in a frame: what put_pixels() sends. A test may set another one before.
    std::function<Pixel(int, std::int64_t)> pixel_of = &ComposerBench::local;

    /// The beat gets its frame's number as it is driven: that of the last frame start.
    void put(int clock, const rtl::BusBeat& beat) { beats_[clock] = beat; }
    /// A beat that is put there does not arrive.
    void lose(int clock) { lost_.insert(clock); }
    void lose_from_to(int first_clock, int last_clock) {
        for (int clock = first_clock; clock <= last_clock; ++clock) lose(clock);
    }
    /// A beat that is put there claims to be of another frame.
    void misname(int clock, int frame) { misnamed_[clock] = frame; }
    /// Puts a frame-start beat at `clock` and the rows at the edges after it. Returns the last beat's edge.
    int put_table(int clock, const ViewportTable& rows) {
        put(clock, rtl::BusBeat::frame_start(0, rows.empty()));
        for (std::size_t i = 0; i < rows.size(); ++i) {
            put(++clock,
                rtl::BusBeat::table_row(0, static_cast<std::uint32_t>(i), rows[i], i + 1 == rows.size()));
        }
        return clock;
    }
    /// A beat of `count` pixels from pixel `first` of the segment of frame `frame` on.
    void put_pixels(int clock, std::int64_t first, int count, int remaining, int frame = 0,
                    int destination = 1) {
        rtl::BusBeat beat;
        beat.kind = rtl::BusBeat::Kind::kPixels;
        beat.destination = static_cast<std::uint16_t>(destination);
        beat.count = static_cast<std::uint8_t>(count);
        beat.remaining = static_cast<std::uint32_t>(remaining);
        beat.first = static_cast<std::uint32_t>(first);
        for (int i = 0; i < count; ++i) {
            beat.words[static_cast<std::size_t>(i)] = pixel_of(frame, first + i).word();
        }
        put(clock, beat);
    }
    /// `count` bursts of one pixel each, one a clock, from pixel `first` on.
    void put_single_pixels(int clock, std::int64_t first, int count, int frame = 0) {
        for (int i = 0; i < count; ++i) put_pixels(clock + i, first + i, 1, 0, frame);
    }

    // ---- the pipeline above ----

    /// STARTFRAME is sampled at edge `clock` (later if COLUMNSTALL is high), the raster after it.
    void start_frame(int clock) { starts_.push_back(clock); }

    // ---- pixel values that say where they come from ----

    /// Pixel k of the segment of a frame: nearer than every upstream pixel.
    static Pixel local(int frame, std::int64_t k) {
        const auto value = static_cast<std::uint32_t>(k * 7 + frame * 1000 + 1);
        return {static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
                static_cast<std::uint8_t>(value), 255, 5};
    }
    /// The upstream pixel at a raster position: half way to the far plane.
    static Pixel upstream(int position) {
        return {0xC0, static_cast<std::uint8_t>(position >> 8), static_cast<std::uint8_t>(position), 128,
                0x8000};
    }

    // ---- what comes out ----

    /// The raster that follows STARTFRAME at clock `start`, if nothing stalls.
    std::vector<Pixel> picture_behind(int start) const {
        std::vector<Pixel> picture;
        for (int i = 0; i < raster_pixels(); ++i) picture.push_back(pipes.at(start + 1 + i).pixel);
        return picture;
    }

    /// The frames that the bus has carried, in their order. What they mean for the pictures follows from the ports
    /// alone.
    std::vector<FrameOnBus> frames_on_bus() const {
        std::vector<FrameOnBus> frames;
        std::size_t over = 0;  // frames that are known not to be sent any more
        for (const auto& [clock, beat] : beats_) {
            if (beat.kind == rtl::BusBeat::Kind::kFrameStart) frames.emplace_back();
            if (frames.empty()) continue;
            FrameOnBus& frame = frames.back();
            if (lost_.count(clock) != 0) {
                if (beat.kind != rtl::BusBeat::Kind::kPixels && !frame.table_lost) {
                    frame.table_lost = true;
                    frame.loss_seen_at = clock;
                }
                continue;
            }
            for (; over + 1 < frames.size(); ++over)
                note_loss(frames[over], clock, segment_pixels(frames[over]));
            if (beat.destination != 1) continue;
            if (beat.kind == rtl::BusBeat::Kind::kTableRow) {
                frame.row = beat.row();
            } else if (beat.kind == rtl::BusBeat::Kind::kPixels) {
                note_loss(frame, clock, beat.first);
                for (int i = 0; i < beat.count; ++i) frame.sampled_at[beat.first + i] = clock;
            }
        }
        return frames;
    }

    /// The raster that must follow STARTFRAME at clock `start`, if nothing stalls. A segment pixel shows if an earlier
    /// edge has sampled it. From the edge after the one that shows a loss, no segment pixel shows and every raster
    /// pixel is marked lost.
    std::vector<rtl::PipePixel> due_behind(int start, int frame,
                                           const std::function<Pixel(int)>& from_above = upstream) const {
        const FrameOnBus on_bus = frames_on_bus().at(static_cast<std::size_t>(frame));
        const std::vector<std::optional<std::int64_t>> places = places_of(on_bus.row);
        std::vector<rtl::PipePixel> raster;
        for (int position = 0; position < raster_pixels(); ++position) {
            const int clock = start + 1 + position;
            rtl::PipePixel due{from_above(position), true,
                               on_bus.loss_seen_at && *on_bus.loss_seen_at < clock};
            if (const auto& k = places[static_cast<std::size_t>(position)]; k && !due.lost) {
                const auto sampled = on_bus.sampled_at.find(*k);
                if (sampled != on_bus.sampled_at.end() && sampled->second < clock)
                    due.pixel = local(frame, *k);
            }
            raster.push_back(due);
        }
        return raster;
    }

    /// The raster as it has left, each pixel with its marks.
    std::vector<rtl::PipePixel> raster_behind(int start) const {
        std::vector<rtl::PipePixel> raster;
        for (int i = 0; i < raster_pixels(); ++i) raster.push_back(pipes.at(start + 1 + i));
        return raster;
    }

    /// What leaves at the edges at which the column moves, StallWire::kOwn.
    std::vector<rtl::PipePixel> pixels_that_left() const {
        std::vector<rtl::PipePixel> left;
        for (int clock = 0; clock < pipes.end_clock(); ++clock) {
            if (pipes.at(clock).valid && !stalls.at(clock - 1)) left.push_back(pipes.at(clock));
        }
        return left;
    }

    /// Painted row by row, repetition by repetition: the segment over what comes from above.
    std::vector<Pixel> painted(const std::optional<ViewportRow>& row, int frame,
                               const std::function<Pixel(int)>& from_above = upstream) const {
        std::vector<Pixel> picture;
        for (const std::optional<std::int64_t>& k : places_of(row)) {
            picture.push_back(k ? local(frame, *k) : from_above(static_cast<int>(picture.size())));
        }
        return picture;
    }

  private:
    void bind_monitor(ClockedTestbench& bench) {
        monitor.clk_i(core.clk);
        monitor.reset_i(bench.reset);
        monitor.pipemaster_i(pipemaster);
        monitor.bus_i(bus);
        monitor.busready_o(busready);
        monitor.tableready_o(tableready);
        monitor.startframe_i(startframe_in);
        monitor.startframe_o(startframe_out);
        monitor.pipe_i(pipe_in);
        monitor.pipe_o(pipe_out);
        monitor.pipeready_i(pipeready_in);
        monitor.pipeready_o(pipeready_out);
        monitor.column_stall_i(stall_wire_ == StallWire::kOwn ? stall : column_stall);
        monitor.stall_o(stall);
        violations.on_violation([](const monitors::Violation& violation) {
            if (is_about_stimulus(violation)) return;
            SC_REPORT_ERROR("/metabuffer/testbench/monitor", monitors::to_string(violation).c_str());
        });
    }

    /// Rules that the played neighbours break where the test wants it so, and not the composer.
    static bool is_about_stimulus(const monitors::Violation& violation) {
        return violation.rule == "pipeready/unready" || violation.rule == "composer/table" ||
               violation.rule == "composer/occupancy";
    }

    static std::int64_t segment_pixels(const FrameOnBus& frame) {
        return frame.row ? std::int64_t{frame.row->sdx} * frame.row->sdy : 0;
    }
    /// All pixels before `come` have been sent: those that have not come are lost.
    static void note_loss(FrameOnBus& frame, int clock, std::int64_t come) {
        const std::int64_t next = frame.sampled_at.empty() ? 0 : frame.sampled_at.rbegin()->first + 1;
        if (come > next && !frame.loss_seen_at) frame.loss_seen_at = clock;
    }

    /// What edge `clock` samples on the bus.
    rtl::BusBeat beat_at(int clock, bool in_reset) {
        if (in_reset) frames_started_ = 0;
        const auto entry = beats_.find(clock);
        if (entry == beats_.end()) return {};
        frames_started_ += entry->second.kind == rtl::BusBeat::Kind::kFrameStart ? 1 : 0;
        if (lost_.count(clock) != 0) return {};
        rtl::BusBeat beat = entry->second;
        const auto misnamed = misnamed_.find(clock);
        beat.frame =
            static_cast<std::uint32_t>(misnamed == misnamed_.end() ? frames_started_ - 1 : misnamed->second);
        return beat;
    }

    /// For each raster position the segment pixel that shows there.
    std::vector<std::optional<std::int64_t>> places_of(const std::optional<ViewportRow>& row) const {
        std::vector<std::optional<std::int64_t>> places(static_cast<std::size_t>(raster_pixels()));
        if (!row) return places;
        const int width = scenario.displays.raster_width_pixels();
        const int height = scenario.displays.raster_height_pixels();
        std::int64_t k = 0;
        for (int j = 0; j < row->sdy; ++j) {
            for (int i = 0; i < row->sdx; ++i, ++k) {
                for (int repetition = 0; repetition < row->dmultiple * row->dmultiple; ++repetition) {
                    const int x = row->dx + i * row->dmultiple + repetition % row->dmultiple;
                    const int y = row->dy + j * row->dmultiple + repetition / row->dmultiple;
                    if (x < 0 || x >= width || y < 0 || y >= height) continue;
                    places[static_cast<std::size_t>(y * width + x)] = k;
                }
            }
        }
        return places;
    }

    /// A composer above: its registers move on at every edge at which the column does not stand still.
    void play_upstream(int clock) {
        // Whether edge clock - 1 has seen COLUMNSTALL. A registered one has changed since; one that the test drives
        // changes only now.
        const bool standing = stall_wire_ == StallWire::kOwn ? stall.read() : column_stall.read();
        const bool held = stall_wire_ == StallWire::kDriven ? standing : std::exchange(stood_, standing);
        if (held) return;
        if (position_ >= 0) {
            startframe_in.write(false);
            pipe_in.write(position_ < raster_pixels() ? rtl::PipePixel{upstream(position_), true}
                                                      : rtl::PipePixel{});
            position_ = position_ < raster_pixels() ? position_ + 1 : -1;
        }
        for (const int start : starts_) {
            if (start != clock) continue;
            startframe_in.write(true);
            position_ = 0;
        }
    }

    std::map<int, rtl::BusBeat> beats_;
    std::set<int> lost_;
    std::map<int, int> misnamed_;
    int frames_started_ = 0;
    std::vector<int> starts_;
    int position_ = -1;
    StallWire stall_wire_;
    bool stood_ = false;
};

}  // namespace metabuffer::test
