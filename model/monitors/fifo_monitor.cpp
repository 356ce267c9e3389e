#include "monitors/fifo_monitor.h"

#include "datapath/composer_buffer.h"

namespace metabuffer::monitors {

FifoMonitor::FifoMonitor(const sc_core::sc_module_name& name, const Scenario& scenario,
                         const std::string& composer, ViolationLog& log)
    : sc_core::sc_module(name),
      fifo_(composer + ".fifo."),
      capacity_(static_cast<std::uint32_t>(scenario.composer.buffer_pixels)),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      reporter_(log),
      words_(static_cast<std::size_t>(buffer_addresses(scenario.composer.buffer_pixels))) {
    if (scenario.composer.smoothing == Smoothing::kBilinear) {
        second_row = std::make_unique<SecondRow>();
    }
}

void FifoMonitor::violate(const char* rule, const char* signal, std::int64_t edge,
                          const std::string& detail) {
    reporter_.report(rule, rule, fifo_ + signal, edge, RuleReporter::kNoFrame, detail);
}

void FifoMonitor::restart() {
    for (Word& word : words_) {
        word.held = false;
    }
    held_.clear();
    port_ = row_port_ = Port{};
    started_ = false;
}

void FifoMonitor::clock_edge() {
    if (reset_i.read()) {
        clocked_.stay_awake();
        restart();
        return;
    }
    const std::int64_t edge = rtl::clock_edge_number(core_period_picoseconds_);
    if (started_) {
        check_outputs(edge);
    }
    started_ = true;
    const rtl::FifoWrite& write = write_i.read();
    const rtl::FifoRead& read = read_i.read();
    const rtl::FifoRelease& release = release_i.read();
    const bool releases = release.oldest > 0 || release.newest > 0;
    if (write.count > 0) {
        take_write(write, edge);
    }
    bool reads = read.enable;
    if (read.enable) {
        take_read(read, "read", port_, edge);
    }
    if (second_row != nullptr && second_row->row_read_i.read().enable) {
        reads = true;
        take_read(second_row->row_read_i.read(), "row_read", row_port_, edge);
    }
    if (releases) {
        take_release(release, edge);
    }
    if (write.count > 0 || reads || releases) {
        clocked_.stay_awake();
    }
}

/// Checks the values that the edge before has left.
void FifoMonitor::check_outputs(std::int64_t edge) {
    check_word(word_i.read(), port_.word, "word", edge);
    if (second_row != nullptr) {
        check_word(second_row->next_word_i.read(), port_.next_word, "next_word", edge);
        check_word(second_row->row_word_i.read(), row_port_.word, "row_word", edge);
        check_word(second_row->row_next_word_i.read(), row_port_.next_word, "row_next_word", edge);
    }
    if (free_i.read() != capacity_ - held_.size()) {
        violate("fifo/free", "free", edge,
                std::to_string(free_i.read()) + " pixels free, with " + std::to_string(held_.size()) +
                    " of " + std::to_string(capacity_) + " held");
    }
}

void FifoMonitor::check_word(std::uint64_t seen, const std::optional<std::uint64_t>& expected,
                             const char* signal, std::int64_t edge) {
    if (expected && seen != *expected) {
        violate("fifo/word", signal, edge,
                "word " + std::to_string(seen) + ", not the " + std::to_string(*expected) +
                    " of the address read last");
    }
}

void FifoMonitor::take_write(const rtl::FifoWrite& write, std::int64_t edge) {
    for (std::uint32_t i = 0; i < write.count; ++i) {
        const std::uint32_t address = (write.address + i) % static_cast<std::uint32_t>(words_.size());
        Word& word = words_[address];
        if (word.held) {
            violate("fifo/overwrite", "write", edge,
                    "a word for address " + std::to_string(address) + ", which is held");
        }
        word = {true, write.words[i]};
        held_.push_back(address);
    }
    pixels_written_ += write.count;
}

void FifoMonitor::take_read(const rtl::FifoRead& read, const char* signal, Port& port, std::int64_t edge) {
    if (read.address >= words_.size() || !words_[read.address].held) {
        violate("fifo/read", signal, edge,
                "address " + std::to_string(read.address) + " is read, which holds no pixel");
        return;
    }
    port.word = words_[read.address].value;
    const Word& next = words_[(read.address + 1) % words_.size()];
    port.next_word = next.held ? std::optional<std::uint64_t>(next.value) : std::nullopt;
}

void FifoMonitor::take_release(const rtl::FifoRelease& release, std::int64_t edge) {
    if (std::uint64_t{release.oldest} + release.newest > held_.size()) {
        violate("fifo/release", "release", edge,
                std::to_string(release.oldest) + " and " + std::to_string(release.newest) +
                    " pixels are let go of, with " + std::to_string(held_.size()) + " held");
        return;
    }
    for (std::uint32_t i = 0; i < release.oldest; ++i) {
        words_[held_.front()].held = false;
        held_.pop_front();
    }
    for (std::uint32_t i = 0; i < release.newest; ++i) {
        words_[held_.back()].held = false;
        held_.pop_back();
    }
}

}  // namespace metabuffer::monitors
