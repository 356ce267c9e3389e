#include "rtl/link_port.h"

#include <utility>

#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
LinkPort::LinkPort(const sc_core::sc_module_name& name, const Scenario& scenario, const Renderer& renderer,
                   Records records, ClockGating gating)
    : Block(name),
      depth_format_(scenario.depth_format),
      records_(std::move(records)),
      gate_(gating),
      write_(registers_, "write", bits_for(renderer.image_words() - 1)),
      banks_(registers_, "banks", 1,
             BankKeeper(scenario.pacing, pair_clocks(renderer), link_timeout_clocks(scenario, renderer))) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void LinkPort::end_of_elaboration() {
    gate_.attach(clk_i);
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= pixel_i.value_changed_event();
    wake_events_ |= event_i.value_changed_event();
    wake_events_ |= request_i.value_changed_event();
}

void LinkPort::reset() {
    registers_.reset();
    banks_->reset(edge_);
    front_source_ = FrameSource{};
    pair_request_o.write(false);
    answer_o.write(false);
    fresh_o.write(false);
    front_o.write(false);
    write_o.write(MemoryWrite{});
}

void LinkPort::clock_edge() {
    if (gate_.opened()) {
        // A pixel that ends the sleep has come at an edge, and this is still its time.
        previous_edge_picoseconds_ = now_picoseconds();
        return;
    }
    edge_ += edges_.count();
    if (reset_i.read()) {
        reset();
    } else {
        write_pixel(pixel_i.read());
        take_event(event_i.read());
        const bool request = request_.sample(request_i.read());
        if (request != request_seen_) {
            request_seen_ = request;
            banks_->ask();
        }
        if (const auto given = banks_->answer(edge_)) {
            answer(*given == BankKeeper::Answer::kFresh);
        }
        drive_output(pair_request_, pair_request_o, banks_->wants_pair());
    }
    previous_edge_picoseconds_ = now_picoseconds();
    if (gate_.idle_edge(idle())) {
        edges_.sleep();
        next_trigger(wake_events_);
    }
}

/// Nothing comes from the link or the bus side, and no answer waits for a time.
bool LinkPort::idle() const {
    return !reset_i.read() && !pixel_i.read().valid && !write_->enable && !event_i.read().tells_something() &&
           request_.settled(request_i.read()) && request_i.read() == request_seen_ &&
           banks_->wants_pair() == pair_request_ && !banks_->next_timer(edge_);
}

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
    const bool colour = pixel.kind == FrameKind::kColour;
    const Pixel word =
        colour ? with_colour_half(Pixel{}, pixel.data) : with_depth_half(Pixel{}, pixel.data, depth_format_);
    write_ = {true, static_cast<std::uint8_t>(front_ ? 0 : 1), pixel.address, word.word(),
              colour ? MemoryWrite::kColourBytes : MemoryWrite::kDepthBytes};
    write_o.write(write_);
    // The decoder received the pixel from the link at the edge before.
    last_pixel_picoseconds_ = previous_edge_picoseconds_;
    ++link_pixels_;
}

void LinkPort::take_event(const DecoderEvent& event) {
    const BankKeeper::Taken taken = banks_->take(event, edge_);
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
        front_source_.pair = static_cast<int>(banks_->back_number());
        front_source_.last_pixel_picoseconds = last_pixel_picoseconds_;
    }
}

void LinkPort::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
