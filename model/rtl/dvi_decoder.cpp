#include "rtl/dvi_decoder.h"

#include <utility>

#include "report/waits.h"

namespace metabuffer::rtl {

DviDecoder::DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing)
    : Block(name), timing_(timing) {
    control_.reserve(static_cast<std::size_t>(timing.active_pixels));
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void DviDecoder::reset() {
    pairs_.reset();
    previous_de_ = false;
    previous_vsync_ = false;
    table_.clear();
    next_row_ = 0;
    pixel_ = DecodedPixel{};
    event_ = DecoderEvent{};
    event_pending_ = false;
    pixel_o.write(pixel_);
    event_o.write(event_);
}

void DviDecoder::clock_edge() {
    if (reset_i.read()) {
        reset();
        return;
    }
    const DviLink& link = link_i.read();
    if (event_pending_) {
        event_ = DecoderEvent{};
    }
    bool event_now = false;
    if (next_row_ < table_.size()) {
        event_.row = true;
        event_.table_row = table_[next_row_++];
        event_now = true;
    }
    const bool pixel_was_valid = pixel_.valid;
    pixel_.valid = false;
    if (link.de) {
        take_pixel(link.data);
    } else if (previous_de_) {
        end_line();
    }
    if (link.vsync && !previous_vsync_) {
        end_frame();
    }
    previous_de_ = link.de;
    previous_vsync_ = link.vsync;
    event_now = event_now || event_.tells_something();
    if (pixel_.valid || pixel_was_valid) {
        pixel_o.write(pixel_);
    }
    if (event_now || event_pending_) {
        event_o.write(event_);
    }
    event_pending_ = event_now;
}

void DviDecoder::take_pixel(std::uint32_t data) {
    if (!pairs_.in_frame()) {
        return;
    }
    if (x_ >= timing_.active_pixels || line_ >= timing_.active_lines) {
        pairs_.reject_geometry(event_);
        return;
    }
    if (line_ == 0) {
        control_.push_back(data);
    } else {
        pixel_.valid = true;
        pixel_.kind = pairs_.kind();
        pixel_.address = static_cast<std::uint32_t>((line_ - 1) * timing_.active_pixels + x_);
        pixel_.data = data;
    }
    ++x_;
}

void DviDecoder::end_line() {
    if (!pairs_.in_frame()) {
        return;
    }
    if (x_ != timing_.active_pixels) {
        pairs_.reject_geometry(event_);
        return;
    }
    if (line_ == 0) {
        end_control_scanline();
    }
    x_ = 0;
    ++line_;
}

void DviDecoder::end_control_scanline() {
    DecodedScanline scanline = decode_control_scanline(control_);
    pairs_.end_control_scanline(scanline, event_);
    if (event_.colour_start) {
        table_ = std::move(scanline.content.table);
        next_row_ = 0;
    }
}

void DviDecoder::end_frame() {
    if (line_ > 0) {
        pairs_.end_frame(line_ == timing_.active_lines, event_);
    }
    pairs_.begin_frame();
    control_.clear();
    x_ = 0;
    line_ = 0;
}

void DviDecoder::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, pixel_o.read(), path("pixel"));
    sc_trace(file, event_o.read(), path("event"));
    sc_core::sc_trace(file, line_, path("line"));
}

std::string DviDecoder::waiting_for() const { return waits::for_link_frame(pairs_); }

}  // namespace metabuffer::rtl
