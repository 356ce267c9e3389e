#include "rtl/dvi_decoder.h"

#include <utility>

#include "report/waits.h"

namespace metabuffer::rtl {
namespace {

constexpr int kPayloadOffsetBits = bits_for(kControlHeaderBytes + 0xFFFF * kControlRowBytes);
constexpr unsigned kByteBits = 8;

}  // namespace

DviDecoder::DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing)
    : Block(name),
      timing_(timing),
      x_(registers_, "x", bits_for(timing.active_pixels)),
      line_(registers_, "line", bits_for(timing.active_lines)),
      payload_at_(registers_, "payload_at", kPayloadOffsetBits),
      pixel_(registers_, "pixel", bits_for(std::int64_t{timing.active_pixels} * timing.active_lines - 1)) {
    control_.reserve(static_cast<std::size_t>(timing.active_pixels));
}

void DviDecoder::reset() {
    registers_.reset();
    control_.clear();
    table_.clear();
    pixel_o.write(pixel_);
    event_o.write(event_);
}

void DviDecoder::clock_edge() {
    const DviLink& link = link_i.read();
    DecoderEvent event;
    if (next_row_ < table_.size()) {
        event.row = true;
        event.table_row = table_[next_row_];
        ++next_row_;
    }
    DecodedPixel pixel = pixel_;
    pixel.valid = false;
    if (link.de) {
        take_pixel(link.data, pixel, event);
    } else if (previous_de_) {
        end_line(event);
    }
    if (link.vsync && !previous_vsync_) {
        end_frame(event);
    }
    previous_de_ = link.de;
    previous_vsync_ = link.vsync;
    if (pixel.valid || pixel_.value().valid) {
        pixel_ = pixel;
        pixel_o.write(pixel_);
    }
    const bool event_now = event.row || event.payload_bytes > 0 || event.reports_anything();
    if (event_now || event_pending_) {
        event_ = event;
        event_o.write(event_);
    }
    event_pending_ = event_now;
}

void DviDecoder::take_pixel(std::uint32_t data, DecodedPixel& pixel, DecoderEvent& event) {
    if (!pairs_->in_frame()) {
        return;
    }
    if (x_ >= timing_.active_pixels || line_ >= timing_.active_lines) {
        pairs_.change().reject_geometry(event);
        return;
    }
    if (line_ == 0) {
        control_.push_back(data);
        if (pairs_->expect() == PairFollower::Expect::kDepth) {
            pass_payload(data, event);
        }
    } else {
        pixel.valid = true;
        pixel.kind = pairs_->kind();
        pixel.address = static_cast<std::uint32_t>((line_ - 1) * timing_.active_pixels + x_);
        pixel.data = data;
    }
    ++x_;
}

/// Reports the payload's bytes of a depth frame. They do not count if the frame turns out to be bad.
void DviDecoder::pass_payload(std::uint32_t data, DecoderEvent& event) {
    for (int i = 0; i < kLinkBytesPerPixel; ++i) {
        const int offset = kLinkBytesPerPixel * x_ + i;
        const std::uint32_t byte =
            (data >> (kByteBits * static_cast<unsigned>(kLinkBytesPerPixel - 1 - i))) & 0xFFU;
        if (offset == kControlRowCountOffset) {
            payload_at_ = static_cast<int>(byte);
        } else if (offset == kControlRowCountOffset + 1) {
            payload_at_ =
                kControlHeaderBytes + kControlRowBytes * (payload_at_ + static_cast<int>(byte << kByteBits));
            payload_left_ = 0;
        } else if (offset < kControlHeaderBytes) {
            continue;
        } else if (offset == payload_at_) {
            payload_left_ = byte;
        } else if (offset == payload_at_ + 1) {
            payload_left_ = payload_left_ | (byte << kByteBits);
        } else if (offset > payload_at_ && payload_left_ > 0) {
            --payload_left_;
            event.payload[event.payload_bytes++] = static_cast<std::uint8_t>(byte);
        }
    }
}

void DviDecoder::end_line(DecoderEvent& event) {
    if (!pairs_->in_frame()) {
        return;
    }
    if (x_ != timing_.active_pixels) {
        pairs_.change().reject_geometry(event);
        return;
    }
    if (line_ == 0) {
        end_control_scanline(event);
    }
    x_ = 0;
    ++line_;
}

void DviDecoder::end_control_scanline(DecoderEvent& event) {
    DecodedScanline scanline = decode_control_scanline(control_);
    pairs_.change().end_control_scanline(scanline, event);
    if (event.colour_start) {
        table_ = std::move(scanline.content.table);
        next_row_ = 0;
    }
}

void DviDecoder::end_frame(DecoderEvent& event) {
    if (line_ > 0) {
        pairs_.change().end_frame(line_ == timing_.active_lines, event);
    }
    pairs_.change().begin_frame();
    control_.clear();
    x_ = 0;
    line_ = 0;
}

void DviDecoder::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

std::string DviDecoder::waiting_for() const { return waits::for_link_frame(pairs_); }

}  // namespace metabuffer::rtl
