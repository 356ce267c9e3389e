#pragma once

#include <cstdint>

#include "scenario/scenario.h"
#include "socket_bench.h"

namespace metabuffer::test {

inline MemoryConfig memory_config(int page_words, int page_miss_cycles, int banks = 1,
                                  int precharge_cycles = 0) {
    MemoryConfig config;
    config.page_words = page_words;
    config.page_miss_cycles = page_miss_cycles;
    config.banks = banks;
    config.precharge_cycles = precharge_cycles;
    return config;
}

struct Access {
    bool page_miss = false;
    int wait_cycles = 0;
    int words = 0;
    friend bool operator==(const Access& a, const Access& b) {
        return a.page_miss == b.page_miss && a.wait_cycles == b.wait_cycles && a.words == b.words;
    }
};

/// Asks a memory the way an input framebuffer does.
class MemoryUser {
  public:
    Initiator<tlm::MemoryAccess> initiator;

    explicit MemoryUser(const char* name = "memory_user") : initiator(name) {}

    Access access(std::int64_t word, int words, bool new_frame = false) {
        message_.payload().set_address(static_cast<sc_dt::uint64>(word) * 8);
        message_.payload().set_data_length(static_cast<unsigned>(words) * 8);
        *message_ = tlm::MemoryAccess{};
        message_->new_frame = new_frame;
        message_->cycle = cycle_;
        all_ok = initiator.send(message_.payload()) == ::tlm::TLM_OK_RESPONSE && all_ok;
        return {message_->page_miss, message_->wait_cycles, message_->words};
    }
    /// The same, wanted at a core clock. Returns all that the memory answers.
    const tlm::MemoryAccess& access_at(std::int64_t cycle, std::int64_t word, int words,
                                       bool new_frame = false) {
        cycle_ = cycle;
        access(word, words, new_frame);
        return *message_;
    }
    /// With shared ports: words of the link that may be written from a core clock on. No access before the other clock
    /// follows.
    void bring_block(std::int64_t cycle, std::int64_t word, int words, std::int64_t settled_before = 0) {
        message_.payload().set_address(static_cast<sc_dt::uint64>(word) * 8);
        message_.payload().set_data_length(static_cast<unsigned>(words) * 8);
        *message_ = tlm::MemoryAccess{};
        message_->write = true;
        message_->cycle = cycle;
        message_->settled_before = settled_before;
        all_ok = initiator.send(message_.payload()) == ::tlm::TLM_OK_RESPONSE && all_ok;
    }
    /// Breaks off the last access, this many clocks after its first.
    void break_off(std::int64_t word, int clocks = 1) {
        message_.payload().set_address(static_cast<sc_dt::uint64>(word) * 8);
        *message_ = tlm::MemoryAccess{};
        message_->broken_off = true;
        message_->cycle = cycle_ + clocks;
        all_ok = initiator.send(message_.payload()) == ::tlm::TLM_OK_RESPONSE && all_ok;
    }

    bool all_ok = true;

  private:
    std::int64_t cycle_ = 0;
    tlm::Message<tlm::MemoryAccess> message_;
};

}  // namespace metabuffer::test
