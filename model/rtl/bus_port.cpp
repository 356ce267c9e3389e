#include "rtl/bus_port.h"

#include <algorithm>
#include <utility>

#include "datapath/arbitration/arbitration_table.h"
#include "report/waits.h"
#include "rtl/wires.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
namespace {

int divide_up(int value, int divisor) { return (value + divisor - 1) / divisor; }

}  // namespace

BusPort::Row::Row(RegisterSet& set, const std::string& name, const Renderer& renderer,
                  std::int64_t memory_words)
    : left(set, name + "_left", bits_for(renderer.image_words())),
      address(set, name + "_address", bits_for(memory_words)),
      column(set, name + "_column", bits_for(renderer.image_width_pixels)),
      image_width_pixels(renderer.image_width_pixels) {}

void BusPort::Row::advance(int pixels) {
    address = address_of(pixels);
    left -= pixels;
    column = (column + pixels) % segment.row().sdx;
}

BusPort::BusPort(const sc_core::sc_module_name& name, const Scenario& scenario, const Renderer& renderer,
                 std::function<void(bool fresh)> on_start, BusCounters& bus)
    : Block(name),
      front_i("front_i", scenario.memory.shared() ? 1 : 0),
      busready_i("busready_i", static_cast<std::size_t>(scenario.displays.count())),
      tableready_i("tableready_i", busready_i.size()),
      pending_o("pending_o", busready_i.size()),
      ready_o("ready_o", busready_i.size()),
      deadline_o("deadline_o", goes_by_deadlines(scenario.bus.arbitration) ? busready_i.size() : 0),
      grant_i("grant_i", busready_i.size()),
      scenario_(scenario),
      renderer_(renderer),
      on_start_(std::move(on_start)),
      bus_(bus),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      cycles_per_beat_(cycles_per_beat(scenario.bus)),
      cycles_per_table_row_(divide_up(8 * kControlRowBytes, scenario.bus.width_bits)),
      lost_slot_cycles_(metabuffer::lost_slot_cycles(scenario)),
      raster_width_pixels_(scenario.displays.raster_width_pixels()),
      raster_height_pixels_(scenario.displays.raster_height_pixels()),
      smoothing_(scenario.composer.smoothing),
      loop_cycles_(bus_loop_cycles(scenario.bus, scenario.memory)),
      frames_started_(registers_, "frames_started", bits_for(scenario.frames)),
      pixels_left_(registers_, "pixels_left", bits_for(renderer.image_words() * scenario.displays.count())),
      row_count_(registers_, "row_count", bits_for(scenario.displays.count())),
      table_row_(registers_, "table_row", bits_for(scenario.displays.count())),
      table_wait_(registers_, "table_wait", cycles_per_table_row_),
      burst_row_(registers_, "burst_row", bits_for(scenario.displays.count() - 1)),
      burst_left_(registers_, "burst_left", bits_for(scenario.bus.burst_pixels)),
      beat_wait_(registers_, "beat_wait", cycles_per_beat_),
      lost_wait_(registers_, "lost_wait", lost_slot_cycles_),
      announced_(registers_, "announced", bits_for(scenario.bus.burst_pixels)),
      announced_before_(registers_, "announced_before", bits_for(scenario.bus.burst_pixels)),
      announced_line_(registers_, "announced_before", loop_cycles_, bits_for(scenario.bus.burst_pixels)),
      uncounted_cycles_(registers_, "uncounted_cycles", 1 + loop_cycles_),
      table_uncounted_cycles_(registers_, "table_uncounted_cycles", 2 + loop_cycles_),
      words_(registers_, "words", pixels_per_beat_),
      leaving_(registers_, "leaving", scenario.memory.read_latency_cycles, 0) {
    const std::int64_t memory_words = scenario.memory.memory_words(renderer.image_words());
    for (std::size_t line = 0; line < busready_i.size(); ++line) {
        rows_.push_back(std::make_unique<Row>(registers_, numbered("row", line), renderer, memory_words));
        uncounted_.push_back(
            std::make_unique<Countdown>(registers_, numbered("uncounted", line), 1 + loop_cycles_));
    }
    clocked_.evaluates(&BusPort::drive_requests, {grant_valid_i, lost_i});
    for (std::size_t line = 0; line < busready_i.size(); ++line) {
        clocked_.evaluates_with({busready_i[line], grant_i[line]});
    }
}

