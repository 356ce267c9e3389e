#include "rtl/bus_port.h"

#include <algorithm>
#include <utility>

#include "datapath/arbitration/arbitration_table.h"
#include "report/waits.h"
#include "rtl/wires.h"
#include "rtl/write_buffer.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
namespace {

int divide_up(int value, int divisor) { return (value + divisor - 1) / divisor; }

}  // namespace

BusPort::Row::Row(RegisterSet& set, const std::string& name, const Renderer& renderer,
                  std::int64_t memory_words)
    : left(set, name + "_left", bits_for(renderer.image_words())),
      address(set, name + "_address", bits_for(memory_words)),
      column(set, name + "_column", bits_for(renderer.image_width_pixels)) {}

BusPort::Writes::Half::Half(RegisterSet& set, std::size_t number)
    : full(set, numbered("write_full", number)),
      seen(set, numbered("write_full", number) + "_seen"),
      waiting(set, numbered("write_waiting", number)) {}

BusPort::Writes::Writes(RegisterSet& set, const MemoryConfig& memory)
    : drain(set, "drain"),
      words_left(set, "write_words_left", bits_for(memory.write_block_words)),
      page_wait(set, "write_page_wait", bits_for(memory.page_miss_cycles)),
      precharging(set, "write_precharging") {
    for (std::size_t half = 0; half < WriteBuffer::kHalves; ++half) {
        halves.push_back(std::make_unique<Half>(set, half));
    }
}

BusPort::BusPort(const sc_core::sc_module_name& name, const Scenario& scenario, const Renderer& renderer,
                 std::function<void(bool fresh)> on_start, BusCounters& bus)
    : Block(name),
      front_i("front_i", scenario.memory.shared() ? 1 : 0),
      write_full_i("write_full_i", scenario.memory.shared() ? WriteBuffer::kHalves : 0),
      write_block_i("write_block_i", write_full_i.size()),
      drain_o("drain_o", front_i.size()),
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
      table_wait_(registers_, "table_wait", bits_for(cycles_per_table_row_)),
      burst_row_(registers_, "burst_row", bits_for(scenario.displays.count() - 1)),
      burst_left_(registers_, "burst_left", bits_for(scenario.bus.burst_pixels)),
      page_wait_(registers_, "page_wait", bits_for(scenario.memory.page_miss_cycles)),
      beat_wait_(registers_, "beat_wait", bits_for(cycles_per_beat_)),
      lost_wait_(registers_, "lost_wait", bits_for(lost_slot_cycles_)),
      announced_(registers_, "announced", bits_for(scenario.bus.burst_pixels)),
      announced_before_(registers_, "announced_before", bits_for(scenario.bus.burst_pixels)),
      announced_line_(registers_, "announced_before", loop_cycles_, bits_for(scenario.bus.burst_pixels)),
      uncounted_cycles_(registers_, "uncounted_cycles", bits_for(1 + loop_cycles_)),
      table_uncounted_cycles_(registers_, "table_uncounted_cycles", bits_for(2 + loop_cycles_)),
      refresh_due_in_(registers_, "refresh_due_in", bits_for(scenario.memory.refresh_interval_cycles),
                      scenario.memory.refresh_interval_cycles),
      refresh_left_(registers_, "refresh_left", bits_for(scenario.memory.refresh_cycles)),
      words_(registers_, "words", pixels_per_beat_),
      leaving_(registers_, "leaving", scenario.memory.read_latency_cycles, 0) {
    const std::int64_t memory_words = scenario.memory.memory_words(renderer.image_words());
    for (std::size_t line = 0; line < busready_i.size(); ++line) {
        rows_.push_back(std::make_unique<Row>(registers_, numbered("row", line), renderer, memory_words));
        uncounted_.push_back(std::make_unique<Register<int>>(registers_, numbered("uncounted", line),
                                                             bits_for(1 + loop_cycles_)));
    }
    for (int bank = 0; bank < scenario.memory.banks; ++bank) {
        banks_.push_back(std::make_unique<Bank>(registers_, "bank_" + std::to_string(bank),
                                                bits_for((memory_words - 1) / scenario.memory.page_words)));
    }
    if (scenario.memory.shared()) {
        writes_ = std::make_unique<Writes>(registers_, scenario.memory);
    }
    SC_METHOD(drive_requests);
    sensitive << grant_valid_i << lost_i << registers_.changed_event();
    for (std::size_t line = 0; line < busready_i.size(); ++line) {
        sensitive << busready_i[line] << grant_i[line];
    }
    dont_initialize();
}

