#include "rtl/composer_fifo.h"

#include <string>

#include "datapath/composer_buffer.h"

namespace metabuffer::rtl {

ComposerFifo::ComposerFifo(const sc_core::sc_module_name& name, int capacity_pixels, int window_rows)
    : Block(name),
      second_row(window_rows > 1 ? std::make_unique<SecondRowPins>() : nullptr),
      capacity_(static_cast<std::uint32_t>(capacity_pixels)),
      storage_(static_cast<std::size_t>(buffer_addresses(capacity_pixels))),
      level_(registers_, "level", bits_for(capacity_pixels)) {}

void ComposerFifo::reset() {
    registers_.reset();
    word_o.write(0);
    free_o.write(capacity_);
    if (second_row != nullptr) {
        second_row->next_word_o.write(0);
        second_row->row_word_o.write(0);
        second_row->row_next_word_o.write(0);
    }
}

void ComposerFifo::clock_edge() {
    const FifoWrite& write = write_i.read();
    const FifoRead& read = read_i.read();
    const FifoRelease& release = release_i.read();
    if (write.count > 0 || release.any()) {
        account(write, release);
    }
    if (write.count > 0) {
        store(write);
    }
    put_out(read, word_o, second_row == nullptr ? nullptr : &second_row->next_word_o);
    if (second_row != nullptr) {
        put_out(second_row->row_read_i.read(), second_row->row_word_o, &second_row->row_next_word_o);
    }
}

void ComposerFifo::put_out(const FifoRead& read, Out<std::uint64_t>& word, Out<std::uint64_t>* next_word) {
    if (!read.enable) {
        return;
    }
    if (read.address >= storage_.size()) {
        refuse("address", "to read address " + std::to_string(read.address));
        return;
    }
    word.write(storage_[read.address]);
    if (next_word != nullptr) {
        next_word->write(storage_[(read.address + 1) % storage_.size()]);
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

void ComposerFifo::refuse(const char* kind, const std::string& what) {
    clocked_.stay_awake();  // each edge that breaks a rule is reported
    SC_REPORT_ERROR(
        (std::string("/metabuffer/composer_fifo/") + kind).c_str(),
        (std::string(name()) + " of " + std::to_string(capacity_) + " pixels was asked " + what).c_str());
}

void ComposerFifo::trace(sc_core::sc_trace_file* file) const {
    registers_.trace(file, path(""));
    const int address_bits = bits_for(static_cast<std::int64_t>(storage_.size()) - 1);
    const int count_bits = bits_for(capacity_);
    sc_trace(file, write_i.read(), path("write"), address_bits);
    sc_trace(file, read_i.read(), path("read"), address_bits);
    sc_trace(file, release_i.read(), path("release"), count_bits);
    sc_core::sc_trace(file, word_o.port(), path("word"));
    sc_core::sc_trace(file, free_o.read(), path("free"), count_bits);
    if (second_row != nullptr) {
        sc_core::sc_trace(file, second_row->next_word_o.port(), path("next_word"));
        sc_trace(file, second_row->row_read_i.read(), path("row_read"), address_bits);
        sc_core::sc_trace(file, second_row->row_word_o.port(), path("row_word"));
        sc_core::sc_trace(file, second_row->row_next_word_o.port(), path("row_next_word"));
    }
}

}  // namespace metabuffer::rtl
