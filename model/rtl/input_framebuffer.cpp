#include "rtl/input_framebuffer.h"

#include <algorithm>
#include <utility>

#include "report/waits.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
namespace {

int divide_up(int value, int divisor) { return (value + divisor - 1) / divisor; }

}  // namespace

InputFramebuffer::InputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario,
                                   int renderer)
    : Block(name),
      busready_i("busready_i", static_cast<std::size_t>(scenario.displays.count())),
      tableready_i("tableready_i", static_cast<std::size_t>(scenario.displays.count())),
      scenario_(scenario),
      renderer_(scenario.renderers[static_cast<std::size_t>(renderer)]),
      limits_(scenario.limits(renderer_)),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      cycles_per_beat_(cycles_per_beat(scenario.bus)),
      cycles_per_table_row_(divide_up(8 * kControlRowBytes, scenario.bus.width_bits)),
      lost_slot_cycles_(metabuffer::lost_slot_cycles(scenario)),
      frame_memory_("frame_memory", scenario.memory, scenario.depth_format,
                    std::int64_t{renderer_.image_width_pixels} * renderer_.image_height_pixels),
      bus_arbiter_("bus_arbiter", scenario.bus.arbitration),
      banks_(scenario.pacing, pair_clocks(renderer_), link_timeout_clocks(scenario, renderer_)) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
    SC_METHOD(link_clock_edge);
    sensitive << dvi_clk_i.pos();
    dont_initialize();
}

// ---- the link's side ----

void InputFramebuffer::link_reset() {
    banks_.reset(link_edge_);
    request_seen_ = false;
    answer_now_ = Answer{};
    request_synchronizer_.reset();
    answer_.write(answer_now_);
    pair_request_ = false;
    pair_request_o.write(false);
}

void InputFramebuffer::link_clock_edge() {
    ++link_edge_;
    if (reset_i.read()) {
        link_reset();
    } else {
        run_link();
    }
    previous_edge_picoseconds_ = static_cast<std::int64_t>(sc_core::sc_time_stamp().value());
}

void InputFramebuffer::run_link() {
    const DecodedPixel& pixel = pixel_i.read();
    if (pixel.valid) {
        frame_memory_.write_half(pixel.kind, pixel.address, pixel.data);
        // The decoder took the pixel from the link at the edge before.
        last_pixel_picoseconds_ = previous_edge_picoseconds_;
        ++link_pixels_;
    }
    take_event(event_i.read());
    const bool request = request_synchronizer_.sample(request_.read());
    if (request != request_seen_) {
        request_seen_ = request;
        banks_.ask();
    }
    if (const auto given = banks_.answer(link_edge_)) {
        const bool fresh = *given == BankKeeper::Answer::kFresh;
        if (fresh) {
            swap_banks();
        }
        answer_now_ = {!answer_now_.toggle, fresh};
        answer_.write(answer_now_);
    }
    const bool pair_request = banks_.wants_pair();
    if (pair_request != pair_request_) {
        pair_request_ = pair_request;
        pair_request_o.write(pair_request);
    }
}

void InputFramebuffer::take_event(const DecoderEvent& event) {
    const BankKeeper::Taken taken = banks_.take(event, link_edge_);
    renderer_counters_.dropped_frames += taken.dropped_pairs;
    if (event.colour_start) {
        back_table_.clear();
    }
    if (event.row) {
        back_table_.push_back(event.table_row);
    }
    if (taken.pair_accepted) {
        back_number_ = event.number;
        ValidatedTable table = validate_table(back_table_, limits_);
        renderer_counters_.add_rejected_rows(back_number_, table);
        back_table_ = std::move(table.rows);
    }
}

void InputFramebuffer::swap_banks() {
    frame_memory_.swap_banks();
    front_rows_ = back_table_;
    front_source_ = {static_cast<int>(back_number_), true, last_pixel_picoseconds_};
}

// ---- the bus side ----

void InputFramebuffer::reset() {
    state_ = State::kRequest;
    answer_synchronizer_.reset();
    answer_toggle_ = false;
    frames_started_ = 0;
    burst_row_ = kNoRow;
    request_.write(false);
    bus_driven_ = true;
    drive_nothing();
}

void InputFramebuffer::clock_edge() {
    if (reset_i.read()) {
        reset();
        ++renderer_counters_.bus.idle_cycles;
        return;
    }
    const Answer& answer = answer_synchronizer_.sample(answer_.read());
    switch (state_) {
        case State::kRequest:
            ++renderer_counters_.bus.idle_cycles;
            ask_for_frame();
            break;
        case State::kWait:
            ++renderer_counters_.bus.idle_cycles;
            if (answer.toggle != answer_toggle_) {
                answer_toggle_ = answer.toggle;
                start_frame(answer.fresh);
            }
            break;
        case State::kTable:
            table_clock();
            break;
        case State::kSend:
            send_clock();
            break;
        case State::kDone:
            ++renderer_counters_.bus.idle_cycles;
            break;
    }
}

