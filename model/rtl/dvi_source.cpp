#include "rtl/dvi_source.h"

#include "formats/control_scanline.h"

namespace metabuffer::rtl {
namespace {

constexpr std::uint32_t kBlueByte = 0xFF;

void flip_byte(std::vector<std::uint32_t>& link_pixels, std::size_t byte) {
    const std::size_t pixel = byte / kLinkBytesPerPixel;
    const auto shift = static_cast<unsigned>(8 * (kLinkBytesPerPixel - 1 - byte % kLinkBytesPerPixel));
    link_pixels[pixel] ^= kBlueByte << shift;
}

}  // namespace

DviSource::DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                     ClockGating gating)
    : Block(name),
      scenario_(scenario),
      renderer_(scenario.renderers[static_cast<std::size_t>(renderer)]),
      renderer_index_(renderer),
      timing_(renderer_.timing()),
      gate_(gating) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void DviSource::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= pair_request_i.value_changed_event();
}

void DviSource::clock_edge() {
    if (gate_.opened()) {
        return;
    }
    if (reset_i.read()) {
        state_ = State::kFirstSync;
        next_pair_ = 0;
        pair_under_way_ = false;
        kind_ = FrameKind::kColour;
        x_ = 0;
        line_ = 0;
        link_ = DviLink{};
        link_o.write(link_);
        return;
    }
    switch (state_) {
        case State::kFirstSync:
            // A monitor link that comes up shows a vertical sync before its first frame.
            link_.vsync = line_ < DviTiming::kVerticalSyncLines;
            link_o.write(link_);
            if (link_.vsync) {
                if (++x_ == timing_.line_clocks()) {
                    x_ = 0;
                    ++line_;
                }
                break;
            }
            state_ = State::kIdle;
            [[fallthrough]];
        case State::kIdle:
            start_frame_or_blank();
            break;
        case State::kSilence:
            if (--silence_clocks_ == 0) {
                start_frame_or_blank();
            }
            break;
        case State::kFrame:
            step_raster();
            break;
    }
    if (gate_.idle_edge(state_ == State::kIdle && !pair_under_way_)) {
        next_trigger(wake_events_);
    }
}

const Fault* DviSource::fault_of(FrameKind kind, FaultKind fault) const {
    for (const Fault& candidate : scenario_.faults) {
        if (candidate.renderer == renderer_index_ && candidate.pair == pair_ && candidate.frame == kind &&
            candidate.kind == fault) {
            return &candidate;
        }
    }
    return nullptr;
}

void DviSource::start_frame_or_blank() {
    if (start_next_frame()) {
        step_raster();
    } else if (link_.vsync) {
        link_ = DviLink{};  // the sync is over, the pause goes on in blanking
        link_o.write(link_);
    }
}

/// Decides what follows a frame, a silence or an idle clock: true if a frame starts in this clock.
bool DviSource::start_next_frame() {
    while (true) {
        if (!pair_under_way_) {
            const bool may_send =
                scenario_.pacing == Pacing::kFreeRunning ||
                (pair_request_i.read() && next_pair_ < static_cast<std::uint32_t>(scenario_.frames));
            if (!may_send) {
                state_ = State::kIdle;
                return false;
            }
            pair_ = next_pair_++;
            pair_under_way_ = true;
            kind_ = FrameKind::kColour;
            delay_served_ = false;
        }
        const Fault* const delay = fault_of(kind_, FaultKind::kDelay);
        if (delay != nullptr && !delay_served_) {
            delay_served_ = true;
            silence_clocks_ = 2 * timing_.frame_clocks() * delay->delay_pairs;
            state_ = State::kSilence;
            return false;
        }
        delay_served_ = false;
        if (!has_fault(FaultKind::kMissing)) {
            prepare_frame();
            state_ = State::kFrame;
            return true;
        }
        if (kind_ == FrameKind::kColour) {
            kind_ = FrameKind::kDepth;
        } else {
            pair_under_way_ = false;
        }
    }
}