void BusPort::reset() {
    count_sleep();
    registers_.reset();
    request_o.write(false);
    start_o.write(false);
    for (auto& pending : pending_o) {
        pending.write(false);
    }
    bus_o.write(BusBeat{});
    bus_driven_ = false;
    count(&BusCounters::idle_cycles);
}

void BusPort::clock_edge() {
    count_sleep();
    const bool answered = answer_.arrives(answer_i.read());
    count_answers();
    switch (state_) {
        case State::kRequest:
            count(&BusCounters::idle_cycles);
            ask_for_frame();
            break;
        case State::kWait:
            closing_ = false;
            count(&BusCounters::idle_cycles);
            if (answered) {
                start_frame(fresh_i.read());
            }
            break;
        case State::kTable:
            start_o.write(false);
            table_clock();
            break;
        case State::kSend:
            send_clock();
            break;
        case State::kDone:
            count(&BusCounters::idle_cycles);
            break;
    }
    put_out();
}

void BusPort::count_answers() {
    table_uncounted_cycles_.pass();
    if (uncounted_cycles_.pass()) {
        for (const auto& uncounted : uncounted_) {
            uncounted->pass();
        }
    }
}

void BusPort::ask_for_frame() {
    if (frames_started_ == scenario_.frames) {
        state_ = State::kDone;
        return;
    }
    closing_ = !scenario_.memory.shared();
    request_ = !request_;
    request_o.write(request_);
    state_ = State::kWait;
}

void BusPort::start_frame(bool fresh) {
    ++frames_started_;
    on_start_(fresh);
    const FrontTable& table = table_i.read();
    const bool second_image = scenario_.memory.shared() && front_i[0].read();
    const std::int64_t first_word =
        second_image ? scenario_.memory.device_words(renderer_.image_words()) : std::int64_t{0};
    row_count_ = static_cast<int>(table.rows.size());
    pixels_left_ = 0;
    for (int index = 0; index < row_count_; ++index) {
        const ViewportRow& table_row = table.rows[static_cast<std::size_t>(index)];
        Row& of_row = row(index);
        of_row.segment = Segment(table_row, raster_width_pixels_, raster_height_pixels_, smoothing_);
        of_row.left = of_row.segment.pixels();
        of_row.address =
            first_word + std::int64_t{table_row.sy} * renderer_.image_width_pixels + table_row.sx;
        of_row.column = 0;
        pixels_left_ += of_row.left;
        pending_o[static_cast<std::size_t>(index)].write(true);
        drive_deadline(static_cast<std::size_t>(index));
    }
    start_o.write(true);
    table_started_ = false;
    table_row_ = 0;
    table_wait_.start(cycles_per_table_row_);
    state_ = State::kTable;
}

bool BusPort::composers_take_table() const {
    return std::all_of(tableready_i.begin(), tableready_i.end(),
                       [](const In<bool>& tableready) { return tableready.read(); });
}

void BusPort::table_clock() {
    if (!table_started_) {
        if (table_uncounted_cycles_.running() || !composers_take_table()) {
            count(&BusCounters::poll_cycles);
            return;
        }
        table_started_ = true;
        sent_ = BusBeat::frame_start(frame_on_bus(), row_count_ == 0);
        if (loop_cycles_ > 0) {
            table_uncounted_cycles_.start(2 +
                                          loop_cycles_);  // without a loop, asking for a pair takes longer
        }
    } else {
        table_wait_.pass();
        if (!table_wait_.running()) {
            const int index = table_row_;
            ++table_row_;
            sent_ = BusBeat::table_row(frame_on_bus(), static_cast<std::uint32_t>(index),
                                       row(index).segment.row(), table_row_ == row_count_);
            table_wait_.start(cycles_per_table_row_);
        }
    }
    count(&BusCounters::table_cycles);
    if (table_row_ == row_count_) {
        state_ = State::kSend;
    }
}

