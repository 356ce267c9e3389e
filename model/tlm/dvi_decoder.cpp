#include "tlm/dvi_decoder.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "report/waits.h"

namespace metabuffer::tlm {
namespace {

/// Clocks from the link to the decoder, and from the decoder to the input framebuffer.
constexpr std::int64_t kDecoderClocks = 1;
constexpr std::int64_t kFramebufferClocks = 1;

}  // namespace

DviDecoder::DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing, int latency_clocks)
    : sc_core::sc_module(name),
      timing_(timing),
      latency_clocks_(latency_clocks),
      newest_moments_{{0, pairs_}} {
    link_socket.register_b_transport(this, &DviDecoder::b_transport);
}

void DviDecoder::b_transport(Payload& payload, sc_core::sc_time& delay) {
    decode(content_of<DviFrame>(payload));
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    framebuffer_socket->b_transport(decoded_.payload(), delay);
}

/// The follower of pairs has a new state from a clock on, with or without an event to report.
void DviDecoder::learnt(LinkEvent event, std::int64_t edge) {
    newest_moments_.push_back({edge, pairs_});
    if (event.reports_anything()) {
        event.edge = edge + kFramebufferClocks;
        decoded_->events.push_back(std::move(event));
    }
}

/// Walks through the frame as the clocked decoder does, from one end of a line to the next. `edge` is always the clock
/// in which the decoder receives the end of the line.
void DviDecoder::decode(const DviFrame& frame) {
    DecodedFrame& decoded = *decoded_;
    decoded.events.clear();
    decoded.kind.reset();
    newest_moments_.assign(1, {0, pairs_});
    const std::int64_t first_line = frame.first_edge +
                                    std::int64_t{DviTiming::kVerticalBackLines} * timing_.line_clocks() +
                                    latency_clocks_ + kDecoderClocks;
    decoded.first_pixel_edge = first_line + timing_.line_clocks() + kFramebufferClocks;
    decoded.pixels = 0;
    decoded.line_pixels = timing_.active_pixels;
    decoded.line_clocks = timing_.line_clocks();

    const auto reject_geometry = [this](std::int64_t edge) {
        LinkEvent event;
        pairs_.reject_geometry(event);
        learnt(std::move(event), edge);
    };
    pairs_.begin_frame();
    int lines_seen = 0;
    for (int line = 0; line < frame.active_lines && pairs_.in_frame(); ++line) {
        const std::int64_t start = first_line + std::int64_t{line} * timing_.line_clocks();
        const int pixels = line == frame.active_lines - 1 ? frame.last_line_pixels : timing_.active_pixels;
        if (pixels == 0) {
            continue;  // no DE, no line
        }
        if (line >= timing_.active_lines) {
            reject_geometry(start);
            break;
        }
        if (line > 0) {
            decoded.pixels += std::min(pixels, timing_.active_pixels);
        }
        if (pixels != timing_.active_pixels) {
            reject_geometry(start + std::min(pixels, timing_.active_pixels));
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
    if (!pairs_.in_frame() || lines_seen == 0) {
        return;
    }
    LinkEvent event;
    pairs_.end_frame(lines_seen == timing_.active_lines, event);
    if (event.pair_good) {
        event.colour = colour_image_;
        event.depth = frame.image;
        event.payload = std::move(payload_);
        event.last_pixel_edge = first_line + std::int64_t{frame.active_lines - 1} * timing_.line_clocks() +
                                timing_.active_pixels - 1;
    }
    learnt(std::move(event), vsync);
}

void DviDecoder::end_control_scanline(const DviFrame& frame, std::int64_t edge) {
    DecodedScanline scanline = decode_control_scanline(frame.control);
    if (scanline.defect == ScanlineDefect::kNone) {
        decoded_->kind = scanline.content.kind;
        decoded_->number = scanline.content.frame_number;
    }
    LinkEvent event;
    pairs_.end_control_scanline(scanline, event);
    if (event.colour_start) {
        colour_image_ = frame.image;
        event.table = std::move(scanline.content.table);
    }
    payload_ = std::move(scanline.content.payload);
    learnt(std::move(event), edge);
}

const PairFollower& DviDecoder::pairs_at(std::int64_t through_edge) const {
    const auto later = std::find_if(newest_moments_.begin() + 1, newest_moments_.end(),
                                    [=](const Moment& moment) { return moment.edge > through_edge; });
    return std::prev(later)->pairs;
}

std::array<std::int64_t, kRejectCauseCount> DviDecoder::rejected_frames(std::int64_t through_edge) const {
    return pairs_at(through_edge).rejected();
}

std::string DviDecoder::waiting_for(std::int64_t through_edge) const {
    return waits::for_link_frame(pairs_at(through_edge));
}

}  // namespace metabuffer::tlm
