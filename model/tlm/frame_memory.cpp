#include "tlm/frame_memory.h"

#include <algorithm>
#include <utility>

namespace metabuffer::tlm {

FrameMemory::FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config,
                         std::int64_t first_cycle)
    : sc_core::sc_module(name),
      config_(config),
      first_cycle_(first_cycle),
      banks_(static_cast<std::size_t>(config.banks)) {
    socket.register_b_transport(this, &FrameMemory::b_transport);
}

/// How many refreshes have begun at this clock or before.
std::int64_t FrameMemory::refreshes_by(std::int64_t cycle) const {
    return config_.refreshes() ? (cycle - first_cycle_) / config_.refresh_interval_cycles : 0;
}

// ---- shared ports ----

/// The clocks in which a block is written, as far as is known by now. Nothing else is done in them.
CycleSpan FrameMemory::writing_of(const Block& block) {
    CycleSpan span{std::max(block.ready_cycle, free_from_), 0};
    for (;;) {
        const std::int64_t begun = refreshes_by(span.first);
        if (begun > 0) {
            span.first = std::max(span.first, refresh_ends(begun));
        }
        const std::int64_t open = open_page(bank_of(block.page), span.first);
        const int opening = open != block.page ? config_.opening_cycles(open != kNoPage) : 0;
        span.last = span.first + opening + block.cycles - 1;
        if (!config_.refreshes() || span.last < refresh_begins(begun + 1)) {
            return span;
        }
        span.first = refresh_begins(begun + 1);
    }
}

/// Writes the blocks that begin at this clock or before.
void FrameMemory::write_blocks(std::int64_t cycle) {
    while (!blocks_.empty()) {
        const Block& block = blocks_.front();
        const CycleSpan span = writing_of(block);
        if (span.first > cycle) {
            return;
        }
        bank_of(block.page) = {block.page, refreshes_by(span.first)};
        free_from_ = span.last + 1;
        opening_under_way_ = false;
        blocks_.pop_front();
    }
}

// ---- accesses ----

void FrameMemory::answer(MemoryAccess& access, std::int64_t page) {
    write_blocks(access.cycle);
    const int words = std::exchange(access.words, 0);
    access.page_miss = false;
    access.beats_before = kUnknownCycle;
    const auto wait = [&access](MemoryAccess::Wait what, std::int64_t end) {
        access.wait = what;
        access.wait_cycles = static_cast<int>(end - access.cycle);
    };
    if (access.cycle < free_from_) {
        wait(MemoryAccess::Wait::kWrite, free_from_);
        return;
    }
    const std::int64_t begun = refreshes_by(access.cycle);
    if (begun > 0 && access.cycle < refresh_ends(begun)) {
        wait(MemoryAccess::Wait::kRefresh, refresh_ends(begun));
        return;
    }
    if (config_.refreshes()) {
        access.beats_before = refresh_begins(begun + 1);
    }
    Bank& bank = bank_of(page);
    const std::int64_t open = open_page(bank, access.cycle);
    access.page_miss = open != page;
    const int opening = access.page_miss ? config_.opening_cycles(open != kNoPage) : 0;
    bank = {page, begun};
    opening_under_way_ = opening > 0;
    free_from_ = std::min(access.cycle + opening, access.beats_before);
    wait(MemoryAccess::Wait::kOpening, free_from_);
    if (free_from_ == access.beats_before) {
        return;  // the refresh breaks it off
    }
    if (!blocks_.empty()) {
        access.beats_before = std::min(access.beats_before, writing_of(blocks_.front()).first);
    }
    access.words = access.beats_before > free_from_ ? words : 0;
}

// ---- sockets ----

void FrameMemory::b_transport(Payload& payload, sc_core::sc_time& /*delay*/) {
    auto& access = content_of<MemoryAccess>(payload);
    // An image has fewer than 2^32 words.
    const auto address = static_cast<std::uint32_t>(payload.get_address() / kBytesPerWord);
    const std::uint32_t page = address / static_cast<std::uint32_t>(config_.page_words);
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    Bank& bank = bank_of(page);
    if (access.write) {
        write_blocks(access.settled_before - 1);
        const auto words = static_cast<int>(payload.get_data_length() / kBytesPerWord);
        blocks_.push_back({access.cycle, page, config_.write_cycles(words)});
        return;
    }
    if (access.broken_off) {
        // The bank is neither closed nor open in a memory that times its banks; in another one the page counts as open.
        if (opening_under_way_ && access.cycle < free_from_) {
            bank = {config_.times_banks() ? kHalfOpen : page, refreshes_by(access.cycle - 1)};
            free_from_ = access.cycle;
        }
        return;
    }
    if (access.new_frame && !config_.shared()) {
        std::fill(banks_.begin(), banks_.end(), Bank{});
    }
    access.words = words_on_page(payload, access, config_.page_words);
    answer(access, page);
}

}  // namespace metabuffer::tlm
