#include "rtl/dvi_display.h"

#include <utility>

namespace metabuffer::rtl {

DviDisplay::DviDisplay(const sc_core::sc_module_name& name, ClockGating gating) : Block(name), gate_(gating) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void DviDisplay::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= link_i.value_changed_event();
}

void DviDisplay::clock_edge() {
    if (gate_.opened()) {
        return;
    }
    // While the link stands still, each clock shows what the one before did.
    const std::int64_t slept_edges = edges_.count() - 1;
    if (reset_i.read()) {
        registers_.reset();
        return;
    }
    const DviLink& link = link_i.read();
    if (previous_->de) {
        take_pixels(previous_->data, slept_edges);
    }
    if (link.de) {
        take_pixels(link.data, 1);
    } else if (previous_->de && in_frame_) {
        end_line();
    }
    if (link.vsync && !previous_->vsync) {
        end_frame();
    }
    const bool stands_still = link == previous_.value();
    if (!stands_still) {
        previous_ = link;
    }
    if (gate_.idle_edge(stands_still)) {
        edges_.sleep();
        next_trigger(wake_events_);
    }
}

void DviDisplay::take_pixels(std::uint32_t colour, std::int64_t count) {
    if (in_frame_) {
        capture_.values.insert(capture_.values.end(), static_cast<std::size_t>(count), colour);
        x_ += static_cast<int>(count);
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
