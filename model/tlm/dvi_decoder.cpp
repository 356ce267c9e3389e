#include "tlm/dvi_decoder.h"

#include <algorithm>
#include <utility>

namespace metabuffer::tlm {
namespace {

/// From a clock of the link to the clock in which the decoder takes it, and on to the one in which the input
/// framebuffer does.
constexpr std::int64_t kDecoderClocks = 1;
constexpr std::int64_t kFramebufferClocks = 1;

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

}  // namespace

DviDecoder::DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing)
    : sc_core::sc_module(name), timing_(timing), newest_expectations_{{0, Expect::kAnyColour, 0}} {
    link_socket.register_b_transport(this, &DviDecoder::b_transport);
}

void DviDecoder::b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    decode(content_of<DviFrame>(payload));
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    framebuffer_socket->b_transport(decoded_.payload(), delay);
}

LinkEvent& DviDecoder::event_at(std::int64_t edge) {
    std::vector<LinkEvent>& events = decoded_->events;
    const std::int64_t read_at = edge + kFramebufferClocks;
    if (events.empty() || events.back().edge != read_at) {
        events.emplace_back();
        events.back().edge = read_at;
    }
    return events.back();
}

/// Walks through the frame as the clocked decoder does, from one end of a line to the next. `edge` is always
/// the clock in which the decoder takes what is at the end of the line.
void DviDecoder::decode(const DviFrame& frame) {
    DecodedFrame& decoded = *decoded_;
    decoded.events.clear();
    newest_rejections_.clear();
    newest_expectations_.assign(1, {0, expect_, number_});
    const std::int64_t first_line = frame.first_edge +
                                    std::int64_t{DviTiming::kVerticalBackLines} * timing_.line_clocks() +
                                    kDecoderClocks;
    decoded.first_pixel_edge = first_line + timing_.line_clocks() + kFramebufferClocks;
    decoded.pixels = 0;
    decoded.line_pixels = timing_.active_pixels;
    decoded.line_clocks = timing_.line_clocks();

    frame_lives_ = true;
    control_good_ = false;
    int lines_seen = 0;
    for (int line = 0; line < frame.active_lines && frame_lives_; ++line) {
        const std::int64_t start = first_line + std::int64_t{line} * timing_.line_clocks();
        const int pixels = line == frame.active_lines - 1 ? frame.last_line_pixels : timing_.active_pixels;
        if (pixels == 0) {
            continue;  // no DE, no line
        }
        if (line >= timing_.active_lines) {
            reject(RejectCause::kGeometry, start);
            break;
        }
        if (line > 0) {
            decoded.pixels += std::min(pixels, timing_.active_pixels);
        }
        if (pixels > timing_.active_pixels) {
            reject(RejectCause::kGeometry, start + timing_.active_pixels);
            break;
        }
        if (pixels < timing_.active_pixels) {
            reject(RejectCause::kGeometry, start + pixels);
            break;
        }
        if (line == 0) {
            end_control_scanline(frame, start + pixels);
        }
        ++lines_seen;
    }
    const std::int64_t vsync =
        first_line +
        std::int64_t{frame.active_lines + DviTiming::kVerticalFrontLines} * timing_.line_clocks();
    if (!frame_lives_ || lines_seen == 0) {
        return;
    }
    if (lines_seen != timing_.active_lines) {
        reject(RejectCause::kGeometry, vsync);
    } else if (kind_ == FrameKind::kColour) {
        expect(Expect::kDepth, vsync);
    } else {
        LinkEvent& event = event_at(vsync);
        event.pair_good = true;
        event.number = number_;
        event.colour = colour_image_;
        event.depth = frame.image;
        event.last_pixel_edge = first_line + std::int64_t{frame.active_lines - 1} * timing_.line_clocks() +
                                timing_.active_pixels - 1;
        expect(Expect::kColour, vsync);
    }
}

void DviDecoder::end_control_scanline(const DviFrame& frame, std::int64_t edge) {
    DecodedScanline scanline = decode_control_scanline(frame.control);
    if (scanline.defect != ScanlineDefect::kNone) {
        reject(cause_of(scanline.defect), edge);
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
            reject(RejectCause::kPair, edge);
            frame_lives_ = true;
        }
        number_ = number;
        control_good_ = true;
        colour_image_ = frame.image;
        LinkEvent& event = event_at(edge);
        event.colour_start = true;
        event.number = number;
        event.table = std::move(scanline.content.table);
        return;
    }
    if (expect_ == Expect::kDepth && number == number_) {
        control_good_ = true;
        return;
    }
    if (expect_ == Expect::kColour && number == number_) {
        reject(RejectCause::kPair, edge);  // sent again behind its pair, which is whole and stays so
        return;
    }
    // Where the two frames of a pair differ, the lower number is the pair that is lost now.
    const bool is_earlier = static_cast<std::int32_t>(number - number_) < 0;
    const std::uint32_t lost = expect_ == Expect::kDepth && !is_earlier ? number_ : number;
    if (expect_ == Expect::kAnyColour) {
        frame_lives_ = false;  // its colour frame has been rejected or was never seen
    } else {
        reject(RejectCause::kPair, edge);
    }
    LinkEvent& event = event_at(edge);
    event.pair_lost = true;
    event.lost_number = lost;
}

/// Drops the frame under way, and the pair it belongs to.
void DviDecoder::reject(RejectCause cause, std::int64_t edge) {
    frame_lives_ = false;
    ++rejected_frames_[static_cast<std::size_t>(cause)];
    newest_rejections_.push_back({edge, cause});
    LinkEvent& event = event_at(edge);
    event.rejected = true;
    event.cause = cause;
    if (expect_ == Expect::kDepth || control_good_) {
        event.pair_lost = true;
        event.lost_number = number_;
    }
    expect(Expect::kAnyColour, edge);
    control_good_ = false;
}

void DviDecoder::expect(Expect expect, std::int64_t edge) {
    expect_ = expect;
    newest_expectations_.push_back({edge, expect, number_});
}

std::array<std::int64_t, kRejectCauseCount> DviDecoder::rejected_frames(std::int64_t through_edge) const {
    auto rejected = rejected_frames_;
    for (const Rejection& rejection : newest_rejections_) {
        if (rejection.edge > through_edge) {
            --rejected[static_cast<std::size_t>(rejection.cause)];
        }
    }
    return rejected;
}

std::string DviDecoder::waiting_for(std::int64_t through_edge) const {
    Expectation now = newest_expectations_.front();
    for (const Expectation& expectation : newest_expectations_) {
        if (expectation.edge <= through_edge) {
            now = expectation;
        }
    }
    switch (now.expect) {
        case Expect::kAnyColour:
            return "waits for a good colour frame";
        case Expect::kColour:
            return "waits for the next colour frame";
        case Expect::kDepth:
            return "waits for the depth frame of pair " + std::to_string(now.number);
    }
    return {};
}

}  // namespace metabuffer::tlm
