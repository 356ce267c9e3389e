#include "rtl/write_buffer.h"

#include <algorithm>
#include <string>

namespace metabuffer::rtl {

WriteBuffer::WriteBuffer(const sc_core::sc_module_name& name, const MemoryConfig& config, std::int64_t words)
    : Block(name),
      block_words_(static_cast<std::uint32_t>(config.write_block_words)),
      image_words_(words),
      device_words_(config.device_words(words)),
      words_per_cycle_(config.words_per_cycle) {
    for (std::size_t half = 0; half < kHalves; ++half) {
        halves_[half] = std::make_unique<Half>(registers_, "half_" + std::to_string(half));
        halves_[half]->words.resize(static_cast<std::size_t>(std::min(words, std::int64_t{block_words_})));
    }
    SC_METHOD(put_out);
    sensitive << command_i << drain_i;
    dont_initialize();
}

void WriteBuffer::reset() {
    registers_.reset();
    for (std::size_t half = 0; half < kHalves; ++half) {
        full_o[half].write(false);
        block_o[half].write(WriteBlock{});
    }
}

void WriteBuffer::link_edge() {
    if (write_i.read().enable) {
        clocked_.stay_awake();
        take(write_i.read());
    }
}

void WriteBuffer::take(const MemoryWrite& write) {
    const std::size_t filling = filling_ ? 1 : 0;
    Half& half = *halves_[filling];
    const std::uint32_t index = write.address % block_words_;
    half.words[index] = write.data;
    if (index + 1 < block_words_ && write.address + 1 < image_words_) {
        return;
    }
    const std::int64_t first = write.address - index;
    half.block = {static_cast<std::uint64_t>(write.device * device_words_ + first), index + 1,
                  write.byte_mask};
    block_o[filling].write(half.block);
    half.full = !half.full;
    full_o[filling].write(half.full);
    filling_ = !filling_;
}

void WriteBuffer::put_out() {
    const MemoryCommand& command = command_i.read();
    data_.count = 0;
    if (command.kind == MemoryCommand::Kind::kWrite) {
        const Half& half = *halves_[drain_i.read() ? 1 : 0];
        data_.count = command.count;
        for (std::size_t word = 0; word < command.count; ++word) {
            data_.words[word] = half.words[command.columns[word] % block_words_];
        }
    }
    data_o.write(data_);
}

void WriteBuffer::trace(sc_core::sc_trace_file* file) const {
    registers_.trace(file, path(""));
    sc_core::sc_trace(file, drain_i.port(), path("drain"));
    sc_trace(file, data_o.read(), path("data"), words_per_cycle_);
}

}  // namespace metabuffer::rtl
