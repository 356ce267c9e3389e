#include "tlm/input_framebuffer.h"

#include <algorithm>
#include <utility>

#include "datapath/arbitration/arbitration_table.h"
#include "report/waits.h"
#include "scenario/derived_timing.h"
#include "scenario/link_program.h"

namespace metabuffer::tlm {
namespace {

/// From the clock that sends a beat to the first one in which its composer's answer is read, without delays on the way.
constexpr int kAnswerClocks = 2;

int divide_up(int value, int divisor) { return (value + divisor - 1) / divisor; }

}  // namespace

InputFramebuffer::InputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario,
                                   Agenda& agenda, const Settings& settings)
    : sc_core::sc_module(name),
      scenario_(scenario),
      renderer_(scenario.renderers[static_cast<std::size_t>(settings.renderer)]),
      agenda_(agenda),
      bus_(agenda.add([this](std::int64_t cycle) { return decide(cycle); })),
      settings_(settings),
      limits_(scenario.limits(renderer_)),
      core_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      dvi_(clock_period_picoseconds(scenario.clocks.dvi_in_mhz)),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      cycles_per_beat_(cycles_per_beat(scenario.bus)),
      delay_cycles_(bus_delay_cycles(scenario.bus, scenario.memory)),
      loop_cycles_(bus_loop_cycles(scenario.bus, scenario.memory)),
      banks_(scenario.pacing, pair_clocks(renderer_), link_timeout_clocks(scenario, renderer_)),
      next_cycle_(settings_.first_cycle),
      policy_(make_policy(scenario.bus.arbitration)),
      counted_from_(static_cast<std::size_t>(scenario.displays.count())),
      record_(settings_.renderer + 1, pixels_per_beat_, cycles_per_beat_, settings_.observer) {
    banks_.reset(settings_.first_link_edge - 1);
    link_socket.register_b_transport(this, &InputFramebuffer::take_frame);
    bus_socket.register_nb_transport_bw(this, &InputFramebuffer::take_notice);
    // For the first two tables every composer has room, from the clock after the first one without reset.
    for (int frame = 0; frame < 2; ++frame) {
        table_ready_[static_cast<std::size_t>(frame)] = {frame, scenario.displays.count(),
                                                         settings_.first_cycle};
    }
    SC_METHOD(link_process);
    sensitive << link_wake_;
    dont_initialize();
    agenda_.schedule(bus_, next_cycle_);
}

// ---- the bus side ----

Decision InputFramebuffer::decide(std::int64_t cycle) {
    record_.begin_decision();
    switch (state_) {
        case State::kStart:
            start_frame(cycle);
            break;
        case State::kTable:
            send_table(cycle);
            break;
        case State::kSend:
            if (pixels_left_ == 0) {
                ask_for_frame(cycle);
            } else {
                arbitrate(cycle);
            }
            break;
        case State::kBurst:
            continue_burst();
            break;
        case State::kWait:
        case State::kDone:
            break;
    }
    return {next_cycle_, next_cycle_ != kUnknownCycle && is_certain()};
}

bool InputFramebuffer::is_certain() const {
    if (state_ != State::kSend) {
        return state_ != State::kBurst;
    }
    return std::all_of(rows_.begin(), rows_.end(), [this](const Row& row) {
        return row.left == 0 || row.slot.cycle != kUnknownCycle || row.slot.not_before > next_cycle_;
    });
}

void InputFramebuffer::ask_for_frame(std::int64_t cycle) {
    next_cycle_ = kUnknownCycle;
    if (frames_started_ == scenario_.frames) {
        state_ = State::kDone;
        return;
    }
    state_ = State::kWait;
    request_edge_ = dvi_.edge_seeing(core_.picoseconds_of(cycle));
    wake_link();
}

void InputFramebuffer::start_frame(std::int64_t cycle) {
    ++frames_started_;
    if (!front_.source.fresh) {
        ++counters_.repeated_frames;
    }
    frame_sources_.push_back(front_.source);
    rows_.clear();
    pixels_left_ = 0;
    for (const ViewportRow& row : front_.rows) {
        rows_.push_back(
            {Segment(row, limits_.raster_width_pixels, limits_.raster_height_pixels, limits_.smoothing)});
        rows_.back().address =
            first_word_of(front_device_) + std::int64_t{row.sy} * renderer_.image_width_pixels + row.sx;
        pixels_left_ += rows_.back().left;
    }
    requests_.assign(rows_.size(), BusRequest{});
    policy_->start_frame(front_.slots, rows_.size());
    constexpr std::int64_t kStartClocks = 2;  // the arbiter sees the frame's start, then its first request
    slot_table_cycle_ = cycle + kStartClocks + scenario_.bus.build_cycles(front_.slots.size());
    new_frame_ = true;
    state_ = State::kTable;
    record_.begin_poll(cycle + 1);
    next_cycle_ = table_cycle();
}

