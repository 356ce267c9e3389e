#include "rtl/frame_memory.h"

#include <algorithm>
#include <sstream>

namespace metabuffer::rtl {
namespace {

/// The bits of a word whose bytes a mask names.
std::uint64_t bits_of(std::uint8_t byte_mask) {
    std::uint64_t bits = 0;
    for (int byte = 0; byte < 8; ++byte) {
        if (((byte_mask >> byte) & 1) != 0) {
            bits |= std::uint64_t{0xFF} << (8 * byte);
        }
    }
    return bits;
}

}  // namespace

FrameMemory::FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config, std::int64_t words)
    : Block(name),
      write_data_i("write_data_i", config.shared() ? 1 : 0),
      config_(config),
      refresh_left_(registers_, "refresh_left", config.refresh_cycles),
      refresh_due_in_(registers_, "refresh_due_in", config.refresh_interval_cycles,
                      config.refresh_interval_cycles),
      reads_(registers_, "read", config.read_latency_cycles, config.words_per_cycle) {
    const std::int64_t device_words = config.memory_words(words);
    for (int bank = 0; bank < config.banks; ++bank) {
        banks_.push_back(std::make_unique<Bank>(
            registers_, "bank_" + std::to_string(bank), bits_for((device_words - 1) / config.page_words),
            config.times_banks() ? std::max(config.precharge_cycles, config.activate_cycles()) : 0));
    }
    clocked_.reads({reset_i, command_i});
    devices_[0].resize(static_cast<std::size_t>(device_words));
    if (!config.shared()) {
        devices_[1].resize(static_cast<std::size_t>(device_words));
        link_clocked_ = std::make_unique<Clocked>(*this, write_clk_i, &FrameMemory::write_edge);
        link_clocked_->reads({write_i});
    }
    if (reads_.empty()) {
        SC_METHOD(put_out);
        sensitive << command_i;
        dont_initialize();
    }
}

// ---- the link's side ----

void FrameMemory::write_edge() {
    const MemoryWrite& write = write_i.read();
    if (write.enable) {
        link_clocked_->stay_awake();
        std::uint64_t& word = devices_[write.device & 1U].at(write.address);
        const std::uint64_t bits = bits_of(write.byte_mask);
        word = (word & ~bits) | (write.data & bits);
    }
}

// ---- the bus's side ----

void FrameMemory::reset() {
    registers_.reset();
    if (!reads_.empty()) {
        data_o.write(MemoryData{});
    }
}

void FrameMemory::core_edge() {
    const MemoryCommand& command = command_i.read();
    if (config_.refreshes()) {
        watch_refresh(command);
    }
    if (config_.times_banks()) {
        pass_clock();
    }
    obey(command);
    if (!reads_.empty()) {
        latency_edge(command);
    }
    if (command.kind != MemoryCommand::Kind::kNone) {
        clocked_.stay_awake();  // each command that breaks a rule is reported
    }
}

void FrameMemory::obey(const MemoryCommand& command) {
    switch (command.kind) {
        case MemoryCommand::Kind::kNone:
            return;
        case MemoryCommand::Kind::kPrecharge:
            bank_of(command).close();
            bank_of(command).keep_busy(config_.precharge_cycles);
            return;
        case MemoryCommand::Kind::kPrechargeAll:
            close_banks(config_.precharge_cycles);
            return;
        case MemoryCommand::Kind::kRefresh:
            refresh(command);
            return;
        case MemoryCommand::Kind::kActivate:
            check_activate(command);
            open(command);
            bank_of(command).keep_busy(config_.activate_cycles());
            return;
        case MemoryCommand::Kind::kRead:
            check_words(command);
            open(command);
            return;
        case MemoryCommand::Kind::kWrite:
            if (!config_.shared()) {
                refuse("ports", command, "its ports are not shared");
                return;
            }
            check_words(command);
            open(command);
            store(command);
            return;
    }
}

/// Counts the clocks of a refresh and those until the next one. A command during the refresh is an error, and so is a
/// refresh that does not come in time.
void FrameMemory::watch_refresh(const MemoryCommand& command) {
    if (refresh_left_.pass()) {
        if (command.kind != MemoryCommand::Kind::kNone) {
            refuse("refresh", command, "a refresh is under way");
        }
    }
    if (!refresh_due_in_.pass() && command.kind != MemoryCommand::Kind::kRefresh) {
        refuse("refresh", command, "a refresh is overdue");
    }
}