void InputFramebuffer::ask_for_frame() {
    if (frames_started_ == scenario_.frames) {
        state_ = State::kDone;
        return;
    }
    request_.write(!request_.read());
    state_ = State::kWait;
}

void InputFramebuffer::start_frame(bool fresh) {
    ++frames_started_;
    if (!fresh) {
        ++renderer_counters_.repeated_frames;
    }
    frame_sources_.push_back(front_source_);
    frame_sources_.back().fresh = fresh;

    rows_.clear();
    pixels_left_ = 0;
    std::vector<Segment> segments;
    for (const ViewportRow& row : front_rows_) {
        Row state;
        state.segment = Segment(row, limits_.raster_width_pixels, limits_.raster_height_pixels);
        state.composer = row.dcomp - std::size_t{1};
        state.left = state.segment.pixels();
        state.address = std::int64_t{row.sy} * renderer_.image_width_pixels + row.sx;
        pixels_left_ += state.left;
        segments.push_back(state.segment);
        rows_.push_back(state);
    }
    requests_.assign(rows_.size(), BusRequest{});
    bus_arbiter_.start_frame(segments);
    frame_memory_.close_page();
    table_started_ = false;
    table_row_ = 0;
    table_wait_ = cycles_per_table_row_;
    state_ = State::kTable;
}

bool InputFramebuffer::composers_take_table() const {
    return std::all_of(tableready_i.begin(), tableready_i.end(),
                       [](const sc_core::sc_in<bool>& tableready) { return tableready.read(); });
}

void InputFramebuffer::table_clock() {
    drive_nothing();
    if (!table_started_) {
        if (!composers_take_table()) {
            ++renderer_counters_.bus.poll_cycles;
            return;
        }
        table_started_ = true;
        drive(BusBeat::frame_start(frame_on_bus(), rows_.empty()));
    } else if (--table_wait_ == 0) {
        const auto place = static_cast<std::uint32_t>(table_row_);
        const ViewportRow& row = rows_[table_row_++].segment.row();
        drive(BusBeat::table_row(frame_on_bus(), place, row, table_row_ == rows_.size()));
        table_wait_ = cycles_per_table_row_;
    }
    ++renderer_counters_.bus.table_cycles;
    if (table_row_ == rows_.size()) {
        state_ = State::kSend;
    }
}

void InputFramebuffer::send_clock() {
    drive_nothing();
    announced_seen_ = announced_before_;
    announced_before_ = announced_;
    const int passed_over_row = std::exchange(unseen_row_, kNoRow);
    stop_burst_on_busready();
    if (beat_wait_ > 0) {
        ++renderer_counters_.bus.busy_cycles;
        if (--beat_wait_ == 0) {
            drive_beat();
        }
        return;
    }
    if (lost_wait_ > 0) {
        ++renderer_counters_.bus.lost_cycles;
        --lost_wait_;
        return;
    }
    if (burst_row_ == kNoRow) {
        if (pixels_left_ == 0) {
            ++renderer_counters_.bus.idle_cycles;
            ask_for_frame();
            return;
        }
        if (!arbitrate(passed_over_row)) {
            return;
        }
    }
    Row& row = rows_[static_cast<std::size_t>(burst_row_)];
    if (!page_ready(row.address)) {
        ++renderer_counters_.bus.page_miss_cycles;
        return;
    }
    ++renderer_counters_.bus.busy_cycles;
    fill_beat(row);
    beat_wait_ = cycles_per_beat_ - 1;
    if (beat_wait_ == 0) {
        drive_beat();
    }
}

/// A low BUSREADY stops a burst, unless it is the answer to the question whether a further slot would be
/// taken: that is what a composer answers once the rest of the burst fits one beat.
void InputFramebuffer::stop_burst_on_busready() {
    if (burst_row_ == kNoRow || announced_seen_ <= pixels_per_beat_ ||
        busready_i[rows_[static_cast<std::size_t>(burst_row_)].composer].read()) {
        return;
    }
    stopped_row_ = beat_wait_ > 0 ? burst_row_ : kNoRow;
    burst_row_ = kNoRow;
    burst_left_ = 0;
    page_wait_ = 0;
    announced_ = announced_before_ = 0;  // the burst granted now is not judged by this one's rest
}

