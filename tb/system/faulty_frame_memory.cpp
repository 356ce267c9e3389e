#include <algorithm>
#include <cstdint>

#include "tlm/frame_memory.h"

// Stands in for the frame memory of level tlm with a mistake: it forgets to close its page when a frame begins, so that
// a frame that starts where the one before ended misses a page too few. For the shrinker to find the smallest machine
// that shows it.

namespace metabuffer::tlm {

FrameMemory::FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config)
    : sc_core::sc_module(name),
      config_(config),
      open_pages_(static_cast<std::size_t>(config.banks), kNoPage) {
    socket.register_b_transport(this, &FrameMemory::b_transport);
}

void FrameMemory::b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& /*delay*/) {
    auto& access = content_of<MemoryAccess>(payload);
    const auto address = static_cast<std::uint32_t>(payload.get_address() / kBytesPerWord);
    const auto wanted = static_cast<int>(payload.get_data_length() / kBytesPerWord);
    const auto page_words = static_cast<std::uint32_t>(config_.page_words);
    const std::uint32_t page = address / page_words;
    std::int64_t& open_page = open_pages_[page % open_pages_.size()];
    access.page_miss = static_cast<std::int64_t>(page) != open_page;
    access.wait_cycles = access.page_miss ? config_.opening_cycles(open_page != kNoPage) : 0;
    access.other_page = static_cast<std::int64_t>(page) != last_page_;
    access.words =
        static_cast<int>(std::min<std::int64_t>(wanted, std::int64_t{page + 1} * page_words - address));
    if (!access.peek) {
        open_page = last_page_ = page;
    }
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
}

}  // namespace metabuffer::tlm
