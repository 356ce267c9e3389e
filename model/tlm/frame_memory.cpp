#include "tlm/frame_memory.h"

#include <algorithm>

namespace metabuffer::tlm {

FrameMemory::FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config)
    : sc_core::sc_module(name),
      config_(config),
      open_pages_(static_cast<std::size_t>(config.banks), kNoPage) {
    socket.register_b_transport(this, &FrameMemory::b_transport);
}

void FrameMemory::b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& /*delay*/) {
    auto& access = content_of<MemoryAccess>(payload);
    // An image has fewer than 2^32 words.
    const auto address = static_cast<std::uint32_t>(payload.get_address() / kBytesPerWord);
    const auto wanted = static_cast<int>(payload.get_data_length() / kBytesPerWord);
    const auto page_words = static_cast<std::uint32_t>(config_.page_words);
    const std::uint32_t page = address / page_words;
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    if (access.broken_off) {
        if (closes_first_) {
            open_pages_[page % open_pages_.size()] = kHalfOpen;
        }
        return;
    }
    if (access.new_frame) {
        std::fill(open_pages_.begin(), open_pages_.end(), kNoPage);
    }
    std::int64_t& open_page = open_pages_[page % open_pages_.size()];
    access.page_miss = static_cast<std::int64_t>(page) != open_page;
    access.wait_cycles = access.page_miss ? config_.opening_cycles(open_page != kNoPage) : 0;
    access.other_page = static_cast<std::int64_t>(page) != last_page_;
    access.words =
        static_cast<int>(std::min<std::int64_t>(wanted, std::int64_t{page + 1} * page_words - address));
    if (!access.peek) {
        closes_first_ = access.page_miss && open_page != kNoPage && config_.precharge_cycles > 0;
        open_page = last_page_ = page;
    }
}

}  // namespace metabuffer::tlm