/// False if no burst starts in this clock.
bool InputFramebuffer::arbitrate(int passed_over_row) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        requests_[i].pending = rows_[i].left > 0;
        requests_[i].ready = static_cast<int>(i) != passed_over_row && busready_i[rows_[i].composer].read();
        requests_[i].next_pixel = rows_[i].segment.pixels() - rows_[i].left;
    }
    const BusGrant grant = bus_arbiter_.pick(requests_);
    switch (grant.kind) {
        case BusGrant::Kind::kPoll:
            ++renderer_counters_.bus.poll_cycles;
            return false;
        case BusGrant::Kind::kLost:
            ++renderer_counters_.bus.lost_cycles;
            lost_wait_ = lost_slot_cycles_ - 1;
            return false;
        case BusGrant::Kind::kBurst:
            break;
    }
    renderer_counters_.bus.recovered_slots += grant.recovered_slots;
    ++renderer_counters_.bus.bursts;
    burst_row_ = grant.row;
    burst_left_ = static_cast<int>(
        std::min<std::int64_t>(scenario_.bus.burst_pixels, rows_[static_cast<std::size_t>(grant.row)].left));
    burst_started_ = false;
    return true;
}

/// False while the page of the next word is being opened.
bool InputFramebuffer::page_ready(std::int64_t address) {
    if (page_wait_ > 0) {
        --page_wait_;
        return false;
    }
    if (frame_memory_.page_is_open(address)) {
        return true;
    }
    frame_memory_.open_page(address);
    ++renderer_counters_.bus.page_misses;
    if (frame_memory_.page_miss_cycles() == 0) {
        return true;
    }
    page_wait_ = frame_memory_.page_miss_cycles() - 1;
    return false;
}

/// Reads the next words of the open page, as many as fit one beat.
void InputFramebuffer::fill_beat(Row& row) {
    const ViewportRow& table_row = row.segment.row();
    beat_.kind = BusBeat::Kind::kPixels;
    beat_.last = false;
    beat_.frame = frame_on_bus();
    beat_.destination = table_row.dcomp;
    beat_.count = 0;
    beat_.first = static_cast<std::uint32_t>(row.segment.pixels() - row.left);
    do {
        beat_.words[beat_.count++] = frame_memory_.read(row.address).word();
        --row.left;
        --burst_left_;
        ++row.address;
        if (++row.column == table_row.sdx) {
            row.column = 0;
            row.address += renderer_.image_width_pixels - table_row.sdx;
        }
    } while (beat_.count < pixels_per_beat_ && burst_left_ > 0 && frame_memory_.page_is_open(row.address));
    pixels_left_ -= beat_.count;
    renderer_counters_.bus.pixels_sent += beat_.count;
}

void InputFramebuffer::drive_beat() {
    beat_.remaining = static_cast<std::uint32_t>(burst_left_);
    drive(beat_);
    announced_ = burst_left_;
    if (burst_left_ == 0) {
        unseen_row_ = burst_started_ ? std::exchange(stopped_row_, kNoRow) : burst_row_;
        burst_row_ = kNoRow;
    }
    burst_started_ = true;
}

void InputFramebuffer::drive(const BusBeat& beat) {
    bus_o.write(beat);
    bus_driven_ = true;
}

void InputFramebuffer::drive_nothing() {
    if (bus_driven_) {
        bus_o.write(BusBeat{});
        bus_driven_ = false;
    }
}

void InputFramebuffer::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, pair_request_o, path("pair_request"));
    sc_trace(file, bus_o.read(), path("BUS"));
    for (std::size_t d = 0; d < busready_i.size(); ++d) {
        const std::string display = "_" + std::to_string(d + 1);
        sc_core::sc_trace(file, busready_i[d], path(("BUSREADY" + display).c_str()));
        sc_core::sc_trace(file, tableready_i[d], path(("TABLEREADY" + display).c_str()));
    }
    sc_core::sc_trace(file, request_, path("request"));
    sc_trace(file, answer_.read(), path("answer"));
    sc_core::sc_trace(file, burst_row_, path("burst_row"));
    sc_core::sc_trace(file, burst_left_, path("burst_left"));
    sc_core::sc_trace(file, page_wait_, path("page_wait"));
    sc_core::sc_trace(file, pixels_left_, path("pixels_left"));
    sc_core::sc_trace(file, frames_started_, path("frames_started"));
    frame_memory_.trace(file);
    bus_arbiter_.trace(file);
}

std::string InputFramebuffer::waiting_for() const {
    const std::int64_t frame = frames_started_ - 1;
    switch (state_) {
        case State::kRequest:
        case State::kWait:
            return waits::for_pair(frames_started_);
        case State::kTable:
            return table_started_ ? "" : waits::for_tableready(frame);
        case State::kSend: {
            if (page_wait_ > 0) {
                return waits::for_memory_page();
            }
            if (lost_wait_ > 0) {
                return waits::for_lost_slot();
            }
            std::vector<int> displays;
            for (const Row& row : rows_) {
                if (row.left > 0) {
                    displays.push_back(row.segment.row().dcomp);
                }
            }
            return waits::for_busready(displays, pixels_left_, frame);
        }
        case State::kDone:
            return {};
    }
    return {};
}

}  // namespace metabuffer::rtl
