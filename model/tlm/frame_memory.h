#pragma once

#include <cstdint>
#include <systemc>
#include <vector>

#include "scenario/scenario.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// The time of an input framebuffer's page-mode memory (sections 4 and 5.2 of the paper): words of the open
/// page at the bus's pace; another page of a closed bank behind activate_cycles, of a bank with a page open behind
/// precharge_cycles more. A frame starts with no page open.
///
/// Answers MemoryAccess. A memory with another policy takes its place by answering the same; see
/// tb/examples/banked_memory.h.
class FrameMemory final : public sc_core::sc_module {
  public:
    TargetSocket<FrameMemory, MemoryAccess> socket{"socket"};

    FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config);

  private:
    static constexpr std::int64_t kNoPage = -1;
    static constexpr std::int64_t kHalfOpen = -2;  ///< must be closed before a page of the bank is opened

    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);

    MemoryConfig config_;
    std::vector<std::int64_t> open_pages_;  ///< by bank
    std::int64_t last_page_ = kNoPage;
    bool closes_first_ = false;  ///< the last opening began with a precharge
};

}  // namespace metabuffer::tlm
