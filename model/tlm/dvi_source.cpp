#include "tlm/dvi_source.h"

namespace metabuffer::tlm {
namespace {

constexpr std::uint32_t kByteMask = 0xFF;

void flip_byte(std::vector<std::uint32_t>& link_words, int byte) {
    const auto word = static_cast<std::size_t>(byte / kLinkBytesPerPixel);
    const int shift = 8 * (kLinkBytesPerPixel - 1 - byte % kLinkBytesPerPixel);
    link_words[word] ^= kByteMask << shift;
}

}  // namespace

DviSource::DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                     std::int64_t first_edge)
    : sc_core::sc_module(name),
      scenario_(scenario),
      renderer_(scenario.renderers[static_cast<std::size_t>(renderer)]),
      renderer_index_(renderer),
      timing_(renderer_.timing()),
      clock_(clock_period_picoseconds(scenario.clocks.dvi_in_mhz)),
      next_edge_(first_edge + std::int64_t{DviTiming::kVerticalSyncLines} * timing_.line_clocks()) {
    SC_METHOD(process);
    sensitive << wake_event_ << pair_request_i;
}

void DviSource::wake_at(std::int64_t edge) {
    next_edge_ = edge;
    wake_event_.notify(clock_.until(edge));
}

void DviSource::process() {
    const std::int64_t now = now_picoseconds();
    if (state_ == State::kIdle && pair_request_i.read() && now >= clock_.picoseconds_of(next_edge_)) {
        // The request has risen at this clock; it is read at the next.
        if (pair_request_i.event()) {
            wake_at(clock_.edge_at(now) + 1);
            return;
        }
    }
    if (now < clock_.picoseconds_of(next_edge_)) {
        wake_event_.notify(clock_.until(next_edge_));
        return;
    }
    if (now == clock_.picoseconds_of(next_edge_)) {
        decide(next_edge_);
    }
}

const Fault* DviSource::fault_of(FaultKind fault) const {
    for (const Fault& candidate : scenario_.faults) {
        if (candidate.renderer == renderer_index_ && candidate.pair == pair_ && candidate.frame == kind_ &&
            candidate.kind == fault) {
            return &candidate;
        }
    }
    return nullptr;
}

/// What follows a frame, a silence or a pause.
void DviSource::decide(std::int64_t edge) {
    if (state_ == State::kFrame) {
        if (kind_ == FrameKind::kColour) {
            kind_ = FrameKind::kDepth;
        } else {
            pair_under_way_ = false;
        }
    }
    while (true) {
        if (!pair_under_way_) {
            const bool may_send =
                scenario_.pacing == Pacing::kFreeRunning ||
                (pair_request_i.read() && next_pair_ < static_cast<std::uint32_t>(scenario_.frames));
            if (!may_send) {
                state_ = State::kIdle;
                return;
            }
            pair_ = next_pair_++;
            pair_under_way_ = true;
            kind_ = FrameKind::kColour;
            delay_served_ = false;
        }
        const Fault* const delay = fault_of(FaultKind::kDelay);
        if (delay != nullptr && !delay_served_) {
            delay_served_ = true;
            state_ = State::kSilence;
            wake_at(edge + 2 * timing_.frame_clocks() * delay->delay_pairs);
            return;
        }
        delay_served_ = false;
        if (!has_fault(FaultKind::kMissing)) {
            state_ = State::kFrame;
            send_frame(edge);
            return;
        }
        if (kind_ == FrameKind::kColour) {
            kind_ = FrameKind::kDepth;
        } else {
            pair_under_way_ = false;
        }
    }
}

void DviSource::send_frame(std::int64_t edge) {
    ControlScanline content;
    content.kind = has_fault(FaultKind::kKind) ? static_cast<FrameKind>(2) : kind_;
    content.frame_number = pair_ + (has_fault(FaultKind::kNumber) ? 1 : 0);
    content.table = renderer_.frame_of_pair(pair_).table;
    DviFrame& frame = *frame_;
    frame.control = encode_control_scanline(content, timing_.active_pixels);
    if (has_fault(FaultKind::kMagic)) {
        flip_byte(frame.control, kControlMagicOffset);
    }
    if (has_fault(FaultKind::kVersion)) {
        flip_byte(frame.control, kControlVersionOffset);
    }
    if (has_fault(FaultKind::kCrc)) {
        flip_byte(frame.control, kControlCrcOffset);
    }
    frame.image = &renderer_.image_of_pair(pair_);
    frame.active_lines = timing_.active_lines - (has_fault(FaultKind::kShortFrame) ? 1 : 0) +
                         (has_fault(FaultKind::kLongFrame) ? 1 : 0);
    frame.last_line_pixels = timing_.active_pixels;
    if (has_fault(FaultKind::kShortLine)) {
        --frame.last_line_pixels;
    } else if (has_fault(FaultKind::kLongLine)) {
        ++frame.last_line_pixels;
    }
    frame.first_edge = edge;

    ::tlm::tlm_generic_payload& payload = frame_.payload();
    payload.set_data_ptr(reinterpret_cast<unsigned char*>(frame.control.data()));
    payload.set_data_length(static_cast<unsigned>(frame.control.size() * sizeof(std::uint32_t)));
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    link_socket->b_transport(payload, delay);
    wake_at(edge + DviTiming{timing_.active_pixels, frame.active_lines}.frame_clocks());
}

std::string DviSource::waiting_for(std::int64_t picoseconds) const {
    if (state_ == State::kSilence) {
        return "is silent before pair " + std::to_string(pair_);
    }
    // A frame's last clock leaves the source without one.
    const bool idle = state_ == State::kIdle ||
                      (state_ == State::kFrame && picoseconds >= clock_.picoseconds_of(next_edge_ - 1));
    if (!idle || next_pair_ >= static_cast<std::uint32_t>(scenario_.frames)) {
        return {};
    }
    return "waits for its input framebuffer to ask for pair " + std::to_string(next_pair_);
}

}  // namespace metabuffer::tlm
