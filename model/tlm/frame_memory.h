#pragma once

#include <cstdint>
#include <deque>
#include <systemc>
#include <vector>

#include "scenario/scenario.h"
#include "tlm/payload.h"
#include "tlm/schedule_observer.h"

namespace metabuffer::tlm {

/// The timing of an input framebuffer's page-mode memory (sections 4 and 5.2 of the paper). Words of the open page come
/// at the bus's pace. Opening another page takes activate_cycles, and precharge_cycles more if its bank has a page
/// open. A frame starts with no page open. Each refresh_interval_cycles, from first_cycle on, a refresh closes all
/// banks and lasts for refresh_cycles; a page that is being opened then is opened again.
///
/// With shared ports it is one memory for both images, whose pages stay open from frame to frame. A block of the link's
/// words is written as soon as no page is being opened, no refresh is under way and the block ends before the next
/// refresh.
///
/// Answers MemoryAccess. A memory with another policy can replace it if it answers the same; see
/// tb/examples/banked_memory.h.
class FrameMemory final : public sc_core::sc_module {
  public:
    TargetSocket<FrameMemory, MemoryAccess> socket{"socket"};

    /// first_cycle: the first core clock without reset.
    FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config,
                std::int64_t first_cycle = 0);

  private:
    static constexpr std::int64_t kNoPage = -1;
    static constexpr std::int64_t kHalfOpen =
        -2;  ///< an opening was broken off: the bank must be closed before a page is opened

    void b_transport(Payload& payload, sc_core::sc_time& delay);

    struct Bank {
        std::int64_t page = kNoPage;
        std::int64_t refreshes = 0;  ///< that had begun when it was opened; a later one has closed it
    };

    std::int64_t refreshes_by(std::int64_t cycle) const;
    std::int64_t refresh_begins(std::int64_t number) const {
        return first_cycle_ + number * config_.refresh_interval_cycles;
    }
    std::int64_t refresh_ends(std::int64_t number) const {
        return refresh_begins(number) + config_.refresh_cycles;
    }
    std::int64_t open_page(const Bank& bank, std::int64_t cycle) const {
        return bank.refreshes == refreshes_by(cycle) ? bank.page : kNoPage;
    }
    Bank& bank_of(std::int64_t page) { return banks_[static_cast<std::size_t>(page) % banks_.size()]; }

    /// With shared ports: words of the link.
    struct Block {
        std::int64_t ready_cycle = 0;  ///< the first clock in which it may be written
        std::int64_t page = kNoPage;
        int cycles = 0;  ///< on the data pins
    };
    CycleSpan writing_of(const Block& block);
    void write_blocks(std::int64_t cycle);
    void answer(MemoryAccess& access, std::int64_t page);

    MemoryConfig config_;
    std::int64_t first_cycle_;
    std::vector<Bank> banks_;
    std::deque<Block> blocks_;        ///< to be written
    std::int64_t free_from_ = 0;      ///< the first clock in which no opening and no writing is under way
    bool opening_under_way_ = false;  ///< until free_from_
};

}  // namespace metabuffer::tlm
