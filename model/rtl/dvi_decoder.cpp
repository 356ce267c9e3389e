#include "rtl/dvi_decoder.h"

#include <algorithm>
#include <utility>

#include "formats/control_scanline.h"

namespace metabuffer::rtl {
namespace {

RejectCause cause_of(ScanlineDefect defect) {
    switch (defect) {
        case ScanlineDefect::kMagic:
            return RejectCause::kMagic;
        case ScanlineDefect::kVersion:
            return RejectCause::kVersion;
        case ScanlineDefect::kKind:
            return RejectCause::kKind;
        default:
            return RejectCause::kCrc;
    }
}

/// The earlier of two frame numbers, which count modulo 2^32.
std::uint32_t earlier(std::uint32_t a, std::uint32_t b) {
    return static_cast<std::int32_t>(a - b) < 0 ? a : b;
}

}  // namespace

DviDecoder::DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing)
    : Block(name), timing_(timing) {
    control_.reserve(static_cast<std::size_t>(timing.active_pixels));
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void DviDecoder::reset() {
    in_frame_ = false;
    previous_de_ = false;
    previous_vsync_ = false;
    expect_ = Expect::kAnyColour;
    control_good_ = false;
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
    event_now = event_now || event_.rejected || event_.pair_lost || event_.colour_start || event_.pair_good;
    if (pixel_.valid || pixel_was_valid) {
        pixel_o.write(pixel_);
    }
    if (event_now || event_pending_) {
        event_o.write(event_);
    }
    event_pending_ = event_now;
}

void DviDecoder::take_pixel(std::uint32_t data) {
    if (!in_frame_) {
        return;
    }
    if (x_ >= timing_.active_pixels || line_ >= timing_.active_lines) {
        reject(RejectCause::kGeometry);
        return;
    }
    if (line_ == 0) {
        control_.push_back(data);
    } else {
        pixel_.valid = true;
        pixel_.kind = kind_;
        pixel_.address = static_cast<std::uint32_t>((line_ - 1) * timing_.active_pixels + x_);
        pixel_.data = data;
    }
    ++x_;
}

void DviDecoder::end_line() {
    if (!in_frame_) {
        return;
    }
    if (x_ != timing_.active_pixels) {
        reject(RejectCause::kGeometry);
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
    if (scanline.defect != ScanlineDefect::kNone) {
        reject(cause_of(scanline.defect));
        return;
    }
    kind_ = scanline.content.kind;
    const std::uint32_t number = scanline.content.frame_number;
    if (kind_ == FrameKind::kColour) {
        if (expect_ == Expect::kDepth) {
            // The pair before this one never got its depth frame. Sent again, a colour frame begins its pair anew,
            // and no pair is lost.
            if (number == number_) {
                expect_ = Expect::kAnyColour;
            }
            reject(RejectCause::kPair);
            in_frame_ = true;
        }
        number_ = number;
        control_good_ = true;
        event_.colour_start = true;
        event_.number = number;
        table_ = std::move(scanline.content.table);
        next_row_ = 0;
        return;
    }
    if (expect_ == Expect::kDepth && number == number_) {
        control_good_ = true;
        return;
    }
    if (expect_ == Expect::kColour && number == number_) {
        reject(RejectCause::kPair);  // sent again behind its pair, which is whole and stays so
        return;
    }
    // Where the two frames of a pair differ, the lower number is the pair that is lost now.
    const std::uint32_t lost = expect_ == Expect::kDepth ? earlier(number, number_) : number;
    if (expect_ == Expect::kAnyColour) {
        in_frame_ = false;  // its colour frame has been rejected or was never seen
    } else {
        reject(RejectCause::kPair);
    }
    lose_pair(lost);
}

void DviDecoder::end_frame() {
    if (in_frame_ && line_ > 0) {
        if (line_ != timing_.active_lines) {
            reject(RejectCause::kGeometry);
        } else if (kind_ == FrameKind::kColour) {
            expect_ = Expect::kDepth;
        } else {
            event_.pair_good = true;
            event_.number = number_;
            expect_ = Expect::kColour;
        }
    }
    in_frame_ = true;
    control_good_ = false;
    control_.clear();
    x_ = 0;
    line_ = 0;
}

/// Drops the frame under way, and the pair it belongs to.
void DviDecoder::reject(RejectCause cause) {
    in_frame_ = false;
    ++rejected_frames_[static_cast<std::size_t>(cause)];
    event_.rejected = true;
    event_.cause = cause;
    if (expect_ == Expect::kDepth || control_good_) {
        lose_pair(number_);
    }
    expect_ = Expect::kAnyColour;
    control_good_ = false;
}

void DviDecoder::lose_pair(std::uint32_t number) {
    event_.pair_lost = true;
    event_.lost_number = number;
}

void DviDecoder::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, pixel_o.read(), path("pixel"));
    sc_trace(file, event_o.read(), path("event"));
    sc_core::sc_trace(file, line_, path("line"));
}

std::string DviDecoder::waiting_for() const {
    switch (expect_) {
        case Expect::kAnyColour:
            return "waits for a good colour frame";
        case Expect::kColour:
            return "waits for the next colour frame";
        case Expect::kDepth:
            return "waits for the depth frame of pair " + std::to_string(number_);
    }
    return {};
}

}  // namespace metabuffer::rtl