void BusPort::send_clock() {
    announced_before_ = announced_line_.shift(announced_);
    if (plan_.stop) {
        stop_burst();
    }
    if (beat_wait_.pass()) {
        count(&BusCounters::busy_cycles);
        if (!beat_wait_.running()) {
            drive_beat();
        }
        return;
    }
    if (lost_wait_.pass()) {
        count(&BusCounters::lost_cycles);
        return;
    }
    if (!bursting_) {
        if (pixels_left_ == 0) {
            count(&BusCounters::idle_cycles);
            ask_for_frame();
            return;
        }
        if (!take_grant()) {
            return;
        }
    }
    const MemoryAnswer& memory = memory_i.read();
    if (memory.miss) {
        ++bus_.page_misses;
        clocked_.stay_awake();
    }
    switch (memory.kind) {
        case MemoryAnswer::Kind::kNone:
            break;
        case MemoryAnswer::Kind::kRead:
            count(&BusCounters::busy_cycles);
            fill_beat(memory.count);
            break;
        case MemoryAnswer::Kind::kOpen:
            count(&BusCounters::page_miss_cycles);
            break;
        case MemoryAnswer::Kind::kRefresh:
            count(&BusCounters::refresh_cycles);
            break;
        case MemoryAnswer::Kind::kWrite:
            count(&BusCounters::write_cycles);
            break;
    }
}

void BusPort::stop_burst() {
    stopped_ = beat_wait_.running();
    bursting_ = false;
    burst_left_ = 0;
    announced_ = 0;
    if (loop_cycles_ > 0) {
        pass_over(row(burst_row_).composer(), loop_cycles_);
    }
}

/// False if no burst starts in this clock.
bool BusPort::take_grant() {
    if (lost_i.read()) {
        count(&BusCounters::lost_cycles);
        lost_wait_.start(lost_slot_cycles_ - 1);
        return false;
    }
    if (plan_.row == kNoRow) {
        count(search_i.read() ? &BusCounters::grant_cycles : &BusCounters::poll_cycles);
        return false;
    }
    bus_.recovered_slots += recovered_i.read();
    if (recovered_i.read() > 0 && !first_recovered_slot_.happened()) {
        first_recovered_slot_.cycle = clock_edge_number(clock_period_picoseconds(scenario_.clocks.core_mhz));
        first_recovered_slot_.display = static_cast<int>(row(plan_.row).composer()) + 1;
    }
    ++bus_.bursts;
    bursting_ = true;
    // The new burst is not judged by what is left of the one before.
    announced_before_ = 0;
    announced_line_.fill(0);
    burst_row_ = plan_.row;
    burst_left_ = static_cast<int>(std::min<std::int64_t>(scenario_.bus.burst_pixels, row(plan_.row).left));
    burst_started_ = false;
    return true;
}

/// Makes the beat of the words that the memory reads in this clock.
void BusPort::fill_beat(int pixels) {
    Row& of_row = row(burst_row_);
    BusBeat beat;
    beat.kind = BusBeat::Kind::kPixels;
    beat.frame = frame_on_bus();
    beat.destination = of_row.segment.row().dcomp;
    beat.count = static_cast<std::uint8_t>(pixels);
    beat.first = static_cast<std::uint32_t>(of_row.segment.pixels() - of_row.left);
    beat_ = beat;
    of_row.advance(pixels);
    burst_left_ -= pixels;
    pixels_left_ -= pixels;
    bus_.pixels_sent += pixels;
    const auto line = static_cast<std::size_t>(burst_row_.value());
    if (of_row.left == 0) {
        pending_o[line].write(false);
    } else {
        drive_deadline(line);
    }
    beat_wait_.start(cycles_per_beat_ - 1);
    if (!beat_wait_.running()) {
        drive_beat();
    }
}

void BusPort::drive_beat() {
    sent_ = beat_;
    sent_.remaining = static_cast<std::uint32_t>(burst_left_);
    announced_ = burst_left_;
    if (burst_left_ == 0) {
        // If this was not the only beat, those before it have said how much follows, and without a loop the composer
        // has answered.
        if (!burst_started_ || stopped_ || loop_cycles_ > 0) {
            pass_over(row(burst_row_).composer(), 1 + loop_cycles_);
        }
        stopped_ = false;
        bursting_ = false;
    }
    burst_started_ = true;
}

void BusPort::pass_over(std::size_t composer, int clocks) {
    uncounted_[composer]->start(clocks);
    uncounted_cycles_.start(std::max(uncounted_cycles_.left(), clocks));
}

