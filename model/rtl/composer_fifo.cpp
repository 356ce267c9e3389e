#include "rtl/composer_fifo.h"

#include <string>

#include "datapath/composer_buffer.h"

namespace metabuffer::rtl {

ComposerFifo::ComposerFifo(const sc_core::sc_module_name& name, int capacity_pixels, ClockGating gating)
    : Block(name),
      capacity_(static_cast<std::uint32_t>(capacity_pixels)),
      storage_(static_cast<std::size_t>(buffer_addresses(capacity_pixels))),
      gate_(gating),
      level_(registers_, "level", bits_for(capacity_pixels)) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void ComposerFifo::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= write_i.value_changed_event();
    wake_events_ |= read_i.value_changed_event();
    wake_events_ |= release_i.value_changed_event();
}

void ComposerFifo::clock_edge() {
    if (gate_.opened()) {
        return;
    }
    if (reset_i.read()) {
        registers_.reset();
        word_o.write(0);
        free_o.write(capacity_);
        return;
    }
    const FifoWrite& write = write_i.read();
    const FifoRead& read = read_i.read();
    const FifoRelease& release = release_i.read();
    const bool changes_level = write.count > 0 || release.oldest > 0 || release.newest > 0;
    if (changes_level) {
        account(write, release);
    }
    if (write.count > 0) {
        store(write);
    }
    if (read.enable) {
        if (read.address < storage_.size()) {
            word_o.write(storage_[read.address]);
        } else {
            refuse("address", "to read address " + std::to_string(read.address));
        }
    }
    if (gate_.idle_edge(!changes_level && !read.enable)) {
        next_trigger(wake_events_);
    }
}

void ComposerFifo::store(const FifoWrite& write) {
    if (write.address >= storage_.size()) {
        refuse("address", "to write to address " + std::to_string(write.address));
        return;
    }
    std::size_t address = write.address;
    for (std::size_t word = 0; word < write.count; ++word) {
        storage_[address] = write.words[word];
        address = address + 1 == storage_.size() ? 0 : address + 1;
    }
}

void ComposerFifo::account(const FifoWrite& write, const FifoRelease& release) {
    const std::uint64_t released = std::uint64_t{release.oldest} + release.newest;
    const std::uint64_t held = std::uint64_t{level_} + write.count;
    if (released > held) {
        refuse("empty", "to release " + std::to_string(released) + " pixels of the " + std::to_string(held) +
                            " it holds");
        return;
    }
    const std::uint64_t level = held - released;
    if (level > capacity_) {
        refuse("full", "to hold " + std::to_string(level) + " pixels");
        return;
    }
    level_ = static_cast<std::uint32_t>(level);
    free_o.write(static_cast<std::uint32_t>(capacity_ - level));
}

void ComposerFifo::refuse(const char* kind, const std::string& what) const {
    SC_REPORT_ERROR(
        (std::string("/metabuffer/composer_fifo/") + kind).c_str(),
        (std::string(name()) + " of " + std::to_string(capacity_) + " pixels was asked " + what).c_str());
}

void ComposerFifo::trace(sc_core::sc_trace_file* file) const {
    registers_.trace(file, path(""));
    sc_trace(file, write_i.read(), path("write"));
    sc_trace(file, read_i.read(), path("read"));
    sc_trace(file, release_i.read(), path("release"));
    sc_core::sc_trace(file, word_o, path("word"));
    sc_core::sc_trace(file, free_o, path("free"));
}

}  // namespace metabuffer::rtl
