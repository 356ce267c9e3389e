#include "tlm/dvi_source.h"

#include "report/waits.h"

namespace metabuffer::tlm {

DviSource::DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                     std::int64_t first_edge)
    : sc_core::sc_module(name),
      timing_(scenario.renderers[static_cast<std::size_t>(renderer)].timing()),
      program_(scenario, renderer),
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

/// Decides what follows a frame, a silence or a pause.
void DviSource::decide(std::int64_t edge) {
    if (state_ == State::kFrame) {
        program_.end_frame();
    }
    switch (program_.next(pair_request_i.read())) {
        case LinkProgram::Step::kNothing:
            state_ = State::kIdle;
            break;
        case LinkProgram::Step::kSilence:
            state_ = State::kSilence;
            wake_at(edge + program_.silence_clocks());
            break;
        case LinkProgram::Step::kFrame:
            state_ = State::kFrame;
            send_frame(edge);
            break;
    }
}

void DviSource::send_frame(std::int64_t edge) {
    const LinkFrame& link = program_.frame();
    if (link.image_is_copy) {
        images_.push_back(link.image);
    }
    DviFrame& frame = *frame_;
    frame.control = link.control;
    frame.image = link.image.get();
    frame.active_lines = link.active_lines;
    frame.last_line_pixels = link.last_line_pixels;
    frame.first_edge = edge;
    transport(link_socket, frame_.payload());
    wake_at(edge + DviTiming{timing_.active_pixels, frame.active_lines}.frame_clocks());
}

std::string DviSource::waiting_for(std::int64_t picoseconds) const {
    if (state_ == State::kSilence) {
        return waits::in_silence(program_.pair());
    }
    // At a frame's last clock the source is idle already.
    const bool idle = state_ == State::kIdle ||
                      (state_ == State::kFrame && picoseconds >= clock_.picoseconds_of(next_edge_ - 1));
    if (!idle || program_.all_pairs_sent()) {
        return {};
    }
    return waits::for_pair_request(program_.next_pair());
}

}  // namespace metabuffer::tlm
