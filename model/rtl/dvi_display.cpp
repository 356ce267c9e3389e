#include "rtl/dvi_display.h"

#include <utility>

namespace metabuffer::rtl {

DviDisplay::DviDisplay(const sc_core::sc_module_name& name) : Block(name) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void DviDisplay::clock_edge() {
    if (reset_i.read()) {
        registers_.reset();
        return;
    }
    const DviLink& link = link_i.read();
    if (link.de) {
        if (in_frame_) {
            capture_.values.push_back(link.data);
            ++x_;
        }
    } else if (previous_de_ && in_frame_) {
        end_line();
    }
    if (link.vsync && !previous_vsync_) {
        end_frame();
    }
    previous_de_ = link.de;
    previous_vsync_ = link.vsync;
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
        if (ragged_) {
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
