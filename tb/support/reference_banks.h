#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

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
    bool refreshing(std::int64_t clock) const { return clock < refreshing_until_; }
    /// It has to come now, or should have come.
    bool refresh_due(std::int64_t clock) const {
        return config_.refresh_cycles > 0 && clock - refreshed_ >= config_.refresh_interval_cycles;
    }
    bool is_open(std::size_t number, std::int64_t page) const { return banks_.at(number).page == page; }

  private:
    static constexpr std::int64_t kClosed = -1;
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