void FrameMemory::refresh(const MemoryCommand& command) {
    if (!config_.refreshes()) {
        refuse("refresh", command, "it needs none");
    }
    close_banks(0);  // in the refresh's own clocks
    refresh_left_.start(config_.refresh_cycles - 1);
    refresh_due_in_.start(config_.refresh_interval_cycles - 1);
}

void FrameMemory::close_banks(int clocks) {
    for (const auto& bank : banks_) {
        bank->close();
        bank->keep_busy(clocks);
    }
}

void FrameMemory::pass_clock() {
    for (const auto& bank : banks_) {
        bank->wait->pass();
    }
}

void FrameMemory::open(const MemoryCommand& command) { bank_of(command).open(command.row); }

void FrameMemory::check_timing(const MemoryCommand& command) const {
    const Bank& bank = bank_of(command);
    if (bank.busy()) {
        refuse("timing", command,
               "the bank takes it only " + std::to_string(bank.wait->left()) + " clocks later");
    }
}

void FrameMemory::check_activate(const MemoryCommand& command) const {
    const Bank& bank = bank_of(command);
    if (config_.precharge_cycles > 0 && bank.is_open()) {
        refuse("page", command, "page " + std::to_string(bank.page()) + " is open");
    } else {
        check_timing(command);
    }
    if (command.row % banks_.size() != command.bank) {
        refuse("address", command, "the page lies in bank " + std::to_string(command.row % banks_.size()));
    }
}

void FrameMemory::check_words(const MemoryCommand& command) const {
    const Bank& bank = bank_of(command);
    const bool opens_itself =
        config_.activate_cycles() == 0 && (config_.precharge_cycles == 0 || !bank.is_open());
    if (!opens_itself && !bank.is_open(command.row)) {
        refuse("page", command,
               bank.is_open() ? "page " + std::to_string(bank.page()) + " is open" : "no page is open");
    } else {
        check_timing(command);
    }
    if (command.count > config_.words_per_cycle) {
        refuse("width", command, "it has " + std::to_string(config_.words_per_cycle) + " words a clock");
    }
    for (std::size_t word = 0; word < command.count; ++word) {
        if (command.columns[word] >= static_cast<std::uint32_t>(config_.page_words) ||
            address_of(command, word) >= words()) {
            refuse("address", command,
                   "it has " + std::to_string(words()) + " words in pages of " +
                       std::to_string(config_.page_words));
        }
    }
}

void FrameMemory::store(const MemoryCommand& command) {
    const std::uint64_t bits = bits_of(command.byte_mask);
    const MemoryData& data = write_data_i[0].read();
    for (std::size_t word = 0; word < command.count; ++word) {
        std::uint64_t& stored = devices_[0].at(static_cast<std::size_t>(address_of(command, word)));
        stored = (stored & ~bits) | (data.words[word] & bits);
    }
}

void FrameMemory::refuse(const char* kind, const MemoryCommand& command, const std::string& why) const {
    std::ostringstream line;
    line << name() << " was sent the command \"" << command << "\", but " << why;
    SC_REPORT_ERROR((std::string("/metabuffer/frame_memory/") + kind).c_str(), line.str().c_str());
}

/// The words come before the clock's edge; whether the command is legal is checked only at the edge.
void FrameMemory::put_out() {
    answer(command_i.read(), data_);
    data_o.write(data_);
}

void FrameMemory::answer(const MemoryCommand& command, MemoryData& data) const {
    data.count = 0;
    if (command.kind != MemoryCommand::Kind::kRead) {
        return;
    }
    const std::vector<std::uint64_t>& device = devices_[front_i.read() && !config_.shared() ? 1 : 0];
    data.count = command.count;
    for (std::size_t word = 0; word < command.count; ++word) {
        const auto address = static_cast<std::size_t>(address_of(command, word));
        data.words[word] = address < device.size() ? device[address] : 0;
    }
}

void FrameMemory::latency_edge(const MemoryCommand& command) {
    answer(command, data_);
    reads_.shift(data_);
    data_o.write(reads_.last());
}

void FrameMemory::trace(sc_core::sc_trace_file* file) const {
    registers_.trace(file, path(""));
    sc_trace(file, write_i.read(), path("write"), bits_for(words() - 1));
    sc_core::sc_trace(file, front_i.port(), path("front"));
    sc_trace(file, command_i.read(), path("command"), bits_for((words() - 1) / config_.page_words),
             config_.words_per_cycle, bits_for(config_.page_words - 1));
    sc_trace(file, data_o.read(), path("data"), config_.words_per_cycle);
}

}  // namespace metabuffer::rtl