/// The clock of the frame-start beat, if it is known.
std::int64_t InputFramebuffer::table_cycle() const {
    const TableReady& ready = table_ready_[static_cast<std::size_t>(frame() % kFramesKept)];
    if (ready.frame != frame() || ready.composers < limits_.displays) {
        return kUnknownCycle;
    }
    return std::max(
        {record_.poll_began(), ready.cycle + 1 + scenario_.bus.register_stages, table_counted_from_});
}

BusTransfer& InputFramebuffer::transfer(int display) {
    Payload& payload = bus_transfer_.payload();
    payload.set_address(static_cast<sc_dt::uint64>(display));
    bus_transfer_->frame = frame();
    transport(bus_socket, payload);
    if (!payload.is_response_ok()) {
        SC_REPORT_ERROR("/metabuffer/input_framebuffer/bus",
                        (std::string(name()) + ": a transfer to display " + std::to_string(display) +
                         " was answered " + payload.get_response_string())
                            .c_str());
    }
    return *bus_transfer_;
}

void InputFramebuffer::send_table(std::int64_t cycle) {
    record_.end_poll(cycle);
    table_counted_from_ = cycle + kAnswerClocks + loop_cycles_;
    const int row_cycles = divide_up(8 * kControlRowBytes, scenario_.bus.width_bits);
    const std::int64_t last_beat = cycle + static_cast<std::int64_t>(rows_.size()) * row_cycles;
    record_.add({BusUse::kTable, {cycle, last_beat}, frame()});
    state_ = State::kSend;
    next_cycle_ = last_beat + 1;
    if (pixels_left_ > 0 && slot_table_cycle_ > next_cycle_) {
        wait_for_arbiter(slot_table_cycle_ - next_cycle_);
    }
    std::vector<const Row*> row_of(static_cast<std::size_t>(limits_.displays), nullptr);
    for (const Row& row : rows_) row_of[row.display() - std::size_t{1}] = &row;
    bus_transfer_->kind = BusTransfer::Kind::kTable;
    bus_transfer_->table_cycle = last_beat + 1 + delay_cycles_;
    for (int display = 1; display <= limits_.displays; ++display) {
        const Row* const row = row_of[static_cast<std::size_t>(display) - 1];
        bus_transfer_->row = row != nullptr ? &row->segment.row() : nullptr;
        bus_transfer_->content = row != nullptr ? front_content_ : nullptr;
        transfer(display);
    }
    bus_transfer_->content.reset();
    // The buffers may still be full of the frame before.
    for (Row& row : rows_) {
        ask_for_slot(row, std::max(next_cycle_, counted_from_[row.display() - std::size_t{1}]));
    }
}

void InputFramebuffer::arbitrate(std::int64_t cycle) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const Row& row = rows_[i];
        requests_[i].pending = row.left > 0;
        requests_[i].ready = row.slot.cycle <= cycle;
        if (requests_[i].pending && goes_by_deadlines(scenario_.bus.arbitration)) {
            requests_[i].deadline = row.segment.first_use(row.sent);
        }
    }
    const BusGrant grant = policy_->pick(requests_);
    switch (grant.kind) {
        case BusGrant::Kind::kPoll:
            record_.begin_poll(cycle);
            next_cycle_ = kUnknownCycle;
            for (const Row& row : rows_) {
                if (row.left > 0) next_cycle_ = std::min(next_cycle_, row.slot.cycle);
            }
            return;
        case BusGrant::Kind::kLost: {
            next_cycle_ = cycle;
            wait_for_arbiter(scenario_.bus.grant_cycles);
            const CycleSpan lost{next_cycle_, next_cycle_ + lost_slot_cycles(scenario_) - 1};
            next_cycle_ = lost.last + 1;
            record_.add({BusUse::kLost, lost});
            return;
        }
        case BusGrant::Kind::kBurst:
            record_.end_poll(cycle);
            next_cycle_ = cycle;
            wait_for_arbiter(scenario_.bus.grant_cycles);
            record_.add_burst(next_cycle_, grant.recovered_slots);
            if (grant.recovered_slots > 0 && !first_recovered_slot_.happened()) {
                first_recovered_slot_.cycle = next_cycle_;
                first_recovered_slot_.display = rows_[static_cast<std::size_t>(grant.row)].display();
            }
            start_burst(grant.row, grant.recovered_slots);
            return;
    }
}

