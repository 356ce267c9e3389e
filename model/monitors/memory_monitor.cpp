#include "monitors/memory_monitor.h"

#include <algorithm>
#include <numeric>
#include <sstream>

namespace metabuffer::monitors {
namespace {

using Kind = rtl::MemoryCommand::Kind;

std::string text_of(const rtl::MemoryCommand& command) {
    std::ostringstream text;
    text << '"' << command << '"';
    return text.str();
}

}  // namespace

MemoryMonitor::MemoryMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                             ViolationLog& log)
    : sc_core::sc_module(name),
      write_data_i("write_data_i", scenario.memory.shared() ? 1 : 0),
      memory_("frame_memory_" + std::to_string(renderer + 1) + '.'),
      config_(scenario.memory),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      reporter_(log),
      banks_(static_cast<std::size_t>(scenario.memory.banks)),
      due_(static_cast<std::size_t>(scenario.memory.read_latency_cycles)) {
    const Renderer& source = scenario.renderers[static_cast<std::size_t>(renderer)];
    const std::int64_t words = source.image_words();
    for (std::vector<std::uint64_t>& device : devices_) {
        device.resize(static_cast<std::size_t>(words));
    }
    device_words_ = config_.device_words(words);
}

void MemoryMonitor::violate(const char* rule, const char* signal, std::int64_t edge,
                            const std::string& detail) {
    reporter_.report(rule, rule, memory_ + signal, edge, RuleReporter::kNoFrame, detail);
}

// ---- the link's side ----

void MemoryMonitor::write_edge() {
    const rtl::MemoryWrite& write = write_i.read();
    if (write.enable) {
        write_clocked_.stay_awake();
        const std::size_t device = write.device & 1U;
        if ((device == 1) == front_i.read()) {
            violate("memory/device", "write", rtl::clock_edge_number(core_period_picoseconds_),
                    "the link writes word " + std::to_string(write.address) +
                        " of the device that the bus reads");
        }
        std::uint64_t& word = devices_[device].at(write.address);
        for (int byte = 0; byte < 8; ++byte) {
            const std::uint64_t bits = std::uint64_t{0xFF} << (8 * byte);
            if (((write.byte_mask >> byte) & 1) != 0) word = (word & ~bits) | (write.data & bits);
        }
        if (config_.shared()) {
            await_word(write);
        }
    }
}

/// When a block begins, words before it that are not a whole block are dropped: their frame has ended early.
void MemoryMonitor::await_word(const rtl::MemoryWrite& write) {
    const auto block_words = static_cast<std::uint32_t>(config_.write_block_words);
    if (write.address % block_words == 0) {
        awaited_.resize(std::accumulate(whole_blocks_.begin(), whole_blocks_.end(), std::size_t{0}));
        if (whole_blocks_.size() > 1) {
            violate("memory/write", "write", rtl::clock_edge_number(core_period_picoseconds_),
                    "a block begins with word " + std::to_string(write.address) +
                        " while two wait to be written");
        }
    }
    awaited_.push_back({write.device * device_words_ + write.address, write.byte_mask, write.data});
    if ((write.address + 1) % block_words == 0 || write.address + 1 == devices_[0].size()) {
        whole_blocks_.push_back(write.address % block_words + 1);
    }
}

// ---- the bus's side ----

void MemoryMonitor::restart() {
    awaited_.clear();
    whole_blocks_.clear();
    std::fill(banks_.begin(), banks_.end(), Bank{});
    std::fill(due_.begin(), due_.end(), rtl::MemoryData{});
    first_edge_ = refreshed_until_ = kNone;
}

void MemoryMonitor::clock_edge() {
    if (reset_i.read()) {
        clocked_.stay_awake();
        restart();
        return;
    }
    const std::int64_t edge = rtl::clock_edge_number(core_period_picoseconds_);
    if (first_edge_ == kNone) {
        first_edge_ = edge;
    }
    const rtl::MemoryCommand& command = command_i.read();
    due_.push_back(words_of(command));
    check_data(due_.front(), edge);
    due_.pop_front();
    check_refresh(command, edge);
    take_command(command, edge);
    const bool idle =
        command.kind == Kind::kNone && !config_.refreshes() && data_i.read().count == 0 &&
        std::all_of(due_.begin(), due_.end(), [](const rtl::MemoryData& words) { return words.count == 0; });
    if (!idle) {
        clocked_.stay_awake();
    }
}

rtl::MemoryData MemoryMonitor::words_of(const rtl::MemoryCommand& command) const {
    rtl::MemoryData words;
    if (command.kind != Kind::kRead) {
        return words;
    }
    const std::vector<std::uint64_t>& device = devices_[front_i.read() ? 1 : 0];
    const std::int64_t first_word = config_.shared() && front_i.read() ? device_words_ : std::int64_t{0};
    for (std::size_t word = 0; word < command.count; ++word) {
        const auto address = static_cast<std::size_t>(std::int64_t{command.row} * config_.page_words +
                                                      command.columns[word] - first_word);
        words.words[words.count++] = address < device.size() ? device[address] : 0;
    }
    return words;
}

