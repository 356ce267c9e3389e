#include <algorithm>
#include <utility>

#include "scenario/link_program.h"
#include "tlm/input_framebuffer.h"

/// The link's side of an input framebuffer; input_framebuffer.cpp has the bus side.
namespace metabuffer::tlm {

void InputFramebuffer::take_frame(Payload& payload, sc_core::sc_time& /*delay*/) {
    const auto& frame = content_of<DecodedFrame>(payload);
    if (scenario_.memory.shared()) {
        while (has_next_block()) write_block();
        // A depth frame goes where its colour frame went.
        link_writes_.next_word = 0;
        link_writes_.placed = std::none_of(frame.events.begin(), frame.events.end(),
                                           [](const LinkEvent& event) { return event.colour_start; });
    }
    link_pixels_before_ += link_frame_.pixels;
    link_frame_ = static_cast<const LinkPixels&>(frame);
    link_events_.insert(link_events_.end(), frame.events.begin(), frame.events.end());
    if (settings_.observer != nullptr) report_link_frame(frame);
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    wake_link();
}

void InputFramebuffer::report_link_frame(const DecodedFrame& frame) const {
    LinkFrameSeen seen;
    seen.kind = frame.kind;
    seen.pair = frame.number;
    for (const LinkEvent& event : frame.events) {
        seen.taken = seen.taken || event.colour_start || event.pair_good;
        // A colour frame's beginning rejects the pair before it, not this frame.
        if (event.rejected && !event.colour_start) {
            seen.taken = false;
            seen.cause = event.cause;
        }
    }
    const std::int64_t last_edge = frame.edge_of(std::max<std::int64_t>(0, frame.pixels - 1));
    seen.span = {core_.edge_at(dvi_.picoseconds_of(frame.first_pixel_edge)),
                 core_.edge_at(dvi_.picoseconds_of(last_edge))};
    settings_.observer->link_frame(settings_.renderer + 1, seen);
}

/// At the next clock in which something may change.
void InputFramebuffer::wake_link() {
    const std::int64_t edge = dvi_.edge_at(now_picoseconds());
    std::int64_t next = std::min(request_edge_, banks_.next_timer(edge).value_or(kUnknownCycle));
    if (!link_events_.empty()) next = std::min(next, link_events_.front().edge);
    if (next != kUnknownCycle) link_wake_.notify(dvi_.until(next));
}

void InputFramebuffer::link_process() {
    const std::int64_t edge = dvi_.edge_at(now_picoseconds());
    while (!link_events_.empty() && link_events_.front().edge <= edge) {
        take_event(link_events_.front(), edge);
        link_events_.pop_front();
    }
    if (request_edge_ <= edge) {
        request_edge_ = kUnknownCycle;
        banks_.ask();
    }
    if (const auto given = banks_.answer(edge)) {
        answer(*given == PairKeeper::Answer::kFresh, edge);
    }
    pair_request_o.write(banks_.wants_pair());
    wake_link();
}

void InputFramebuffer::take_event(const LinkEvent& event, std::int64_t edge) {
    const PairKeeper::Taken taken = banks_.take(event, edge);
    counters_.dropped_frames += taken.dropped_pairs;
    if (event.colour_start) {
        filling_table_ = event.table;
        link_writes_.placed = true;
        link_writes_.first_word = first_word_of(!front_device_);
    }
    if (taken.pair_accepted) {
        ValidatedTable table = validate_table(filling_table_, limits_);
        counters_.add_rejected_rows(event.number, table);
        SentSlots slots = machine_slots(scenario_.bus, table, event.payload);
        counters_.rejected_slot_tables += slots.rejected ? 1 : 0;
        back_ = {std::move(table.rows),
                 std::move(slots.slots),
                 {static_cast<int>(event.number), true, dvi_.picoseconds_of(event.last_pixel_edge)},
                 event.colour,
                 event.depth};
    }
}

void InputFramebuffer::answer(bool fresh, std::int64_t edge) {
    if (fresh) {
        front_ = back_;
        front_device_ = !front_device_;
        if (settings_.cache != nullptr) {
            front_content_ = settings_.cache->content(*front_.colour, *front_.depth);
        }
    }
    front_.source.fresh = fresh;
    state_ = State::kStart;
    next_cycle_ = core_.edge_seeing(dvi_.picoseconds_of(edge));
    agenda_.schedule(bus_, next_cycle_);
}

std::int64_t InputFramebuffer::link_pixels(std::int64_t through_edge) const {
    return link_pixels_before_ + link_frame_.come(through_edge);
}

// ---- shared ports ----

std::int64_t InputFramebuffer::next_block_words() const {
    const LinkWrites& writes = link_writes_;
    return std::min<std::int64_t>(scenario_.memory.write_block_words,
                                  renderer_.image_words() - writes.next_word);
}

/// A frame that is broken off leaves its last block unwritten.
bool InputFramebuffer::has_next_block() const {
    return link_writes_.next_word < renderer_.image_words() &&
           link_writes_.next_word + next_block_words() <= link_frame_.pixels;
}

/// The first clock in which the memory may write the next block.
std::int64_t InputFramebuffer::next_block_cycle() const {
    constexpr int kBufferClocks = 1;  // from the clock in which the framebuffer receives a block's last pixel
    const std::int64_t last = link_writes_.next_word + next_block_words() - 1;
    const std::int64_t edge = link_frame_.edge_of(last) + kBufferClocks;
    return core_.edge_seeing(dvi_.picoseconds_of(edge)) + 1;
}

void InputFramebuffer::write_block() {
    const std::int64_t words = next_block_words();
    Message<MemoryAccess> message;
    Payload& payload = message.payload();
    payload.set_address(static_cast<sc_dt::uint64>(link_writes_.first_word + link_writes_.next_word) *
                        kBytesPerWord);
    payload.set_data_length(static_cast<unsigned>(words) * kBytesPerWord);
    message->write = true;
    message->settled_before = agenda_.now();
    message->cycle = newest_block_cycle_ = next_block_cycle();
    transport(memory_socket, payload);
    link_writes_.next_word += words;
}

/// Sends the memory the blocks that it may write before a clock, and one more.
void InputFramebuffer::write_blocks(std::int64_t cycle) {
    while (link_writes_.placed && has_next_block() && newest_block_cycle_ <= cycle) {
        write_block();
    }
}

/// No block that is not known yet can be written before this clock.
std::int64_t InputFramebuffer::writes_known_before() const {
    if (!scenario_.memory.shared()) {
        return kUnknownCycle;
    }
    if (!link_writes_.placed && has_next_block()) {
        return next_block_cycle();
    }
    // The next frame is reported in its first clock.
    const DviTiming timing = renderer_.timing();
    constexpr int kLinesBeforePixels = DviTiming::kVerticalBackLines + 1;
    const std::int64_t edge =
        dvi_.edge_at(core_.picoseconds_of(agenda_.now())) +
        std::int64_t{kLinesBeforePixels} * timing.line_clocks() +
        std::min<std::int64_t>(scenario_.memory.write_block_words, renderer_.image_words());
    return core_.edge_seeing(dvi_.picoseconds_of(edge)) + 1;
}

}  // namespace metabuffer::tlm