/// A beat goes out as many clocks after the clock that sent it as its words come after their read.
void BusPort::put_out() {
    if (data_i.read().count > 0) {
        words_ = data_i.read();
    }
    const bool sends = sent_.kind != BusBeat::Kind::kNone;
    if (!sends && !bus_driven_ && leaving_.holds(BusBeat{})) {
        return;
    }
    BusBeat beat = leaving_.shift(sent_);
    if (beat.kind == BusBeat::Kind::kPixels) {
        std::copy_n(words_.value().words.begin(), beat.count, beat.words.begin());
    }
    bus_o.write(beat);
    bus_driven_ = beat.kind != BusBeat::Kind::kNone;
    if (sends) {
        sent_ = BusBeat{};
    }
}

// ---- combinational ----

void BusPort::drive_requests() {
    const bool asks = state_ == State::kSend || closing_;
    if (!asks && !asked_) {
        return;  // in most clocks of a run: the outputs are inactive already
    }
    asked_ = asks;
    plan_ = Plan{};
    if (state_ == State::kSend) {
        drive_ready();
        plan_ = plan();
    }
    plan_.request.close = closing_;
    take_o.write(plan_.arbitrate);
    memory_o.write(plan_.request);
}

void BusPort::drive_ready() {
    for (int index = 0; index < row_count_; ++index) {
        const std::size_t composer = row(index).composer();
        ready_o[static_cast<std::size_t>(index)].write(!uncounted_[composer]->running() &&
                                                       busready_i[composer].read());
    }
}

void BusPort::drive_deadline(std::size_t line) {
    if (deadline_o.size() > 0) {
        const Row& of_row = *rows_[line];
        deadline_o[line].write(
            static_cast<std::uint64_t>(of_row.segment.first_use(of_row.segment.pixels() - of_row.left)));
    }
}

/// A low BUSREADY stops a burst, unless it answers whether a further slot would be taken. That is what a composer
/// answers once the rest of the burst fits one beat.
bool BusPort::burst_is_stopped() const {
    return bursting_ && announced_before_ > pixels_per_beat_ &&
           !busready_i[row(burst_row_).composer()].read();
}

int BusPort::granted_row() const {
    if (grant_valid_i.read()) {
        for (int index = 0; index < row_count_; ++index) {
            if (grant_i[static_cast<std::size_t>(index)].read()) {
                return index;
            }
        }
    }
    return kNoRow;
}

BusPort::Plan BusPort::plan() const {
    Plan plan;
    plan.stop = burst_is_stopped();
    plan.request.give_up = plan.stop;
    if (beat_wait_.running() || lost_wait_.running()) {
        return plan;
    }
    if (bursting_ && !plan.stop) {
        plan.row = burst_row_;
    } else if (pixels_left_ > 0) {
        plan.arbitrate = true;
        plan.row = granted_row();
    }
    if (plan.row != kNoRow) {
        ask_for_words(plan);
    }
    return plan;
}

/// As many as fit one beat.
void BusPort::ask_for_words(Plan& plan) const {
    const Row& of_row = row(plan.row);
    const std::int64_t in_burst = plan.arbitrate
                                      ? std::min<std::int64_t>(scenario_.bus.burst_pixels, of_row.left)
                                      : burst_left_.value();
    const auto most = static_cast<std::uint8_t>(std::min<std::int64_t>(pixels_per_beat_, in_burst));
    while (plan.request.count < most) {
        plan.request.addresses[plan.request.count] =
            static_cast<std::uint32_t>(of_row.address_of(plan.request.count));
        ++plan.request.count;
    }
}

void BusPort::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

std::string BusPort::waiting_for() const {
    const std::int64_t frame = frames_started_ - 1;
    switch (state_) {
        case State::kRequest:
        case State::kWait:
            return waits::for_pair(frames_started_);
        case State::kTable:
            return table_started_ ? "" : waits::for_tableready(frame);
        case State::kSend: {
            if (lost_wait_.running()) {
                return waits::for_lost_slot();
            }
            switch (memory_i.read().kind) {
                case MemoryAnswer::Kind::kOpen:
                    return waits::for_memory_page();
                case MemoryAnswer::Kind::kRefresh:
                    return waits::for_memory_refresh();
                case MemoryAnswer::Kind::kWrite:
                    return waits::for_memory_write();
                default:
                    break;
            }
            std::vector<int> displays;
            for (int index = 0; index < row_count_; ++index) {
                if (row(index).left > 0) {
                    displays.push_back(row(index).segment.row().dcomp);
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
