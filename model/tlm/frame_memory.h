#pragma once

#include <cstdint>
#include <systemc>

#include "scenario/scenario.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// The time of an input framebuffer's page-mode memory (sections 4 and 5.2 of the paper): words of the open
/// page at the bus's pace, any other word behind page_miss_cycles. A frame starts with no page open.
///
/// Answers MemoryAccess. A memory with another policy takes its place by answering the same; see
/// tb/examples/banked_memory.h.
class FrameMemory final : public sc_core::sc_module {
  public:
    TargetSocket<FrameMemory, MemoryAccess> socket{"socket"};

    FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config);

  private:
    static constexpr std::int64_t kNoPage = -1;

    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);

    std::uint32_t page_words_;
    int page_miss_cycles_;
    std::int64_t open_page_ = kNoPage;
};

}  // namespace metabuffer::tlm
