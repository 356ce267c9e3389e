#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "pixel_beat.h"
#include "rtl/composer.h"
#include "support/scenarios.h"

namespace metabuffer::test {

enum class Strap : std::uint8_t { kRelay, kMaster };
enum class StallWire : std::uint8_t { kOwn, kDriven };

/// A composer of display 1 between a bus, a pipeline above and a pipeline below, all played by the test.
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

    ComposerBench(ClockedTestbench& bench, const std::string& name, Scenario with,
                  Strap strap = Strap::kRelay, StallWire stall_wire = StallWire::kOwn)
        : scenario(std::move(with)),
          core(bench.core),
          pipemaster((name + "_pipemaster").c_str(), strap == Strap::kMaster),
          bus((name + "_bus").c_str()),
          startframe_in((name + "_startframe_in").c_str()),
          composer(name.c_str(), scenario, 1),
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
        bench.trace(composer);
        core.each_clock([this, &bench](int clock) {
            bus.write(beat_at(clock));
            play_upstream(clock);
        });
    }

    int raster_pixels() const {
        return scenario.displays.raster_width_pixels() * scenario.displays.raster_height_pixels();
    }

    // ---- the bus: what edge `clock` samples ----

    /// The beat gets its frame's number as it is driven: that of the last frame start.
    void put(int clock, const rtl::BusBeat& beat) { beats_[clock] = beat; }
    /// Puts a frame-start beat at `clock` and the rows at the edges after it. Returns the last beat's edge.
    int put_table(int clock, const ViewportTable& rows) {
        put(clock, rtl::BusBeat::frame_start(0, rows.empty()));
        for (std::size_t i = 0; i < rows.size(); ++i) {
            put(++clock,
                rtl::BusBeat::table_row(0, static_cast<std::uint32_t>(i), rows[i], i + 1 == rows.size()));
        }
        return clock;
    }
    /// A beat of `count` pixels of the segment from pixel `first` on.
    void put_pixels(int clock, std::int64_t first, int count, int remaining) {
        put(clock, pixel_beat(0, 1, first, count, remaining, [](std::int64_t k) { return local(k).word(); }));
    }
    /// `count` bursts of one pixel each, one a clock, from pixel `first` on.
    void put_single_pixels(int clock, std::int64_t first, int count) {
        for (int i = 0; i < count; ++i) put_pixels(clock + i, first + i, 1, 0);
    }

    // ---- the pipeline above ----

    /// STARTFRAME is sampled at edge `clock` (later if COLUMNSTALL is high), the raster after it.
    void start_frame(int clock) { starts_.push_back(clock); }

    // ---- pixel values that say where they come from ----

    /// Pixel k of a segment: nearer than every upstream pixel.
    static Pixel local(std::int64_t k) {
        const auto value = static_cast<std::uint32_t>(k * 7 + 1);
        return {static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
                static_cast<std::uint8_t>(value), 255, 5};
    }
    /// The upstream pixel at a raster position: half way to the far plane.
    static Pixel upstream(int position) {
        return {0xC0, static_cast<std::uint8_t>(position >> 8), static_cast<std::uint8_t>(position), 128,
                0x8000};
    }

  private:
    /// What edge `clock` samples on the bus.
    rtl::BusBeat beat_at(int clock) {
        const auto entry = beats_.find(clock);
        if (entry == beats_.end()) return {};
        rtl::BusBeat beat = entry->second;
        frames_started_ += beat.kind == rtl::BusBeat::Kind::kFrameStart ? 1 : 0;
        beat.frame = static_cast<std::uint32_t>(frames_started_ - 1);
        return beat;
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
    int frames_started_ = 0;
    std::vector<int> starts_;
    int position_ = -1;
    StallWire stall_wire_;
    bool stood_ = false;
};

}  // namespace metabuffer::test
