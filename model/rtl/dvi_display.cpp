#include "rtl/dvi_display.h"

#include <utility>

namespace metabuffer::rtl {

DviDisplay::DviDisplay(const sc_core::sc_module_name& name) : Block(name) {}

void DviDisplay::clock_edge() {
    const DviLink& link = link_i.read();
    if (link == previous_.value()) {
        clocked_.may_sleep();
    }
    if (previous_->de) {
        // While the link stands still, each clock shows what the one before did.
        take_pixels(previous_->data, clocked_.slept_edges());
    }
    if (link.de) {
        take_pixels(link.data, 1);
    } else if (previous_->de && in_frame_) {
        end_line();
    }
    if (link.vsync && !previous_->vsync) {
        end_frame();
    }
    previous_ = link;
}

void DviDisplay::take_pixels(std::uint32_t colour, std::int64_t count) {
    if (in_frame_) {
        x_ += static_cast<int>(count);
        for (; count > 0; --count) capture_.values.push_back(colour);
    }
}

void DviDisplay::end_line() {
    if (capture_.height_pixels == 0) {
        capture_.width_pixels = x_;
    }
    ragged_ = ragged_ || x_ != capture_.width_pixels;
    ++capture_.height_pixels;
    x_ = 0;
}

void DviDisplay::end_frame() {
    if (in_frame_ && capture_.height_pixels > 0) {
        if (ragged_ || x_ > 0) {  // its last line is broken off
            SC_REPORT_WARNING("/metabuffer/dvi_display/geometry",
                              (std::string(name()) + " was shown a frame of unequal lines").c_str());
        } else {
            ++frames_captured_;
            if (on_frame_) {
                on_frame_(capture_);
            }
        }
    }
    in_frame_ = true;
    ragged_ = false;
    x_ = 0;
    capture_.height_pixels = 0;
    capture_.values.clear();
}

void DviDisplay::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, link_i.read(), path("DVI"));
    registers_.trace(file, path(""));
    sc_core::sc_trace(file, frames_captured_, path("frames_captured"));
}

}  // namespace metabuffer::rtl
