#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/exploration/sweep_plan.h"

namespace metabuffer::exploration {

/// Looks for the smallest value of a whole-number key that meets a goal, without trying them all: doubles until one
/// does, halves the gap below it, and then looks at further values on both sides, since nothing says that a goal which
/// 40 meets is met by 41 as well. What they show is told, not smoothed over. If none does up to the end of the range,
/// further values are looked at between those.
///
/// Whoever asks runs the values that wanted() names, in any order and as many at once as it likes, and takes each.
class SmallestValueSearch {
  public:
    explicit SmallestValueSearch(const SearchDescription& description);

    /// Values to look at that have not been handed out yet; none while the next step waits for those that have.
    std::vector<std::int64_t> wanted();
    void take(std::int64_t value, bool meets);
    bool finished() const { return step_ == Step::kFinished; }

    /// Once it has finished: the smallest value seen to meet the goal, if any does.
    std::optional<std::int64_t> smallest() const;
    /// The largest value looked at.
    std::int64_t largest_seen() const { return seen_.empty() ? 0 : value_at(seen_.rbegin()->first); }
    /// Whether every value looked at below it misses the goal and every one above meets it.
    bool monotonic() const;
    /// Whether all values below the smallest were looked at.
    bool exhaustive() const;
    /// If it is not monotonic: the values that say so.
    std::string note() const;

  private:
    enum class Step : std::uint8_t { kDouble, kCheckGaps, kHalve, kCheck, kHalveBelow, kFinished };
    /// A value's place in the range or among the candidates.
    using Index = std::int64_t;

    std::int64_t value_at(Index index) const;
    Index index_of(std::int64_t value) const;
    Index last_index() const;
    std::optional<Index> first_that_meets() const;
    /// The highest index below that misses the goal, -1 if none is known.
    Index last_miss_below(Index index) const;
    void advance();
    void ask(Index index);
    void ask_in_gaps();
    void ask_for_checks();

    SearchDescription description_;
    Step step_ = Step::kDouble;
    std::map<Index, bool> seen_;    ///< looked at: whether it meets the goal
    std::set<Index> handed_out_;    ///< being looked at
    std::vector<Index> asked_for_;  ///< wanted, not handed out
};

}  // namespace metabuffer::exploration
