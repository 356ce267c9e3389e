#pragma once

#include <cstdint>
#include <vector>

#include "cover_group.h"
#include "rtl/framebuffer_wires.h"
#include "rtl/signals.h"
#include "scenario/limits.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

struct MemoryCommandGoals : CoverGroup {
    explicit MemoryCommandGoals(Coverage& coverage)
        : CoverGroup(coverage, {"memory/command", "what a bus port asks of its memory"}) {}
    using Kind = rtl::MemoryCommand::Kind;
    Cross<Kind> kind{*this,
                     {{Kind::kActivate, "activate"},
                      {Kind::kRead, "read"},
                      {Kind::kPrecharge, "precharge"},
                      {Kind::kPrechargeAll, "precharge all"},
                      {Kind::kRefresh, "refresh"},
                      {Kind::kWrite, "write"}}};
    Cross<MemoryPorts, int> banks{*this,
                                  {{MemoryPorts::kDual, "dual"}, {MemoryPorts::kShared, "shared"}},
                                  numbers(limits::kMemoryBanks, " banks, a page opened in the last")};
    Bin closed_bank = bin("a closed bank is activated");
    Bin closed_first = bin("a bank is closed, then activated");
    Bin beside_open_bank = bin("activated while another bank's page stays open");
    Bin read_of_other_bank = bin("read of another bank, whose page is still open");
    Bin reads_in_a_row = bin("reads at clocks that follow each other");
    Bin closed_again = bin("a bank is closed again before its page was read");
    Bin refresh_closes = bin("a refresh closes open pages");
    Bin refresh_of_closed = bin("a refresh with no page open");
};

/// Follows the commands of one bus port to its frame memory, clock by clock.
class MemoryCoverage {
  public:
    /// Goals and scenario must outlive it.
    MemoryCoverage(const MemoryCommandGoals& goals, const Scenario& scenario);

    /// A clock without reset.
    void clock(const rtl::MemoryCommand& command);

  private:
    struct Bank {
        bool open = false;
        bool read = false;     ///< since it was activated
        bool closing = false;  ///< its last command was a precharge
    };
    bool others_open(std::size_t bank) const;

    const MemoryCommandGoals& goals_;
    const MemoryConfig& config_;
    std::vector<Bank> banks_;
    bool read_before_ = false;   ///< in the clock before
    std::size_t bank_read_ = 0;  ///< last
};

}  // namespace metabuffer::coverage
