#include "rtl/raster_walker.h"

namespace metabuffer::rtl {

RasterWalker::RasterWalker(const sc_core::sc_module_name& name, const Scenario& scenario)
    : Block(name),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_height_(scenario.displays.raster_height_pixels()),
      may_stall_(scenario.composer.may_stall()),
      smooths_(scenario.composer.smoothing == Smoothing::kBilinear),
      pixel_bits_(segment_pixel_bits(scenario)),
      frame_(registers_, "frame", 1 + bits_for(scenario.frames), -1),
      walker_(registers_, "", 1, SegmentWalker(Segment{}, false, raster_width_, raster_height_)),
      ahead_(registers_, "ahead", 1, walker_.value()),
      use_(registers_, "use", pixel_bits_) {
    SC_METHOD(drive_ahead);
    sensitive << segment_i;
    dont_initialize();
}

void RasterWalker::reset() {
    registers_.reset();
    running_o.write(false);
    uses_o.write(uses_);
    drive_ahead();
}

void RasterWalker::clock_edge() {
    if (!may_stall_ || !column_stall_i.read()) {
        move();
    }
}

void RasterWalker::move() {
    if (running_) {
        walker_ = ahead_;
        if (walker_->done()) {
            running_ = false;
            running_o.write(false);
        } else {
            ahead_.change().advance();
        }
    } else if (start_i.read()) {
        start_frame();
    } else {
        return;
    }
    drive_ahead();
    drive_use();
}

void RasterWalker::start_frame() {
    running_ = true;
    running_o.write(true);
    walker_ = at_start();
    ahead_ = walker_;
    ahead_.change().advance();
    ++frame_;
}

SegmentWalker RasterWalker::at_start() const {
    const HeadSegment& head = segment_i.read();
    return {head.segment, head.shown, raster_width_, raster_height_};
}

void RasterWalker::drive_ahead() { ahead_o.write(running_ ? ahead_->step() : at_start().step()); }

void RasterWalker::drive_use() {
    PixelUse use;
    if (running_) {
        use.ends_frame = ahead_->done();
        use.last_use = walker_->covered() ? walker_->released() : Segment::kNoPixel;
    }
    if (use.any()) {
        use_ = use;
        use_o.write(use);
    }
    drive_output(uses_, uses_o, use.any());
}

void RasterWalker::trace(sc_core::sc_trace_file* file) const {
    registers_.trace(file, path(""));
    if (smooths_) {
        walker_->visit_smoothing_state(StateTracer{file, path("")});
        ahead_->visit_smoothing_state(StateTracer{file, path("ahead_")});
    }
    sc_trace(file, ahead_o.read(), path("ahead"), pixel_bits_);
}

}  // namespace metabuffer::rtl
