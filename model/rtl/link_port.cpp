#include "rtl/link_port.h"

#include <utility>

#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
LinkPort::LinkPort(const sc_core::sc_module_name& name, const Scenario& scenario, const Renderer& renderer,
                   Records records)
    : Block(name),
      depth_format_(scenario.depth_format),
      records_(std::move(records)),
      write_(registers_, "write", bits_for(renderer.image_words() - 1)),
      pairs_(registers_, "banks", 1,
             PairKeeper(scenario.pacing, pair_clocks(renderer), link_timeout_clocks(scenario, renderer))) {}

void LinkPort::reset() {
    registers_.reset();
    pairs_.change().reset(edge_);
    front_source_ = FrameSource{};
    pair_request_o.write(false);
    answer_o.write(false);
    fresh_o.write(false);
    front_o.write(false);
    write_o.write(MemoryWrite{});
}

void LinkPort::clock_edge() {
    pass_edge();
    write_pixel(pixel_i.read());
    if (event_i.read().reports_anything()) {
        take_event(event_i.read());
    }
    if (request_.arrives(request_i.read())) {
        pairs_.change().ask();
    }
    if (pairs_->can_answer(edge_)) {
        answer(*pairs_.change().answer(edge_) == PairKeeper::Answer::kFresh);
    }
    if (pairs_->next_timer(edge_)) {
        clocked_.stay_awake();
    }
    drive_output(pair_request_, pair_request_o, pairs_->wants_pair());
}

void LinkPort::pass_edge() { edge_ += 1 + clocked_.slept_edges(); }

/// The write reaches the memory a clock later. That is in time: a pair's verdict is never in the clock of its last
/// pixel.
void LinkPort::write_pixel(const DecodedPixel& pixel) {
    if (!pixel.valid) {
        if (write_.value().enable) {
            write_ = MemoryWrite{};
            write_o.write(write_);
        }
        return;
    }
    clocked_.stay_awake();  // each edge counts a pixel
    const bool colour = pixel.kind == FrameKind::kColour;
    const Pixel word =
        colour ? with_colour_half(Pixel{}, pixel.data) : with_depth_half(Pixel{}, pixel.data, depth_format_);
    write_ = {true, static_cast<std::uint8_t>(front_ ? 0 : 1), pixel.address, word.word(),
              colour ? MemoryWrite::kColourBytes : MemoryWrite::kDepthBytes};
    write_o.write(write_);
    // The decoder received the pixel from the link at the edge before.
    last_pixel_picoseconds_ = clocked_.previous_edge_picoseconds();
    ++link_pixels_;
}

void LinkPort::take_event(const DecoderEvent& event) {
    const PairKeeper::Taken taken = pairs_.change().take(event, edge_);
    if (taken.dropped_pairs > 0) {
        records_.dropped(taken.dropped_pairs);
    }
    if (taken.pair_accepted) {
        records_.accepted(event.number);
    }
}

void LinkPort::answer(bool fresh) {
    answer_ = !answer_;
    answer_o.write(answer_);
    fresh_ = fresh;
    fresh_o.write(fresh);
    if (fresh) {
        front_ = !front_;
        front_o.write(front_);
        front_source_.pair = static_cast<int>(pairs_->back_number());
        front_source_.last_pixel_picoseconds = last_pixel_picoseconds_;
    }
}

void LinkPort::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