/// Lets clocks pass from next_cycle_ on.
void InputFramebuffer::wait_for_arbiter(std::int64_t clocks) {
    if (clocks == 0) return;
    record_.add({BusUse::kGrant, {next_cycle_, next_cycle_ + clocks - 1}});
    next_cycle_ += clocks;
}

void InputFramebuffer::start_burst(int row, int recovered_slots) {
    const Row& granted = rows_[static_cast<std::size_t>(row)];
    burst_row_ = row;
    burst_left_ = static_cast<int>(std::min<std::int64_t>(scenario_.bus.burst_pixels, granted.left));
    burst_beats_ = 0;
    recovered_slots_ = recovered_slots;
    at_cycle_ = next_cycle_;
    accessing_ = false;
    // Only a composer whose ready space is free gets a slot, so a burst that fits into it is never cut.
    may_cut_ = scenario_.composer.ready_space_pixels < burst_left_;
    unjudged_.clear();
    stop_cycle_ = kUnknownCycle;
    continue_burst();
}

/// The burst goes on from at_cycle_, as far as is certain.
void InputFramebuffer::continue_burst() {
    const Row& row = rows_[static_cast<std::size_t>(burst_row_)];
    const std::int64_t now = agenda_.now();
    while (burst_left_ > 0) {
        const std::int64_t limit = judge_beats();
        const bool stops = stop_cycle_ != kUnknownCycle;
        if (stops && at_cycle_ >= limit) {
            break;
        }
        if (!accessing_) {
            const bool may_stop = limit != kUnknownCycle && !stops;
            if (at_cycle_ > now && (may_stop || scenario_.memory.shared())) {
                go_on_at(at_cycle_);
                return;
            }
            access_memory(row);
            accessing_ = true;
        }
        const MemoryAccess& access = *memory_access_;
        if (limit != kUnknownCycle && at_cycle_ + access.wait_cycles > limit) {
            if (!stops) {
                go_on_at(limit);
                return;
            }
            wait_for_memory(access, limit - at_cycle_);
            break_off_opening(limit);
            break;
        }
        accessing_ = false;
        const std::int64_t beats_before = std::min({access.beats_before, limit, writes_known_before()});
        wait_for_memory(access, access.wait_cycles);
        if (access.words > 0 && at_cycle_ < beats_before) {
            send_beats(pixels_before(beats_before, access.words));
        }
    }
    // Beats that are not judged yet do not stop the burst: BUSREADY falls only if more pixels follow than can go out
    // after its fall.
    end_burst(burst_left_ == 0);
}

/// The first clock in which the burst does not go on, or in which that depends on a BUSREADY that is not known yet.
/// Until then it goes on whatever BUSREADY does.
std::int64_t InputFramebuffer::judge_beats() {
    while (stop_cycle_ == kUnknownCycle && !unjudged_.empty()) {
        bus_transfer_->kind = BusTransfer::Kind::kVerdict;
        bus_transfer_->beat = unjudged_.front();
        const std::int64_t read = unjudged_.front().sampled + 1 + scenario_.bus.register_stages;
        const BusTransfer& answer = transfer(rows_[static_cast<std::size_t>(burst_row_)].display());
        if (answer.verdict == BufferTime::Verdict::kUndecided) {
            return read;
        }
        if (answer.verdict == BufferTime::Verdict::kDropped) {
            stop_cycle_ = read;
        }
        unjudged_.pop_front();
    }
    return stop_cycle_;
}

void InputFramebuffer::go_on_at(std::int64_t cycle) {
    state_ = State::kBurst;
    next_cycle_ = cycle;
}

