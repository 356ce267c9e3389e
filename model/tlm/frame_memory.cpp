#include "tlm/frame_memory.h"

#include <algorithm>

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

/// Without shared ports: between two refreshes there is time to open a page, so no wait includes two of them.
void FrameMemory::wait_for_page(MemoryAccess& access, std::int64_t open_page) const {
    int opening = access.page_miss ? config_.opening_cycles(open_page != kNoPage) : 0;
    access.broken_cycles = access.refresh_cycles = 0;
    access.beats_before = kUnknownCycle;
    if (config_.refreshes()) {
        const std::int64_t begun = refreshes_by(access.cycle);
        const std::int64_t next = refresh_begins(begun + 1);
        const std::int64_t end_of_last = refresh_ends(begun);
        access.beats_before = next;
        if (begun > 0 && access.cycle < end_of_last) {
            access.refresh_cycles = static_cast<int>(end_of_last - access.cycle);
        } else if (access.cycle + opening >= next) {
            access.broken_cycles = static_cast<int>(next - access.cycle);
            access.refresh_cycles = config_.refresh_cycles;
            access.beats_before = refresh_begins(begun + 2);
            opening = config_.activate_cycles();
        }
    }
    access.wait_cycles = access.broken_cycles + access.refresh_cycles + opening;
}

/// The state of its bank if the last opening is broken off before this clock. A refresh under way has closed it. Else
/// it is neither closed nor open in a memory that times its banks; in another one the page counts as open.
FrameMemory::Bank FrameMemory::broken_off(std::int64_t cycle) const {
    const std::int64_t clocks = cycle - opening_.cycle;
    const std::int64_t refreshes = refreshes_by(cycle - 1);
    const bool before_refresh = opening_.refresh_cycles == 0 || clocks <= opening_.broken_cycles;
    const bool closed = !before_refresh && clocks <= opening_.broken_cycles + opening_.refresh_cycles;
    if (closed) return {kNoPage, refreshes};
    return {config_.times_banks() ? kHalfOpen : opening_.page, refreshes};
}

// ---- shared ports ----

/// The clocks in which a block is written, as far as is known by now. Nothing else is done in them.
CycleSpan FrameMemory::writing_of(const Block& block) const {
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

/// Answers only a wait: at `end` it can be asked again and knows more.
void FrameMemory::wait(MemoryAccess& access, std::int64_t end, int MemoryAccess::*cause) const {
    access.wait_cycles = access.*cause = static_cast<int>(end - access.cycle);
    access.page_miss = false;
    access.words = 0;
}

void FrameMemory::answer_shared(MemoryAccess& access, std::int64_t page) {
    write_blocks(access.cycle);
    access.wait_cycles = access.broken_cycles = access.refresh_cycles = access.write_cycles = 0;
    access.beats_before = kUnknownCycle;
    if (access.cycle < free_from_) {
        wait(access, free_from_, &MemoryAccess::write_cycles);
        return;
    }
    const std::int64_t begun = refreshes_by(access.cycle);
    if (begun > 0 && access.cycle < refresh_ends(begun)) {
        wait(access, refresh_ends(begun), &MemoryAccess::refresh_cycles);
        return;
    }
    if (config_.refreshes()) {
        access.beats_before = refresh_begins(begun + 1);
    }
    Bank& bank = bank_of(page);
    const std::int64_t open = open_page(bank, access.cycle);
    access.page_miss = open != page;
    const int opening = access.page_miss ? config_.opening_cycles(open != kNoPage) : 0;
    const std::int64_t end = std::min(access.cycle + opening, access.beats_before);
    if (!access.peek) {
        opening_ = {access.cycle, page, 0, 0};
        opening_under_way_ = opening > 0;
        bank = {page, begun};
        last_page_ = page;
        free_from_ = end;
    }
    if (end == access.beats_before) {
        wait(access, end, &MemoryAccess::broken_cycles);
        return;
    }
    access.wait_cycles = opening;
    if (!blocks_.empty()) {
        const std::int64_t next = writing_of(blocks_.front()).first;
        access.beats_before = std::min(access.beats_before, next);
        if (next <= end) access.words = 0;
    }
}

// ---- sockets ----

void FrameMemory::b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& /*delay*/) {
    auto& access = content_of<MemoryAccess>(payload);
    // An image has fewer than 2^32 words.
    const auto address = static_cast<std::uint32_t>(payload.get_address() / kBytesPerWord);
    const auto wanted = static_cast<int>(payload.get_data_length() / kBytesPerWord);
    const auto page_words = static_cast<std::uint32_t>(config_.page_words);
    const std::uint32_t page = address / page_words;
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    Bank& bank = bank_of(page);
    if (access.write) {
        write_blocks(access.settled_before - 1);
        blocks_.push_back({access.cycle, page, config_.write_cycles(wanted)});
        return;
    }
    if (access.broken_off) {
        if (!config_.shared() || (opening_under_way_ && access.cycle < free_from_)) {
            bank = broken_off(access.cycle);
            free_from_ = access.cycle;
        }
        return;
    }
    access.words =
        static_cast<int>(std::min<std::int64_t>(wanted, std::int64_t{page + 1} * page_words - address));
    access.other_page = static_cast<std::int64_t>(page) != last_page_;
    if (config_.shared()) {
        answer_shared(access, page);
        return;
    }
    if (access.new_frame) {
        std::fill(banks_.begin(), banks_.end(), Bank{});
    }
    const std::int64_t open = open_page(bank, access.cycle);
    access.page_miss = static_cast<std::int64_t>(page) != open;
    wait_for_page(access, open);
    if (!access.peek) {
        opening_ = {access.cycle, page, access.broken_cycles, access.refresh_cycles};
        bank = {page, refreshes_by(access.cycle + access.wait_cycles)};
        last_page_ = page;
    }
}

}  // namespace metabuffer::tlm