void DviSource::prepare_frame() {
    image_ = &renderer_.image_of_pair(pair_);
    ControlScanline content;
    content.kind = kind_;
    content.frame_number = pair_ + (has_fault(FaultKind::kNumber) ? 1 : 0);
    content.table = renderer_.frame_of_pair(pair_).table;
    if (has_fault(FaultKind::kKind)) {
        content.kind = static_cast<FrameKind>(2);
    }
    control_ = encode_control_scanline(content, timing_.active_pixels);
    if (has_fault(FaultKind::kMagic)) {
        flip_byte(control_, kControlMagicOffset);
    }
    if (has_fault(FaultKind::kVersion)) {
        flip_byte(control_, kControlVersionOffset);
    }
    if (has_fault(FaultKind::kCrc)) {
        flip_byte(control_, kControlCrcOffset);
    }
    x_ = 0;
    line_ = 0;
    active_lines_ = timing_.active_lines;
    if (has_fault(FaultKind::kShortFrame)) {
        --active_lines_;
    }
    if (has_fault(FaultKind::kLongFrame)) {
        ++active_lines_;
    }
}

/// Active pixels of the line under way: 0 in vertical blanking; a fault may shorten or lengthen the last
/// line.
int DviSource::active_pixels_of_line() const {
    const int active_line = line_ - DviTiming::kVerticalBackLines;
    if (active_line < 0 || active_line >= active_lines_) {
        return 0;
    }
    if (active_line == active_lines_ - 1) {
        if (has_fault(FaultKind::kShortLine)) {
            return timing_.active_pixels - 1;
        }
        if (has_fault(FaultKind::kLongLine)) {
            return timing_.active_pixels + 1;
        }
    }
    return timing_.active_pixels;
}

std::uint32_t DviSource::active_data() const {
    const int active_line = line_ - DviTiming::kVerticalBackLines;
    if (x_ >= timing_.active_pixels || active_line > image_->height_pixels) {
        return 0;  // what a fault adds
    }
    if (active_line == 0) {
        return control_[static_cast<std::size_t>(x_)];
    }
    const Pixel pixel = image_->at(x_, active_line - 1);
    return kind_ == FrameKind::kColour ? colour_link_bits(pixel)
                                       : depth_link_bits(pixel, scenario_.depth_format);
}

/// Drives one clock of the frame under way and moves on to the next.
void DviSource::step_raster() {
    if (x_ == 0) {
        line_active_pixels_ = active_pixels_of_line();
        const int sync_start = DviTiming::kVerticalBackLines + active_lines_ + DviTiming::kVerticalFrontLines;
        vsync_line_ = line_ >= sync_start;
    }
    const int sync_start = timing_.active_pixels + DviTiming::kHorizontalFrontPixels;
    DviLink link;
    link.vsync = vsync_line_;
    link.de = x_ < line_active_pixels_;
    link.data = link.de ? active_data() : 0;
    link.hsync = x_ >= sync_start && x_ < sync_start + DviTiming::kHorizontalSyncPixels;
    if (!(link == link_)) {
        link_ = link;
        link_o.write(link_);
    }
    if (++x_ < timing_.line_clocks()) {
        return;
    }
    x_ = 0;
    const int frame_lines = DviTiming{timing_.active_pixels, active_lines_}.frame_lines();
    if (++line_ < frame_lines) {
        return;
    }
    if (kind_ == FrameKind::kColour) {
        kind_ = FrameKind::kDepth;
    } else {
        pair_under_way_ = false;
    }
    state_ = State::kIdle;
}

void DviSource::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, pair_request_i, path("pair_request"));
    sc_trace(file, link_o.read(), path("DVI"));
    sc_core::sc_trace(file, pair_, path("pair"));
}

std::string DviSource::waiting_for() const {
    switch (state_) {
        case State::kIdle:
            if (next_pair_ >= static_cast<std::uint32_t>(scenario_.frames)) {
                return {};
            }
            return "waits for its input framebuffer to ask for pair " + std::to_string(next_pair_);
        case State::kSilence:
            return "is silent before pair " + std::to_string(pair_);
        default:
            return {};
    }
}

}  // namespace metabuffer::rtl
