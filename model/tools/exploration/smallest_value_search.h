#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/exploration/sweep_plan.h"

namespace metabuffer::exploration {

/// What is known of a search's point before anything is run.
struct KnownAnswer {
    std::optional<std::int64_t> least;   ///< a smaller value cannot meet the goal
    std::optional<std::int64_t> enough;  ///< this value is sure to meet it
    std::optional<std::int64_t> most;    ///< a larger value makes no difference
    std::string hopeless;                ///< why no value can meet it; empty: one may
};

/// Limits a search: no values below the least that can meet the goal, none above what is enough or makes a difference.
/// Returns what was left out and why; empty if nothing was.
std::string narrow(SearchDescription& search, const KnownAnswer& known);

/// Searches for the smallest value of a key that meets a goal, without trying them all. Values are whole numbers: those
/// of the key, or of its steps. The search doubles the value until one meets the goal, and halves the gap below it.
/// Then it tries further values on both sides, since a goal that 40 meets need not be met by 41; note() reports what
/// they show. If no value up to the end of the range meets the goal, it tries further values between those.
///
/// The caller runs the values that wanted() names, in any order and as many at once as it likes, and gives each outcome
/// to take().
class SmallestValueSearch {
  public:
    explicit SmallestValueSearch(const SearchDescription& description);

    /// Values to try that have not been handed out yet; empty while the next step waits for those that have.
    std::vector<std::int64_t> wanted();
    void take(std::int64_t value, bool meets);
    bool finished() const { return step_ == Step::kFinished; }

    /// Once it has finished: the smallest value tried that meets the goal, if any does.
    std::optional<std::int64_t> smallest() const;
    /// The largest value tried.
    std::int64_t largest_seen() const { return seen_.empty() ? 0 : value_at(seen_.rbegin()->first); }
    /// Whether every value tried below smallest() misses the goal and every one above meets it.
    bool monotonic() const;
    /// Whether all values below the smallest were tried; if no value meets the goal, all of the range.
    bool exhaustive() const;
    /// If it is not monotonic: the values that show this, and what the first of them misses, which the function says.
    std::string note(const std::function<std::string(std::int64_t value)>& missed) const;

  private:
    enum class Step : std::uint8_t { kDouble, kCheckGaps, kHalve, kCheck, kHalveBelow, kFinished };
    /// A value's index in the range or among the candidates.
    using Index = std::int64_t;

    std::int64_t value_at(Index index) const;
    Index index_of(std::int64_t value) const;
    Index last_index() const;
    std::optional<Index> first_that_meets() const;
    /// The highest index below `index` that misses the goal, -1 if none is known.
    Index last_miss_below(Index index) const;
    void advance();
    void ask(Index index);
    void ask_in_gaps();
    void ask_for_checks();

    SearchDescription description_;
    Step step_ = Step::kDouble;
    std::map<Index, bool> seen_;    ///< values tried: whether each meets the goal
    std::set<Index> handed_out_;    ///< being tried
    std::vector<Index> asked_for_;  ///< wanted, not handed out
};

}  // namespace metabuffer::exploration
