#include "rtl/memory_controller.h"

#include <algorithm>

#include "rtl/wires.h"
#include "rtl/write_buffer.h"

namespace metabuffer::rtl {

MemoryController::Writes::Half::Half(RegisterSet& set, std::size_t number)
    : full(set, numbered("write_full", number)), waiting(set, numbered("write_waiting", number)) {}

MemoryController::Writes::Writes(RegisterSet& set, const MemoryConfig& memory)
    : drain(set, "drain"), words_left(set, "write_words_left", bits_for(memory.write_block_words)) {
    for (std::size_t half = 0; half < WriteBuffer::kHalves; ++half) {
        halves.push_back(std::make_unique<Half>(set, half));
    }
}

MemoryController::MemoryController(const sc_core::sc_module_name& name, const MemoryConfig& config,
                                   std::int64_t image_words)
    : Block(name),
      write_full_i("write_full_i", config.shared() ? WriteBuffer::kHalves : 0),
      write_block_i("write_block_i", write_full_i.size()),
      drain_o("drain_o", config.shared() ? 1 : 0),
      config_(config),
      address_bits_(bits_for(config.memory_words(image_words) - 1)),
      page_wait_(registers_, "page_wait", config.page_miss_cycles),
      opening_(registers_, "opening", bits_for((config.memory_words(image_words) - 1) / config.page_words)),
      refresh_due_in_(registers_, "refresh_due_in", config.refresh_interval_cycles,
                      config.refresh_interval_cycles),
      refresh_left_(registers_, "refresh_left", config.refresh_cycles) {
    for (int bank = 0; bank < config.banks; ++bank) {
        banks_.push_back(
            std::make_unique<Bank>(registers_, "bank_" + std::to_string(bank),
                                   bits_for((config.memory_words(image_words) - 1) / config.page_words)));
    }
    if (config.shared()) {
        writes_ = std::make_unique<Writes>(registers_, config);
    }
    clocked_.evaluates(&MemoryController::answer, {request_i});
}

void MemoryController::reset() {
    registers_.reset();
    for (auto& drain : drain_o) {
        drain.write(false);
    }
}

void MemoryController::clock_edge() {
    if (writes_ != nullptr) {
        sample_writes();
    }
    if (plan_.gives_up) {
        bank_of(opening_).half_open = config_.times_banks();
        page_wait_.start(0);
        precharging_ = false;
    }
    switch (plan_.use) {
        case MemoryAnswer::Kind::kWrite:
            if (writes_->words_left == 0) {
                writes_->words_left = static_cast<int>(block().words);
            }
            open_page();
            count_written();
            break;
        case MemoryAnswer::Kind::kOpen:
        case MemoryAnswer::Kind::kRead:
            open_page();
            break;
        case MemoryAnswer::Kind::kNone:
            if (request_i.read().close) {
                close_banks();
            }
            break;
        case MemoryAnswer::Kind::kRefresh:
            break;
    }
    if (config_.refreshes()) {
        count_refresh();
    }
}

void MemoryController::sample_writes() {
    for (std::size_t half = 0; half < WriteBuffer::kHalves; ++half) {
        if (writes_->halves[half]->full.arrives(write_full_i[half].read())) {
            writes_->halves[half]->waiting = true;
        }
    }
}

/// A clock of an opening, or none if the page is open.
void MemoryController::open_page() {
    if (page_wait_.pass()) {
        precharging_ = precharging_ && plan_.command.kind != MemoryCommand::Kind::kActivate;
        return;
    }
    if (plan_.opening.opens) {
        bank_of(plan_.opening.page).open(plan_.opening.page);
        opening_ = plan_.opening.page;
        precharging_ = plan_.command.kind == MemoryCommand::Kind::kPrecharge;
        page_wait_.start(std::max(0, plan_.opening.cycles - 1));
    }
}

void MemoryController::count_written() {
    if (plan_.command.kind != MemoryCommand::Kind::kWrite) {
        return;
    }
    writes_->words_left -= plan_.command.count;
    if (writes_->words_left == 0) {
        writes_->half().waiting = false;
        writes_->drain = !writes_->drain;
        drain_o[0].write(writes_->drain);
    }
}

/// Called last in a clock: a refresh that begins in it closes what the clock has left open.
void MemoryController::count_refresh() {
    refresh_left_.pass();
    if (refresh_due_in_.pass()) {
        return;
    }
    close_banks();
    page_wait_.start(0);
    precharging_ = false;
    refresh_left_.start(config_.refresh_cycles - 1);
    refresh_due_in_.start(config_.refresh_interval_cycles - 1);
}

void MemoryController::close_banks() {
    for (const auto& bank : banks_) {
        bank->close();
    }
}

// ---- combinational ----

void MemoryController::answer() {
    plan_ = plan();
    MemoryAnswer answer;
    if (request_i.read().count > 0) {
        const bool reads = plan_.use == MemoryAnswer::Kind::kRead;
        answer.kind = plan_.use;
        answer.count = reads ? plan_.command.count : std::uint8_t{0};
        answer.miss = plan_.opening.opens && (reads || plan_.use == MemoryAnswer::Kind::kOpen);
    }
    answer_o.write(answer);
    command_o.write(plan_.command);
}

MemoryController::Plan MemoryController::plan() const {
    const MemoryRequest& request = request_i.read();
    Plan plan;
    plan.gives_up = request.give_up && page_wait_.running() && !write_under_way();
    if (refresh_begins() || refresh_left_.running()) {
        plan.use = MemoryAnswer::Kind::kRefresh;
        if (refresh_begins()) {
            plan.command.kind = MemoryCommand::Kind::kRefresh;
        }
    } else if (write_under_way() || write_begins(plan.gives_up)) {
        plan_write(plan);
    } else if (request.count > 0) {
        plan_read(plan);
    } else if (request.close) {
        plan.command.kind = MemoryCommand::Kind::kPrechargeAll;
    }
    return plan;
}

/// Plans what opens the page. False: it is open, or opens with the access itself.
bool MemoryController::plan_opening(Plan& plan, std::uint32_t page) const {
    if (page_wait_.running() && !plan.gives_up) {
        if (precharging_ && page_wait_.left() == config_.activate_cycles()) {
            plan.command = command_for(MemoryCommand::Kind::kActivate, page);
        }
        return true;
    }
    plan.opening = opening_of(page, plan.gives_up);
    if (plan.opening.cycles == 0) {
        return false;
    }
    plan.command = command_for(
        plan.opening.closes ? MemoryCommand::Kind::kPrecharge : MemoryCommand::Kind::kActivate, page);
    return true;
}

/// gives_up: the opening under way is given up in this clock, and may leave its bank half open.
MemoryController::Opening MemoryController::opening_of(std::uint32_t page, bool gives_up) const {
    const Bank& bank = bank_of(page);
    const bool half_open =
        bank.half_open || (gives_up && config_.times_banks() && &bank == &bank_of(opening_));
    Opening opening;
    opening.page = page;
    opening.opens = half_open || !bank.is_open(page);
    opening.closes = bank.is_open() && config_.precharge_cycles > 0;
    opening.cycles = opening.opens ? config_.opening_cycles(bank.is_open()) : 0;
    return opening;
}

void MemoryController::plan_read(Plan& plan) const {
    const MemoryRequest& request = request_i.read();
    const std::uint32_t page = page_of(request.addresses[0]);
    if (plan_opening(plan, page)) {
        plan.use = MemoryAnswer::Kind::kOpen;
        return;
    }
    plan.use = MemoryAnswer::Kind::kRead;
    MemoryCommand& read = plan.command = command_for(MemoryCommand::Kind::kRead, page);
    while (read.count < request.count && page_of(request.addresses[read.count]) == page) {
        read.columns[read.count] = column_of(request.addresses[read.count]);
        ++read.count;
    }
}

/// False while the block that is next would not end before the next refresh.
bool MemoryController::write_begins(bool gives_up) const {
    if (writes_ == nullptr || !writes_->half().waiting || (page_wait_.running() && !gives_up)) {
        return false;
    }
    return !config_.refreshes() || opening_of(page_of(block().address), gives_up).cycles +
                                           config_.write_cycles(static_cast<int>(block().words)) <=
                                       refresh_due_in_.left();
}

void MemoryController::plan_write(Plan& plan) const {
    const std::uint32_t page = page_of(block().address);
    plan.use = MemoryAnswer::Kind::kWrite;
    if (plan_opening(plan, page)) {
        return;
    }
    const int left = write_under_way() ? writes_->words_left.value() : static_cast<int>(block().words);
    const std::uint32_t first = column_of(block().address) + block().words - static_cast<std::uint32_t>(left);
    MemoryCommand& write = plan.command = command_for(MemoryCommand::Kind::kWrite, page);
    write.byte_mask = block().byte_mask;
    while (write.count < std::min(left, config_.words_per_cycle)) {
        write.columns[write.count] = first + write.count;
        ++write.count;
    }
}

MemoryCommand MemoryController::command_for(MemoryCommand::Kind kind, std::uint32_t page) const {
    MemoryCommand command;
    command.kind = kind;
    command.bank = static_cast<std::uint8_t>(page % banks_.size());
    command.row = page;
    return command;
}

void MemoryController::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, request_i.read(), path("request"), config_.words_per_cycle, address_bits_);
    sc_trace(file, answer_o.read(), path("answer"));
    registers_.trace(file, path(""));
}

}  // namespace metabuffer::rtl
