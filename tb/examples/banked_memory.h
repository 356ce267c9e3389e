#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <systemc>
#include <utility>
#include <vector>

#include "scenario/scenario.h"
#include "tlm/metabuffer.h"
#include "tlm/payload.h"

namespace metabuffer::examples {

/// An architect's own memory between input framebuffer and page timing: several banks, which get the pages in turn,
/// with one page open in each. A burst that comes back to a source row a few rows later finds its page still open. With
/// one bank it is the machine's own memory.
///
/// Between frames the banks close their pages, as the machine's memory does.
class BankedMemory final : public sc_core::sc_module {
  public:
    tlm::TargetSocket<BankedMemory, tlm::MemoryAccess> socket{"socket"};

    /// banks: 1 or more. Page size and the price of a miss are those of the scenario's `memory`.
    BankedMemory(const sc_core::sc_module_name& name, const MemoryConfig& config, int banks)
        : sc_core::sc_module(name),
          page_words_(config.page_words),
          page_miss_cycles_(config.page_miss_cycles),
          open_page_(static_cast<std::size_t>(banks), kNoPage) {
        socket.register_b_transport(this, &BankedMemory::b_transport);
    }

  private:
    static constexpr std::int64_t kNoPage = -1;

    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& /*delay*/) {
        auto& access = tlm::content_of<tlm::MemoryAccess>(payload);
        if (access.write) {  // the link has its own ports here
            payload.set_response_status(::tlm::TLM_OK_RESPONSE);
            return;
        }
        const auto address = static_cast<std::int64_t>(payload.get_address() / tlm::kBytesPerWord);
        if (access.new_frame) {
            std::fill(open_page_.begin(), open_page_.end(), kNoPage);
        }
        const std::int64_t page = address / page_words_;
        std::int64_t& open_page = open_page_[static_cast<std::size_t>(page) % open_page_.size()];
        access.page_miss = open_page != page;
        access.wait_cycles = access.page_miss ? page_miss_cycles_ : 0;
        access.words = tlm::words_on_page(payload, access, page_words_);
        open_page = page;
        payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    }

    int page_words_;
    int page_miss_cycles_;
    std::vector<std::int64_t> open_page_;
};

/// Options for a machine that counts only, with such memories.
inline tlm::Metabuffer::Options with_banks(int banks) {
    tlm::Metabuffer::Options options;
    options.images = false;
    options.make_memory = [banks](const char* name, const Scenario& scenario, int /*renderer*/) {
        auto memory = std::make_unique<BankedMemory>(name, scenario.memory, banks);
        tlm::Metabuffer::Memory made;
        made.socket = &memory->socket;
        made.module = std::move(memory);
        return made;
    };
    return options;
}

}  // namespace metabuffer::examples
