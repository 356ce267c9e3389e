#include "rtl/raster_recorder.h"

#include "rtl/block.h"

namespace metabuffer::rtl {

RasterRecorder::RasterRecorder(const sc_core::sc_module_name& name, const Scenario& scenario,
                               ComposerRecord& record)
    : sc_core::sc_module(name),
      may_stall_(scenario.composer.may_stall()),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_pixels_(std::int64_t{raster_width_} * scenario.displays.raster_height_pixels()),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      record_(record) {
    clocked_.reads({reset_i, start_i, running_i});  // the others matter while a frame runs
    if (may_stall_) {
        SC_METHOD(follow_missing);
        sensitive << missing_i;
        dont_initialize();
    }
}

void RasterRecorder::clock_edge() {
    const bool runs = running_i.read();
    if (!runs && !start_i.read()) return;
    clocked_.stay_awake();
    if (may_stall_ && column_stall_i.read()) {
        record_.mutable_counters().stalled_cycles += missing_i.read() ? 1 : 0;
    } else if (runs) {
        count_pixel();
    } else {
        record_.frame_started(cycle());
        replays_ = false;
    }
}

void RasterRecorder::count_pixel() {
    if (composited_ == 0) record_.first_pixel_composited(cycle());
    if (missing_i.read()) {
        record_.count_starved_pixel({record_.frame(), x(), y()}, cycle());
    } else if (replays_ && !progress_i.read().abandoned) {
        ++record_.mutable_counters().replayed_pixels;
    }
    replays_ = ahead_i.read().replayed;
    if (++composited_ == raster_pixels_) {
        record_.last_pixel_composited(cycle());
        composited_ = 0;
    }
}

void RasterRecorder::follow_missing() {
    if (missing_i.read()) record_.note_starved(cycle());
}

std::int64_t RasterRecorder::cycle() const { return clock_edge_number(core_period_picoseconds_); }

}  // namespace metabuffer::rtl