void MemoryMonitor::check_data(const rtl::MemoryData& wanted, std::int64_t edge) {
    const rtl::MemoryData& data = data_i.read();
    words_read_ += data.count;
    if (data.count != wanted.count) {
        violate("memory/data", "data", edge,
                std::to_string(int{data.count}) + " words, not " + std::to_string(int{wanted.count}));
    } else if (!(data == wanted)) {
        violate("memory/data", "data", edge, "words that were not written there");
    }
}

void MemoryMonitor::close_all(std::int64_t edge) {
    std::fill(banks_.begin(), banks_.end(), Bank{kNone, edge, kNone});
}

void MemoryMonitor::take_command(const rtl::MemoryCommand& command, std::int64_t edge) {
    switch (command.kind) {
        case Kind::kNone:
            return;
        case Kind::kActivate:
            check_activate(command, edge);
            bank_of(command).page = command.row;
            bank_of(command).activated_at = edge;
            return;
        case Kind::kRead:
            check_open(command, edge);
            bank_of(command).page = command.row;
            return;
        case Kind::kWrite:
            check_open(command, edge);
            bank_of(command).page = command.row;
            check_write(command, edge);
            return;
        case Kind::kPrecharge:
            bank_of(command) = {kNone, edge, kNone};
            return;
        case Kind::kPrechargeAll:
            close_all(edge);
            return;
        case Kind::kRefresh:
            close_all(kNone);  // in its own clocks
            return;
    }
}

void MemoryMonitor::check_refresh(const rtl::MemoryCommand& command, std::int64_t edge) {
    const bool refreshes = command.kind == Kind::kRefresh;
    const std::int64_t since = edge - first_edge_;
    const bool due = config_.refreshes() && since > 0 && since % config_.refresh_interval_cycles == 0;
    if (refreshes != due) {
        violate("memory/refresh", "command", edge,
                due ? "no refresh at the clock in which one is due" : "a refresh that is not due");
    }
    if (edge < refreshed_until_ && command.kind != Kind::kNone) {
        violate("memory/refresh", "command", edge, text_of(command) + " while a refresh is under way");
    }
    if (refreshes) {
        refreshed_until_ = edge + config_.refresh_cycles;
    }
}

void MemoryMonitor::check_activate(const rtl::MemoryCommand& command, std::int64_t edge) {
    const Bank& bank = bank_of(command);
    if (command.row % banks_.size() != command.bank) {
        violate("memory/activate", "command", edge, text_of(command) + ": the page lies in another bank");
    } else if (config_.precharge_cycles > 0 && bank.page != kNone) {
        violate("memory/activate", "command", edge,
                text_of(command) + " while page " + std::to_string(bank.page) + " is open");
    } else {
        check_closed("memory/activate", command, edge);
    }
}

/// The bank is not closing any more.
void MemoryMonitor::check_closed(const char* rule, const rtl::MemoryCommand& command, std::int64_t edge) {
    const Bank& bank = bank_of(command);
    if (bank.closed_at != kNone && edge < bank.closed_at + config_.precharge_cycles) {
        violate(rule, "command", edge,
                text_of(command) + " " + std::to_string(edge - bank.closed_at) +
                    " clocks after the bank's precharge");
    }
}

void MemoryMonitor::check_open(const rtl::MemoryCommand& command, std::int64_t edge) {
    const Bank& bank = bank_of(command);
    const bool opens_itself =
        config_.activate_cycles() == 0 && (config_.precharge_cycles == 0 || bank.page == kNone);
    if (bank.page != command.row && !opens_itself) {
        violate("memory/open", "command", edge,
                text_of(command) + (bank.page == kNone
                                        ? " of a bank with no page open"
                                        : " while page " + std::to_string(bank.page) + " is open"));
    }
    if (config_.times_banks() && bank.activated_at != kNone &&
        edge < bank.activated_at + config_.activate_cycles()) {
        violate("memory/timing", "command", edge,
                text_of(command) + " " + std::to_string(edge - bank.activated_at) +
                    " clocks after its page's activate");
    }
    if (opens_itself) {
        check_closed("memory/timing", command, edge);
    }
}

void MemoryMonitor::check_write(const rtl::MemoryCommand& command, std::int64_t edge) {
    for (std::size_t word = 0; word < command.count; ++word) {
        const std::int64_t address = std::int64_t{command.row} * config_.page_words + command.columns[word];
        const std::string what = "word " + std::to_string(address) + " is written, ";
        if ((address >= device_words_) == front_i.read()) {
            violate("memory/write", "command", edge, what + "in the image that is read");
        }
        if (whole_blocks_.empty()) {
            violate("memory/write", "command", edge, what + "and no whole block waits");
            return;
        }
        const Awaited next = awaited_.front();
        awaited_.pop_front();
        if (--whole_blocks_.front() == 0) whole_blocks_.pop_front();
        if (address != next.address || command.byte_mask != next.byte_mask) {
            violate("memory/write", "command", edge,
                    what + "where word " + std::to_string(next.address) + " is next");
        } else if (write_data_i[0].read().words[word] != next.data) {
            violate("memory/write", "write_data", edge, what + "but not as the link brought it");
        }
    }
}

}  // namespace metabuffer::monitors
