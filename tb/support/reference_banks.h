#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::test {

/// The banks of a page-mode memory as its data sheet gives them: which command is right at which clock. It goes by the
/// clocks of the commands before, and a wrong command is obeyed all the same.
class ReferenceBanks {
  public:
    enum class Answer { kRight, kWrongPage, kTooSoon };

    /// first_clock: the clocks to the first refresh count from there.
    explicit ReferenceBanks(const MemoryConfig& config, std::int64_t first_clock = 0)
        : config_(config), banks_(static_cast<std::size_t>(config.banks)), refreshed_(first_clock) {}

    Answer activate(std::int64_t clock, std::size_t number, std::int64_t page) {
        Bank& bank = banks_.at(number % banks_.size());
        // Without precharge_cycles the page before is closed by the way.
        const bool wrong = timed() && bank.page != kClosed;
        const Answer answer = wrong ? Answer::kWrongPage : timing_of(bank, clock);
        bank = {page, clock + config_.page_miss_cycles - config_.precharge_cycles};
        return answer;
    }
    /// A read or a write.
    Answer use(std::int64_t clock, std::size_t number, std::int64_t page) {
        Bank& bank = banks_.at(number % banks_.size());
        const bool activates_itself =
            config_.page_miss_cycles == config_.precharge_cycles && (!timed() || bank.page == kClosed);
        const bool wrong = bank.page != page && !activates_itself;
        const Answer answer = wrong ? Answer::kWrongPage : timing_of(bank, clock);
        bank.page = page;
        return answer;
    }
    void precharge(std::int64_t clock, std::size_t number) {
        banks_.at(number % banks_.size()) = {kClosed, clock + config_.precharge_cycles};
    }
    void precharge_all(std::int64_t clock) {
        for (std::size_t bank = 0; bank < banks_.size(); ++bank) precharge(clock, bank);
    }
    void refresh(std::int64_t clock) {
        std::fill(banks_.begin(), banks_.end(), Bank{kClosed, clock});
        refreshed_ = clock;
        refreshing_until_ = clock + config_.refresh_cycles;
    }
    Answer obey(std::int64_t clock, const rtl::MemoryCommand& command) {
        using Kind = rtl::MemoryCommand::Kind;
        switch (command.kind) {
            case Kind::kActivate:
                return activate(clock, command.bank, command.row);
            case Kind::kRead:
            case Kind::kWrite:
                return use(clock, command.bank, command.row);
            case Kind::kPrecharge:
                precharge(clock, command.bank);
                break;
            case Kind::kPrechargeAll:
                precharge_all(clock);
                break;
            case Kind::kRefresh:
                refresh(clock);
                break;
            case Kind::kNone:
                break;
        }
        return Answer::kRight;
    }
    /// An opening is broken off where banks are timed: whatever has been sent of it, the bank must be closed first.
    void break_off(std::size_t number) {
        if (timed()) banks_.at(number % banks_.size()).page = kHalfOpen;
    }
    bool refreshing(std::int64_t clock) const { return clock < refreshing_until_; }
    /// Of the next one; 0 if it has to come now, or less if it should have come.
    std::int64_t clocks_to_refresh(std::int64_t clock) const {
        return config_.refresh_cycles > 0 ? refreshed_ + config_.refresh_interval_cycles - clock
                                          : std::numeric_limits<std::int64_t>::max();
    }
    bool refresh_due(std::int64_t clock) const { return clocks_to_refresh(clock) <= 0; }
    bool is_open(std::size_t number, std::int64_t page) const {
        return banks_.at(number % banks_.size()).page == page;
    }
    /// From the first command for a page to its first use: the bank may have to be closed, and the page to be opened.
    int clocks_to_open(std::size_t number, std::int64_t page) const {
        const std::int64_t open = banks_.at(number % banks_.size()).page;
        if (open == page) return 0;
        return config_.page_miss_cycles - (open == kClosed ? config_.precharge_cycles : 0);
    }

  private:
    static constexpr std::int64_t kClosed = -1;
    static constexpr std::int64_t kHalfOpen = -2;
    struct Bank {
        std::int64_t page = kClosed;
        std::int64_t ready = 0;  ///< the first clock that may have a command which waits for the one before
    };
    bool timed() const { return config_.precharge_cycles > 0; }
    Answer timing_of(const Bank& bank, std::int64_t clock) const {
        return timed() && clock < bank.ready ? Answer::kTooSoon : Answer::kRight;
    }

    MemoryConfig config_;
    std::vector<Bank> banks_;
    std::int64_t refreshed_;
    std::int64_t refreshing_until_ = 0;
};

}  // namespace metabuffer::test
