#pragma once

#include <cstdint>
#include <systemc>
#include <vector>

#include "scenario/scenario.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// The time of an input framebuffer's page-mode memory (sections 4 and 5.2 of the paper): words of the open
/// page at the bus's pace; another page of a closed bank behind activate_cycles, of a bank with a page open behind
/// precharge_cycles more. A frame starts with no page open. Each refresh_interval_cycles, from first_cycle on, a refresh
/// closes all banks and lasts for refresh_cycles; what is being opened then is opened anew.
///
/// Answers MemoryAccess. A memory with another policy takes its place by answering the same; see
/// tb/examples/banked_memory.h.
class FrameMemory final : public sc_core::sc_module {
  public:
    TargetSocket<FrameMemory, MemoryAccess> socket{"socket"};

    /// first_cycle: the first core clock without reset.
    FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config,
                std::int64_t first_cycle = 0);

  private:
    static constexpr std::int64_t kNoPage = -1;
    static constexpr std::int64_t kHalfOpen = -2;  ///< must be closed before a page of the bank is opened

    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);

    struct Bank {
        std::int64_t page = kNoPage;
        std::int64_t refreshes = 0;  ///< that had begun when it was opened; another one has closed it
    };

    std::int64_t refreshes_by(std::int64_t cycle) const;
    std::int64_t refresh_begins(std::int64_t number) const {
        return first_cycle_ + number * config_.refresh_interval_cycles;
    }
    Bank broken_off(std::int64_t cycle) const;
    void wait_for_page(MemoryAccess& access, std::int64_t open_page) const;

    MemoryConfig config_;
    std::int64_t first_cycle_;
    std::vector<Bank> banks_;
    std::int64_t last_page_ = kNoPage;
    /// What the last access but peeks waits for.
    struct Opening {
        std::int64_t cycle = 0;  ///< its first clock
        std::int64_t page = kNoPage;
        int broken_cycles = 0;      ///< of it that a refresh breaks off
        int refresh_cycles = 0;     ///< behind them
        bool closes_first = false;  ///< the page before must be closed
    };
    Opening opening_;
};

}  // namespace metabuffer::tlm