/// Asks the memory for what is left of the burst.
void InputFramebuffer::access_memory(const Row& row) {
    Payload& payload = memory_access_.payload();
    payload.set_address(static_cast<sc_dt::uint64>(row.address) * kBytesPerWord);
    payload.set_data_length(static_cast<unsigned>(burst_left_) * kBytesPerWord);
    memory_access_->new_frame = std::exchange(new_frame_, false);
    memory_access_->cycle = at_cycle_;
    memory_access_->first_row_words = row.segment.row().sdx - row.column;
    memory_access_->row_words = row.segment.row().sdx;
    memory_access_->stride_words = renderer_.image_width_pixels;
    if (scenario_.memory.shared()) write_blocks(at_cycle_);
    transport(memory_socket, payload);
    const MemoryAccess& answer = *memory_access_;
    const bool goes_on = answer.words >= 1 ? answer.beats_before - at_cycle_ > answer.wait_cycles
                                           : answer.words == 0 && answer.wait_cycles > 0;
    if (!payload.is_response_ok() || answer.wait_cycles < 0 || !goes_on || answer.words > burst_left_) {
        // This may be a user's own memory; if it made no progress the burst would never end.
        SC_REPORT_ERROR("/metabuffer/input_framebuffer/memory",
                        (std::string(name()) + ": its memory answered " + payload.get_response_string() +
                         ", " + std::to_string(answer.words) + " of " + std::to_string(burst_left_) +
                         " words after " + std::to_string(answer.wait_cycles) + " clocks")
                            .c_str());
    }
}

void InputFramebuffer::break_off_opening(std::int64_t cycle) {
    memory_access_->broken_off = true;
    memory_access_->cycle = cycle;
    transport(memory_socket, memory_access_.payload());
    memory_access_->broken_off = false;
}

/// Lets the first `clocks` clocks of a wait pass.
void InputFramebuffer::wait_for_memory(const MemoryAccess& access, std::int64_t clocks) {
    if (clocks == 0 && !access.page_miss) return;
    static constexpr std::array kUses{BusUse::kPageMiss, BusUse::kRefresh, BusUse::kWrite};  // by Wait
    const Row& row = rows_[static_cast<std::size_t>(burst_row_)];
    BusSpan span{kUses[static_cast<std::size_t>(access.wait)], {at_cycle_, at_cycle_ + clocks - 1}};
    span.display = row.display();
    span.word_address = row.address;
    span.page_misses = access.page_miss ? 1 : 0;
    record_.add(span);
    at_cycle_ += clocks;
}

/// Of `pixels` pixels sent from at_cycle_ on, those whose beats begin before a clock.
int InputFramebuffer::pixels_before(std::int64_t cycle, int pixels) const {
    if (cycle == kUnknownCycle) {
        return pixels;
    }
    const std::int64_t beats = (cycle - at_cycle_ + cycles_per_beat_ - 1) / cycles_per_beat_;
    return static_cast<int>(std::min<std::int64_t>(pixels, beats * pixels_per_beat_));
}

void InputFramebuffer::advance(Row& row, int pixels) const {
    const int width = row.segment.row().sdx;
    row.left -= pixels;
    row.sent += pixels;
    row.address += pixels;
    row.column += pixels;
    while (row.column >= width) {
        row.column -= width;
        row.address += renderer_.image_width_pixels - width;
    }
}

/// Puts up to `pixels` pixels on the bus, beat by beat from at_cycle_ on; fewer if BUSREADY falls, or may fall, at a
/// beat.
void InputFramebuffer::send_beats(int pixels) {
    Row& row = rows_[static_cast<std::size_t>(burst_row_)];
    bus_transfer_->kind = BusTransfer::Kind::kBeats;
    bus_transfer_->beats = {row.sent, pixels, at_cycle_ + cycles_per_beat_ - 1 + delay_cycles_};
    bus_transfer_->remaining = burst_left_ - pixels;
    // After a beat at which BUSREADY falls or may fall, the next beats go out without asking, up to the clock that
    // reads it.
    bus_transfer_->heed_busready = may_cut_ && unjudged_.empty() && stop_cycle_ == kUnknownCycle;
    const BusTransfer& answer = transfer(row.display());
    const int taken = answer.pixels_taken;
    const int beats = divide_up(taken, pixels_per_beat_);
    const CycleSpan span{at_cycle_, at_cycle_ + std::int64_t{beats} * cycles_per_beat_ - 1};
    const std::int64_t sampled = span.last + delay_cycles_ + 1;
    if (answer.verdict == BufferTime::Verdict::kDropped) {
        stop_cycle_ = sampled + 1 + scenario_.bus.register_stages;
    } else if (answer.verdict == BufferTime::Verdict::kUndecided) {
        unjudged_.push_back({row.sent + taken, sampled, burst_left_ - taken});
    } else if (may_cut_ && !unjudged_.empty()) {
        for (int beat = 1; beat <= beats; ++beat) {
            const int sent = std::min(beat * pixels_per_beat_, taken);
            unjudged_.push_back({row.sent + sent, sampled - std::int64_t{beats - beat} * cycles_per_beat_,
                                 burst_left_ - sent});
        }
    }
    record_.add(
        {BusUse::kBusy, span, frame(), row.display(), row.sent, taken, std::exchange(recovered_slots_, 0)});
    advance(row, taken);
    pixels_left_ -= taken;
    burst_left_ -= taken;
    burst_beats_ += beats;
    last_beat_pixels_ = taken - (beats - 1) * pixels_per_beat_;
    at_cycle_ = span.last + 1;
}

