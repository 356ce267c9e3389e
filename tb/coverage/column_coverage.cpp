#include "column_coverage.h"

#include <algorithm>

#include "bus_coverage.h"
#include "composer_coverage.h"

namespace metabuffer::coverage {

ColumnCoverage::ColumnCoverage(const ColumnGoals& goals, const Scenario& scenario, int display)
    : goals_(goals),
      scenario_(scenario),
      display_(display),
      readiness_(scenario.renderers.size()),
      below_now_(scenario.renderers.size()),
      starved_frame_(static_cast<std::size_t>(scenario.displays.raster_width_pixels()) *
                         static_cast<std::size_t>(scenario.displays.raster_height_pixels()),
                     -1),
      block_sums_(static_cast<std::size_t>(scenario.displays.width_pixels)) {}

void ColumnCoverage::clock_edge(const ColumnWires& wires,
                                const std::vector<const ComposerCoverage*>& composers,
                                const std::vector<const BusCoverage*>& buses) {
    ++edge_;
    cover_pipeready(wires, composers);
    cover_start(wires, composers);
    cover_stall(wires, composers, buses);
    if (scenario_.composer.on_starvation == StarvationMode::kGlitch) cover_starved(composers);
    if (wires.pipe_out.valid && !wires.column_stall) cover_average(wires.pipe_out);
}

void ColumnCoverage::cover_pipeready(const ColumnWires& wires,
                                     const std::vector<const ComposerCoverage*>& composers) {
    const PipereadyGoals& goals = goals_.pipeready;
    for (std::size_t r = 0; r < composers.size(); ++r) {
        const ComposerCoverage& composer = *composers[r];
        Readiness& before = readiness_[r];
        const Readiness now{below_now_[r], composer.prefetched(), composer.table_complete(),
                            wires.pipeready[r]};
        if (now.raised && !before.raised && composer.in_step()) {
            goals.waited_for_below.hit_if(!before.below && before.prefetched);
            goals.waited_for_prefetch.hit_if(before.below && !before.prefetched);
            goals.both_at_once.hit_if(!before.below && !before.prefetched);
            goals.table_last.hit_if(before.below && !before.table);
            (composer.segment_empty()      ? goals.segment_empty
             : composer.segment_complete() ? goals.segment_in_buffer
                                           : goals.buffer_filled)
                .hit();
            goals.single_composer.hit_if(composers.size() == 1);
        }
        before = now;
        below_now_[r] = wires.pipeready[r + 1];
    }
    const bool bottom = wires.pipeready.back();
    if (bottom && !bottom_ready_) {
        bottom_ready_edge_ = edge_;
        goals_.sequence.prefetched_first.hit_if(std::all_of(
            composers.begin(), composers.end(),
            [](const ComposerCoverage* composer) { return composer->in_step() && composer->prefetched(); }));
    }
    bottom_ready_ = bottom;
}

void ColumnCoverage::cover_start(const ColumnWires& wires,
                                 const std::vector<const ComposerCoverage*>& composers) {
    const bool started = wires.startframe[1];  // out of the top composer
    if (started && !started_) {
        starts_.push_back(edge_);
        const auto relays = static_cast<std::int64_t>(composers.size()) + 1;
        const bool back_to_back = starts_.size() > 1 && edge_ == bottom_ready_edge_ + relays;
        goals_.sequence.two_frames.hit_if(back_to_back);
        goals_.sequence.three_frames.hit_if(back_to_back && back_to_back_);
        back_to_back_ = back_to_back;
    }
    started_ = started;
    const bool running = composers.back()->running();
    if (running_ && !running) ends_.push_back(edge_);
    running_ = running;
}

void ColumnCoverage::cover_stall(const ColumnWires& wires,
                                 const std::vector<const ComposerCoverage*>& composers,
                                 const std::vector<const BusCoverage*>& buses) {
    // Stalled for a composer that lacks a pixel, and not only by a fault.
    stalled_ =
        wires.column_stall && std::find(wires.stall.begin(), wires.stall.end(), true) != wires.stall.end();
    if (!stalled_) {
        end_stall();
        return;
    }
    const ColumnStallGoals& goals = goals_.stall;
    goals.again_after_one_clock.hit_if(stalled_clocks_ == 0 && moving_clocks_ == 1);
    ++stalled_clocks_;
    moving_clocks_ = 0;
    goals.two_composers.hit_if(std::count(wires.stall.begin(), wires.stall.end(), true) > 1);
    goals.startframe_stands.hit_if(std::find(wires.startframe.begin(), wires.startframe.end(), true) !=
                                   wires.startframe.end());
    for (std::size_t r = 0; r < composers.size(); ++r) {
        if (!wires.stall[r]) continue;
        const BusCoverage& bus = *buses[r];
        goals.bus_silent.hit_if(!bus.beat_now() && !bus.burst_waits());
        goals.bus_opens_page.hit_if(bus.burst_waits() && cycles_per_beat(scenario_.bus) == 1);
        goals.bus_serves_another.hit_if(bus.destination_now() != 0 && bus.destination_now() != display_);
    }
}

void ColumnCoverage::end_stall() {
    if (stalled_clocks_ > 0) goals_.stall.clocks(stalled_clocks_).hit();
    stalled_clocks_ = 0;
    ++moving_clocks_;
}

void ColumnCoverage::cover_starved(const std::vector<const ComposerCoverage*>& composers) {
    for (const ComposerCoverage* composer : composers) {
        if (!composer->starved()) continue;
        int& frame = starved_frame_[static_cast<std::size_t>(composer->position())];
        goals_.starved.two_composers.hit_if(frame == composer->frame());
        frame = composer->frame();
    }
}

/// How the average of a display pixel is rounded, by its red.
void ColumnCoverage::cover_average(const rtl::PipePixel& pixel) {
    const int s = scenario_.displays.supersample;
    if (s == 1) return;
    const int width = scenario_.displays.raster_width_pixels();
    const auto x = static_cast<int>(raster_position_ % width);
    const auto y = static_cast<int>(raster_position_ / width);
    raster_position_ =
        (raster_position_ + 1) % (std::int64_t{width} * scenario_.displays.raster_height_pixels());
    int& sum = block_sums_[static_cast<std::size_t>(x / s)];
    if (x % s == 0 && y % s == 0) sum = 0;
    sum += pixel.pixel.r();
    if (x % s != s - 1 || y % s != s - 1) return;
    const int remainder = sum % (s * s);
    const int half = s * s / 2;
    const Rounding rounding = remainder == 0      ? Rounding::kExact
                              : remainder < half  ? Rounding::kDown
                              : remainder == half ? Rounding::kHalfUp
                                                  : Rounding::kUp;
    goals_.average.rounding(s, rounding).hit();
}

}  // namespace metabuffer::coverage