void BusPort::reset() {
    count_sleep();
    registers_.reset();
    request_o.write(false);
    start_o.write(false);
    for (auto& pending : pending_o) {
        pending.write(false);
    }
    for (auto& drain : drain_o) {
        drain.write(false);
    }
    bus_o.write(BusBeat{});
    bus_driven_ = false;
    count(&BusCounters::idle_cycles);
}

void BusPort::clock_edge() {
    count_sleep();
    const bool answer = answer_.sample(answer_i.read());
    count_answers();
    if (writes_ != nullptr) {
        sample_writes();
    }
    switch (state_) {
        case State::kRequest:
            count(&BusCounters::idle_cycles);
            ask_for_frame();
            break;
        case State::kWait:
            closing_ = false;
            count(&BusCounters::idle_cycles);
            if (answer != answer_seen_) {
                answer_seen_ = answer;
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
    if (writes_ != nullptr) {
        write_clock();
    }
    if (scenario_.memory.refreshes()) {
        refresh_clock();
    }
    put_out();
}

void BusPort::sample_writes() {
    for (std::size_t half = 0; half < WriteBuffer::kHalves; ++half) {
        Writes::Half& of_half = *writes_->halves[half];
        const bool full = of_half.full.sample(write_full_i[half].read());
        if (full != of_half.seen) {
            of_half.seen = full;
            of_half.waiting = true;
        }
    }
}

/// Called after the burst's part of the clock: if that stops a burst, its bank is already in the state that the block
/// finds.
void BusPort::write_clock() {
    if (!plan_.writes) {
        return;
    }
    Writes& writes = *writes_;
    const MemoryCommand& command = plan_.command;
    if (writes.words_left == 0) {
        writes.words_left = static_cast<int>(write_block_i[writes.turn()].read().words);
        writes.page_wait = plan_.opening.cycles;
        writes.precharging = command.kind == MemoryCommand::Kind::kPrecharge;
        note_open(write_page());
    }
    if (writes.page_wait > 0) {
        --writes.page_wait;
        writes.precharging = writes.precharging && command.kind != MemoryCommand::Kind::kActivate;
        return;
    }
    writes.words_left -= command.count;
    if (writes.words_left == 0) {
        writes.half().waiting = false;
        writes.drain = !writes.drain;
        drain_o[0].write(writes.drain);
    }
}

/// Counts the clocks until the composers' answers count what they were sent.
void BusPort::count_answers() {
    if (table_uncounted_cycles_ > 0) {
        --table_uncounted_cycles_;
    }
    if (uncounted_cycles_ == 0) {
        return;
    }
    --uncounted_cycles_;
    for (const auto& uncounted : uncounted_) {
        if (*uncounted > 0) {
            --*uncounted;
        }
    }
}

/// Called last in a clock: if a refresh begins, a burst stopped in this clock must not leave a bank half open.
void BusPort::refresh_clock() {
    if (refresh_left_ > 0) {
        --refresh_left_;
    }
    if (refresh_due_in_ > 0) {
        --refresh_due_in_;
        return;
    }
    close_banks();
    page_wait_ = 0;
    precharging_ = false;
    refresh_left_ = scenario_.memory.refresh_cycles - 1;
    refresh_due_in_ = scenario_.memory.refresh_interval_cycles - 1;
}

void BusPort::close_banks() {
    for (const auto& bank : banks_) {
        bank->open = false;
        bank->half_open = false;
    }
}

/// Notes the page that the memory's bank has open once it has obeyed.
void BusPort::note_open(std::int64_t page) {
    Bank& bank = bank_of(page);
    bank.open = true;
    bank.half_open = false;
    bank.page = page;
}

void BusPort::ask_for_frame() {
    if (frames_started_ == scenario_.frames) {
        state_ = State::kDone;
        return;
    }
    if (writes_ == nullptr) {
        close_banks();
        closing_ = true;
    }
    request_ = !request_;
    request_o.write(request_);
    state_ = State::kWait;
}

void BusPort::start_frame(bool fresh) {
    ++frames_started_;
    on_start_(fresh);
    const FrontTable& table = table_i.read();
    const bool second_image = writes_ != nullptr && front_i[0].read();
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
    table_wait_ = cycles_per_table_row_;
    state_ = State::kTable;
}

bool BusPort::composers_take_table() const {
    return std::all_of(tableready_i.begin(), tableready_i.end(),
                       [](const sc_core::sc_in<bool>& tableready) { return tableready.read(); });
}

void BusPort::table_clock() {
    if (!table_started_) {
        if (table_uncounted_cycles_ > 0 || !composers_take_table()) {
            count(&BusCounters::poll_cycles);
            return;
        }
        table_started_ = true;
        sent_ = BusBeat::frame_start(frame_on_bus(), row_count_ == 0);
        if (loop_cycles_ > 0) {
            table_uncounted_cycles_ = 2 + loop_cycles_;  // without a loop, asking for a pair takes longer
        }
    } else {
        --table_wait_;
        if (table_wait_ == 0) {
            const int place = table_row_;
            ++table_row_;
            sent_ = BusBeat::table_row(frame_on_bus(), static_cast<std::uint32_t>(place),
                                       row(place).segment.row(), table_row_ == row_count_);
            table_wait_ = cycles_per_table_row_;
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
    if (beat_wait_ > 0) {
        count(&BusCounters::busy_cycles);
        --beat_wait_;
        if (beat_wait_ == 0) {
            drive_beat();
        }
        return;
    }
    if (lost_wait_ > 0) {
        count(&BusCounters::lost_cycles);
        --lost_wait_;
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
    if (plan_.refreshes) {
        count(&BusCounters::refresh_cycles);
        return;
    }
    if (plan_.writes) {
        count(&BusCounters::write_cycles);
        return;
    }
    if (!page_ready(plan_)) {
        count(&BusCounters::page_miss_cycles);
        return;
    }
    count(&BusCounters::busy_cycles);
    fill_beat(plan_);
    beat_wait_ = cycles_per_beat_ - 1;
    if (beat_wait_ == 0) {
        drive_beat();
    }
}

void BusPort::stop_burst() {
    stopped_ = beat_wait_ > 0;
    bursting_ = false;
    burst_left_ = 0;
    if (breaks_opening_off()) {
        bank_of(page_of(row(burst_row_))).half_open = true;
    }
    page_wait_ = 0;
    announced_ = 0;
    if (loop_cycles_ > 0) {
        pass_over(row(burst_row_).composer(), loop_cycles_);
    }
}

/// False if no burst starts in this clock.
bool BusPort::take_grant() {
    if (lost_i.read()) {
        count(&BusCounters::lost_cycles);
        lost_wait_ = lost_slot_cycles_ - 1;
        return false;
    }
    if (plan_.row == kNoRow) {
        count(search_i.read() ? &BusCounters::grant_cycles : &BusCounters::poll_cycles);
        return false;
    }
    bus_.recovered_slots += recovered_i.read();
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

/// False while the page of the next word is being opened.
bool BusPort::page_ready(const Plan& plan) {
    if (page_wait_ > 0) {
        --page_wait_;
        if (plan.command.kind == MemoryCommand::Kind::kActivate) {
            precharging_ = false;
        }
        return false;
    }
    if (!plan.opening.opens) {
        return true;
    }
    precharging_ = plan.command.kind == MemoryCommand::Kind::kPrecharge;
    note_open(page_of(row(burst_row_)));
    ++bus_.page_misses;
    if (plan.opening.cycles == 0) {
        return true;
    }
    page_wait_ = plan.opening.cycles - 1;
    return false;
}

/// Makes the beat of the words that the memory reads by this clock's command.
void BusPort::fill_beat(const Plan& plan) {
    Row& of_row = row(burst_row_);
    const int count = plan.command.count;
    BusBeat beat;
    beat.kind = BusBeat::Kind::kPixels;
    beat.frame = frame_on_bus();
    beat.destination = of_row.segment.row().dcomp;
    beat.count = plan.command.count;
    beat.first = static_cast<std::uint32_t>(of_row.segment.pixels() - of_row.left);
    beat_ = beat;
    of_row.left -= count;
    of_row.address = plan.next_address;
    of_row.column = plan.next_column;
    burst_left_ -= count;
    pixels_left_ -= count;
    bus_.pixels_sent += count;
    const auto line = static_cast<std::size_t>(burst_row_.value());
    if (of_row.left == 0) {
        pending_o[line].write(false);
    } else {
        drive_deadline(line);
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
    *uncounted_[composer] = clocks;
    uncounted_cycles_ = std::max(uncounted_cycles_.value(), clocks);
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
    const bool refresh = refresh_begins();
    const bool writes = writes_ != nullptr && writes_->any();
    const bool asks = state_ == State::kSend || closing_ || refresh || writes;
    if (!asks && !asked_) {
        return;  // in most clocks of a run: the outputs are inactive already
    }
    asked_ = asks;
    plan_ = Plan{};
    if (state_ == State::kSend) {
        drive_ready();
        plan_ = plan();
    } else {
        plan_.writes = plan_writes(plan_);
        if (closing_ && refresh_left_ == 0) {
            plan_.command.kind = MemoryCommand::Kind::kPrechargeAll;  // each frame starts with no page open
        }
    }
    if (plan_.writes) {
        plan_write_command(plan_);
    }
    if (refresh) {
        plan_.command = MemoryCommand{};
        plan_.command.kind = MemoryCommand::Kind::kRefresh;
    }
    take_o.write(plan_.arbitrate);
    command_o.write(plan_.command);
}

/// A composer whose BUSREADY cannot yet count what it was sent last is passed over.
void BusPort::drive_ready() {
    for (int index = 0; index < row_count_; ++index) {
        const std::size_t composer = row(index).composer();
        ready_o[static_cast<std::size_t>(index)].write(*uncounted_[composer] == 0 &&
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
    plan.refreshes = refresh_begins() || refresh_left_ > 0;
    plan.writes = plan_writes(plan);
    if (beat_wait_ > 0 || lost_wait_ > 0) {
        return plan;
    }
    if (bursting_ && !plan.stop) {
        plan.row = burst_row_;
        if (page_wait_ > 0 && !plan.refreshes) {
            if (precharging_ && page_wait_ == scenario_.memory.activate_cycles()) {
                plan.command = command_for(MemoryCommand::Kind::kActivate, page_of(row(burst_row_)));
            }
            return plan;
        }
    } else if (pixels_left_ > 0) {
        plan.arbitrate = true;
        plan.row = granted_row();
    }
    if (plan.row != kNoRow && !plan.refreshes && !plan.writes) {
        plan_memory(plan);
    }
    return plan;
}

MemoryCommand BusPort::command_for(MemoryCommand::Kind kind, std::int64_t page) const {
    MemoryCommand command;
    command.kind = kind;
    command.bank = static_cast<std::uint8_t>(static_cast<std::size_t>(page) % banks_.size());
    command.row = static_cast<std::uint32_t>(page);
    return command;
}

/// stop: the burst under way is stopped in this clock, and may leave its bank half open.
BusPort::Opening BusPort::opening_of(std::int64_t page, bool stop) const {
    const Bank& bank = bank_of(page);
    const bool half_open =
        bank.half_open || (stop && breaks_opening_off() && &bank == &bank_of(page_of(row(burst_row_))));
    Opening opening;
    opening.opens = !bank.open || half_open || bank.page != page;
    opening.closes = bank.open && scenario_.memory.precharge_cycles > 0;
    opening.cycles = opening.opens ? scenario_.memory.opening_cycles(bank.open) : 0;
    return opening;
}

MemoryCommand BusPort::opening_command(const Opening& opening, std::int64_t page) const {
    return command_for(opening.closes ? MemoryCommand::Kind::kPrecharge : MemoryCommand::Kind::kActivate,
                       page);
}

/// True if the memory uses this clock for the link's words.
bool BusPort::plan_writes(const Plan& plan) const {
    if (writes_ == nullptr || refresh_begins() || refresh_left_ > 0 || !writes_->any()) {
        return false;
    }
    if (writes_->words_left > 0) {
        return true;
    }
    if (page_wait_ > 0 && !plan.stop) {
        return false;  // a page is being opened
    }
    const MemoryConfig& memory = scenario_.memory;
    const int words = static_cast<int>(write_block_i[writes_->turn()].read().words);
    return !memory.refreshes() ||
           opening_of(write_page(), plan.stop).cycles + memory.write_cycles(words) <= refresh_due_in_;
}

/// Plans to write the next words of the block, or to open the page that they need.
void BusPort::plan_write_command(Plan& plan) const {
    const Writes& writes = *writes_;
    const WriteBlock& block = write_block_i[writes.turn()].read();
    const std::int64_t page = write_page();
    const bool begins = writes.words_left == 0;
    plan.opening = begins ? opening_of(page, plan.stop) : Opening{};
    if (plan.opening.cycles > 0) {
        plan.command = opening_command(plan.opening, page);
        return;
    }
    if (writes.page_wait > 0) {
        if (writes.precharging && writes.page_wait == scenario_.memory.activate_cycles()) {
            plan.command = command_for(MemoryCommand::Kind::kActivate, page);
        }
        return;
    }
    const auto words_left = begins ? static_cast<int>(block.words) : writes.words_left.value();
    const std::int64_t first = static_cast<std::int64_t>(block.address) + block.words - words_left -
                               page * scenario_.memory.page_words;
    plan.command = command_for(MemoryCommand::Kind::kWrite, page);
    plan.command.byte_mask = block.byte_mask;
    plan.command.count = static_cast<std::uint8_t>(std::min(words_left, scenario_.memory.words_per_cycle));
    for (std::size_t word = 0; word < plan.command.count; ++word) {
        plan.command.columns[word] = static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(word);
    }
}

/// Plans to read the next words of the open page, as many as fit one beat, or to open the page that they need.
void BusPort::plan_memory(Plan& plan) const {
    const Row& of_row = row(plan.row);
    const int page_words = scenario_.memory.page_words;
    const int width = of_row.segment.row().sdx;
    const std::int64_t page = page_of(of_row);
    plan.opening = opening_of(page, plan.stop);
    if (plan.opening.cycles > 0) {
        plan.command = opening_command(plan.opening, page);
        return;
    }
    plan.command = command_for(MemoryCommand::Kind::kRead, page);
    const std::int64_t in_burst = plan.arbitrate
                                      ? std::min<std::int64_t>(scenario_.bus.burst_pixels, of_row.left)
                                      : burst_left_.value();
    const std::int64_t page_start = page * page_words;
    const auto most = static_cast<int>(std::min<std::int64_t>(pixels_per_beat_, in_burst));
    plan.next_address = of_row.address;
    plan.next_column = of_row.column;
    do {
        plan.command.columns[plan.command.count++] =
            static_cast<std::uint32_t>(plan.next_address - page_start);
        ++plan.next_address;
        if (++plan.next_column == width) {
            plan.next_column = 0;
            plan.next_address += renderer_.image_width_pixels - width;
        }
    } while (plan.command.count < most && plan.next_address < page_start + page_words);
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
            if (page_wait_ > 0) {
                return waits::for_memory_page();
            }
            if (lost_wait_ > 0) {
                return waits::for_lost_slot();
            }
            if (bursting_ && refresh_left_ > 0) {
                return waits::for_memory_refresh();
            }
            if (bursting_ && plan_.writes) {
                return waits::for_memory_write();
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
