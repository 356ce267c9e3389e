#include "memory_coverage.h"

#include <algorithm>
#include <utility>

namespace metabuffer::coverage {

MemoryCoverage::MemoryCoverage(const MemoryCommandGoals& goals, const Scenario& scenario)
    : goals_(goals), config_(scenario.memory), banks_(static_cast<std::size_t>(scenario.memory.banks)) {}

bool MemoryCoverage::others_open(std::size_t bank) const {
    for (std::size_t other = 0; other < banks_.size(); ++other) {
        if (other != bank && banks_[other].open) return true;
    }
    return false;
}

void MemoryCoverage::clock(const rtl::MemoryCommand& command) {
    using Kind = rtl::MemoryCommand::Kind;
    const bool read_before = std::exchange(read_before_, command.kind == Kind::kRead);
    if (command.kind == Kind::kNone) return;
    goals_.kind(command.kind).hit();
    const std::size_t index = command.bank % banks_.size();
    Bank& bank = banks_[index];
    switch (command.kind) {
        case Kind::kNone:
            break;
        case Kind::kActivate:
            goals_.banks(config_.ports, config_.banks).hit_if(index == banks_.size() - 1);
            (bank.closing ? goals_.closed_first : goals_.closed_bank).hit_if(!bank.open);
            goals_.beside_open_bank.hit_if(others_open(index));
            bank = {true, false, false};
            break;
        case Kind::kRead:
            goals_.reads_in_a_row.hit_if(read_before);
            goals_.read_of_other_bank.hit_if(bank.read && index != bank_read_);
            bank.open = bank.read = true;
            bank_read_ = index;
            break;
        case Kind::kWrite:
            bank.open = bank.read = true;
            break;
        case Kind::kPrecharge:
            goals_.closed_again.hit_if(!bank.read);
            bank = {false, false, true};
            break;
        case Kind::kRefresh:
            (others_open(banks_.size()) ? goals_.refresh_closes : goals_.refresh_of_closed).hit();
            [[fallthrough]];
        case Kind::kPrechargeAll:
            std::fill(banks_.begin(), banks_.end(), Bank{});
            break;
    }
}

}  // namespace metabuffer::coverage