/// whole: no fall of BUSREADY has stopped it.
void InputFramebuffer::end_burst(bool whole) {
    Row& row = rows_[static_cast<std::size_t>(burst_row_)];
    state_ = State::kSend;
    next_cycle_ = at_cycle_;
    // A BUSREADY that cannot count the last beat yet is not trusted. It can without delays on the way, if the burst had
    // a beat before: that one announced the rest.
    const bool trusted =
        whole && loop_cycles_ == 0 && burst_beats_ > 1 &&
        scenario_.composer.buffer_pixels - last_beat_pixels_ >= scenario_.composer.ready_space_pixels;
    constexpr int kAnswered = kAnswerClocks - 1;  // the clock before has sent the last beat
    const std::int64_t counted_from = trusted ? at_cycle_ : at_cycle_ + kAnswered + loop_cycles_;
    counted_from_[row.display() - std::size_t{1}] = counted_from;
    if (row.left > 0) ask_for_slot(row, counted_from);
}

void InputFramebuffer::ask_for_slot(Row& row, std::int64_t earliest) {
    bus_transfer_->kind = BusTransfer::Kind::kEndOfBurst;
    bus_transfer_->earliest = earliest;
    row.slot = transfer(row.display()).slot;
}

/// A notice may come while this bus plans a burst: the pixels that it has sent may start a column. The notice only
/// changes what is known of waiting rows, which the next arbitration reads.
::tlm::tlm_sync_enum InputFramebuffer::take_notice(Payload& payload, Phase& phase,
                                                   sc_core::sc_time& /*delay*/) {
    const auto& notice = content_of<BusNotice>(payload);
    if (phase == tableready_phase) {
        TableReady& ready = table_ready_[static_cast<std::size_t>(notice.frame % kFramesKept)];
        if (ready.frame != notice.frame) {
            ready = {notice.frame, 0, 0};
        }
        ++ready.composers;
        ready.cycle = std::max(ready.cycle, notice.table_cycle);
        if (state_ == State::kTable) {
            next_cycle_ = table_cycle();
            agenda_.schedule(bus_, next_cycle_);
        }
        return ::tlm::TLM_ACCEPTED;
    }
    const auto display = static_cast<int>(payload.get_address());
    for (Row& row : rows_) {
        if (row.display() == display && row.left > 0) {
            row.slot.cycle = notice.slot_cycle;
            if (state_ == State::kSend && record_.polls() && notice.slot_cycle < next_cycle_) {
                next_cycle_ = notice.slot_cycle;
                agenda_.schedule(bus_, next_cycle_);
            }
        }
    }
    return ::tlm::TLM_ACCEPTED;
}

// ---- what a run reports ----

RendererCounters InputFramebuffer::counters(std::int64_t through_cycle) const {
    RendererCounters counters = counters_;
    counters.bus = record_.counters(through_cycle);
    return counters;
}

std::int64_t InputFramebuffer::bus_progress(std::int64_t through_cycle) const {
    const BusCounters bus = record_.counters(through_cycle);
    return bus.pixels_sent + bus.table_cycles;
}

std::string InputFramebuffer::waiting_for(std::int64_t through_cycle) const {
    switch (state_) {
        case State::kWait:
        case State::kStart:
            return waits::for_pair(frames_started_);
        case State::kTable:
            return waits::for_tableready(frame());
        case State::kSend:
        case State::kBurst: {
            if (const auto waits = record_.waiting_for(through_cycle)) return *waits;
            std::vector<int> displays;
            // A burst under way has been counted to its end.
            const std::int64_t unsent = record_.pixels_behind(through_cycle);
            for (std::size_t i = 0; i < rows_.size(); ++i) {
                const Row& row = rows_[i];
                const bool in_burst = unsent > 0 && static_cast<int>(i) == burst_row_;
                if (in_burst || row.left > 0) {
                    displays.push_back(row.display());
                }
            }
            return waits::for_busready(displays, pixels_left_ + unsent, frame());
        }
        case State::kDone:
            return {};
    }
    return {};
}

}  // namespace metabuffer::tlm
