#include "rtl/dvi_source.h"

#include "report/waits.h"

namespace metabuffer::rtl {
namespace {

// Wide enough for what the faults of a scenario make: lines and pixels that no mode has, and silences.
constexpr int kLineBits = 32;
constexpr int kSilenceBits = 63;

}  // namespace

DviSource::DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer)
    : Block(name),
      scenario_(scenario),
      timing_(scenario.renderers[static_cast<std::size_t>(renderer)].timing()),
      program_(scenario, renderer),
      silence_clocks_(registers_, "silence_clocks", kSilenceBits),
      x_(registers_, "x", bits_for(timing_.line_clocks())),
      line_(registers_, "line", kLineBits),
      line_active_pixels_(registers_, "line_active_pixels", kLineBits) {}

void DviSource::reset() {
    program_.reset();
    registers_.reset();
    character_registers_.reset();
    link_o.write(link_);
    clock_ppm_o.write(0);
    disturbance_o.write(disturbance_);
}

void DviSource::clock_edge() {
    if (flips_bits_) {  // only with faults of kind tmds_bits: the flips were for one clock
        TmdsDisturbance lasting = disturbance_;
        lasting.flips.fill(0);
        disturb(lasting);
    }
    switch (state_) {
        case State::kFirstSync:
            // A monitor link that comes up shows a vertical sync before its first frame.
            drive({0, false, false, line_ < DviTiming::kVerticalSyncLines});
            if (link_.value().vsync) {
                ++x_;
                if (x_ == timing_.line_clocks()) {
                    x_ = 0;
                    ++line_;
                }
                break;
            }
            [[fallthrough]];
        case State::kIdle:
            start_frame_or_blank();
            break;
        case State::kSilence:
            --silence_clocks_;
            if (silence_clocks_ == 0) {
                start_frame_or_blank();
            }
            break;
        case State::kFrame:
            step_raster();
            break;
    }
}

void DviSource::start_frame_or_blank() {
    if (start_next_frame()) {
        step_raster();
    } else if (link_.value().vsync) {
        drive(DviLink{});  // the sync is over, the pause goes on in blanking
    }
}

void DviSource::drive(const DviLink& link) {
    if (!(link == link_.value())) {
        link_ = link;
        link_o.write(link_);
    }
}

void DviSource::disturb(const TmdsDisturbance& disturbance) {
    if (!(disturbance == disturbance_.value())) {
        disturbance_ = disturbance;
        flips_bits_ = disturbance.flips_any();
        disturbance_o.write(disturbance);
    }
}

/// Decides what follows a frame, a silence or an idle clock: true if a frame starts in this clock.
bool DviSource::start_next_frame() {
    const LinkProgram::Step step = program_.next(pair_request_i.read());
    clock_ppm_o.write(program_.clock_ppm());
    switch (step) {
        case LinkProgram::Step::kNothing:
            state_ = State::kIdle;
            return false;
        case LinkProgram::Step::kSilence:
            silence_clocks_ = program_.silence_clocks();
            state_ = State::kSilence;
            return false;
        case LinkProgram::Step::kFrame:
            break;
    }
    x_ = 0;
    line_ = 0;
    state_ = State::kFrame;
    return true;
}

/// Active pixels of the line under way: 0 in vertical blanking; a fault may shorten or lengthen the last
/// line.
int DviSource::active_pixels_of_line() const {
    const LinkFrame& frame = program_.frame();
    const int active_line = line_ - DviTiming::kVerticalBackLines;
    if (active_line < 0 || active_line >= frame.active_lines) {
        return 0;
    }
    return active_line == frame.active_lines - 1 ? frame.last_line_pixels : timing_.active_pixels;
}

std::uint32_t DviSource::active_data() const {
    const LinkFrame& frame = program_.frame();
    const int active_line = line_ - DviTiming::kVerticalBackLines;
    if (x_ >= timing_.active_pixels || active_line > frame.image->height_pixels()) {
        return 0;  // what a fault adds
    }
    if (active_line == 0) {
        return frame.control[static_cast<std::size_t>(x_)];
    }
    const Pixel pixel = frame.image->pixels().at(x_, active_line - 1);
    return program_.kind() == FrameKind::kColour ? colour_link_bits(pixel)
                                                 : depth_link_bits(pixel, scenario_.depth_format);
}

/// Drives one clock of the frame under way and moves on to the next.
void DviSource::step_raster() {
    if (x_ == 0) {
        line_active_pixels_ = active_pixels_of_line();
        const int sync_start =
            DviTiming::kVerticalBackLines + program_.frame().active_lines + DviTiming::kVerticalFrontLines;
        vsync_line_ = line_ >= sync_start;
    }
    const int sync_start = timing_.active_pixels + DviTiming::kHorizontalFrontPixels;
    DviLink link;
    link.vsync = vsync_line_;
    link.de = x_ < line_active_pixels_;
    link.data = link.de ? active_data() : 0;
    link.hsync = x_ >= sync_start && x_ < sync_start + DviTiming::kHorizontalSyncPixels;
    drive(link);
    if (program_.disturbs_characters()) {
        program_.begin_clock(line_, x_);
        disturb(program_.disturbance());
    }
    ++x_;
    if (x_ < timing_.line_clocks()) {
        return;
    }
    x_ = 0;
    ++line_;
    const int frame_lines = DviTiming{timing_.active_pixels, program_.frame().active_lines}.frame_lines();
    if (line_ < frame_lines) {
        return;
    }
    program_.end_frame();
    state_ = State::kIdle;
}

void DviSource::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, pair_request_i.port(), path("pair_request"));
    registers_.trace(file, path(""));
    if (scenario_.links.tmds()) {
        character_registers_.trace(file, path(""));
    }
    sc_core::sc_trace(file, program_.pair(), path("pair"));
}

std::string DviSource::waiting_for() const {
    switch (state_) {
        case State::kIdle:
            if (program_.all_pairs_sent()) {
                return {};
            }
            return waits::for_pair_request(program_.next_pair());
        case State::kSilence:
            return waits::in_silence(program_.pair());
        default:
            return {};
    }
}

}  // namespace metabuffer::rtl
