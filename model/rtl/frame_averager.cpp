#include "rtl/frame_averager.h"

#include "datapath/colour_correction.h"
#include "report/waits.h"

namespace metabuffer::rtl {

FrameAverager::FrameAverager(const sc_core::sc_module_name& name, const Scenario& scenario, int display)
    : Block(name),
      may_stall_(scenario.composer.may_stall()),
      raster_pixels_(std::int64_t{scenario.displays.raster_width_pixels()} *
                     scenario.displays.raster_height_pixels()),
      colour_table_(scenario.displays.colour_table_of(display)),
      averager_(registers_, "averager", 1,
                Averager(scenario.displays.width_pixels, scenario.displays.supersample)),
      raster_position_(registers_, "raster_position", bits_for(raster_pixels_)),
      next_word_(registers_, "next_word", bits_for(scenario.displays.pixels())),
      write_(registers_, "write", bits_for(scenario.displays.pixels() - 1)),
      frames_taken_(registers_, "frames_taken", bits_for(scenario.frames)) {}

void FrameAverager::reset() {
    registers_.reset();
    pipeready_o.write(pipeready_);
    framedone_o.write(framedone_);
    framebad_o.write(framebad_);
    writes_o.write(writes_);
    write_o.write(write_);
}

void FrameAverager::clock_edge() {
    const bool swapped = swapped_.sample(swapped_i.read());
    if (swapped && !swapped_seen_) {
        frame_done_ = false;
        // It is stable: it was set at the swap, which has crossed two registers since then.
        if (!skipped_i.read()) {
            back_ = !back_;
        }
        mark_frame(false);
    }
    swapped_seen_ = swapped;
    const bool stalled = may_stall_ && column_stall_i.read();
    bool writes = false;
    if (stalled) {
        ++stalled_cycles_;
        clocked_.stay_awake();
    } else if (receiving_) {
        writes = take_pixel(pipe_i.read());
    } else if (startframe_i.read()) {
        receiving_ = true;
        raster_position_ = 0;
        next_word_ = 0;
    }
    drive_output(writes_, writes_o, writes);
    drive_output(framedone_, framedone_o, frame_done_ && !swapped);
    drive_output(pipeready_, pipeready_o, !receiving_ && !frame_done_);
}

void FrameAverager::mark_frame(bool bad) { drive_output(framebad_, framebad_o, bad); }

/// True if the raster pixel completes a display pixel, which is then to be written.
bool FrameAverager::take_pixel(const PipePixel& pixel) {
    if (!pixel.valid) {
        SC_REPORT_ERROR(
            "/metabuffer/output_framebuffer/bubble",
            (whole() + " found no pixel at raster position " + std::to_string(raster_position_)).c_str());
        return false;
    }
    ++pixels_taken_;
    if (pixel.lost) {
        mark_frame(true);
    }
    std::uint32_t colour = 0;
    const bool completes = averager_.change().push(pixel.pixel, colour);
    if (completes) {
        write_ = {back_, next_word_, colour_table_ == nullptr ? colour : corrected(*colour_table_, colour)};
        write_o.write(write_);
        ++next_word_;
    }
    ++raster_position_;
    if (raster_position_ == raster_pixels_) {
        receiving_ = false;
        frame_done_ = true;
        ++frames_taken_;
    }
    return completes;
}

void FrameAverager::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

std::string FrameAverager::waiting_for() const {
    if (receiving_) {
        return waits::for_raster_pixel(raster_position_, frames_taken_);
    }
    return frame_done_ ? waits::for_swaplock(frames_taken_ - 1) : waits::for_startframe(frames_taken_);
}

}  // namespace metabuffer::rtl
