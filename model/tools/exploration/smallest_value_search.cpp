#include "tools/exploration/smallest_value_search.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>
#include <utility>

#include "host/text.h"

namespace metabuffer::exploration {
namespace {

/// The most values that a note names one by one.
constexpr std::size_t kNamedValues = 4;

std::string listed(const std::vector<std::int64_t>& values, const SearchDescription& search) {
    std::string text;
    for (std::size_t n = 0; n < std::min(values.size(), kNamedValues); ++n) {
        text += (n == 0 ? "" : ", ") + search.text_of(values[n]);
    }
    return values.size() > kNamedValues
               ? text + " and " + std::to_string(values.size() - kNamedValues) + " more"
               : text;
}

/// How far above the value checks go, in multiples of its distance from the lower end.
constexpr std::int64_t kChecksAbove = 4;

/// At most `count` distances from 1 to `limit`. Half of them are as near as possible, since schedules change there. The
/// others are farther and farther apart, up to the limit.
std::vector<std::int64_t> spread(std::int64_t count, std::int64_t limit) {
    std::vector<std::int64_t> distances;
    const std::int64_t near = count >= limit ? limit : (count + 1) / 2;
    for (std::int64_t distance = 1; distance <= std::min(near, limit); ++distance)
        distances.push_back(distance);
    const std::int64_t far = count - near;
    if (near >= limit || far <= 0) return distances;
    const double ratio =
        std::pow(static_cast<double>(limit) / static_cast<double>(near), 1.0 / static_cast<double>(far));
    double at = static_cast<double>(near);
    for (std::int64_t n = 0; n < far; ++n) {
        at *= ratio;
        const auto distance = static_cast<std::int64_t>(std::llround(at));
        if (distance > distances.back() && distance <= limit) distances.push_back(distance);
    }
    return distances;
}

}  // namespace

std::string narrow(SearchDescription& search, const KnownAnswer& known) {
    std::vector<std::string> why;
    if (known.least && search.from < *known.least && *known.least <= search.to) {
        search.from = *known.least;
        why.push_back("less than " + search.text_of(search.from) + " is too little");
    }
    const auto end_at = [&](const std::optional<std::int64_t>& end, const std::string& reason) {
        if (!end || *end >= search.to || *end < search.from) return;
        search.to = *end;
        why.push_back("more than " + search.text_of(search.to) + reason);
    };
    end_at(known.enough, " is never needed");
    end_at(known.most, " changes nothing");
    return text::joined(why, "and");
}

SmallestValueSearch::SmallestValueSearch(const SearchDescription& description) : description_(description) {
    if (description_.candidates.empty() && description_.from > description_.to) {
        throw std::invalid_argument("an empty range to search");
    }
    ask(0);
}

std::int64_t SmallestValueSearch::value_at(Index index) const {
    return description_.candidates.empty() ? description_.from + index
                                           : description_.candidates[static_cast<std::size_t>(index)];
}

SmallestValueSearch::Index SmallestValueSearch::index_of(std::int64_t value) const {
    const auto& candidates = description_.candidates;
    if (candidates.empty()) return value - description_.from;
    return std::lower_bound(candidates.begin(), candidates.end(), value) - candidates.begin();
}

SmallestValueSearch::Index SmallestValueSearch::last_index() const {
    return description_.candidates.empty() ? description_.to - description_.from
                                           : static_cast<Index>(description_.candidates.size()) - 1;
}

std::vector<std::int64_t> SmallestValueSearch::wanted() {
    std::vector<std::int64_t> values;
    for (const Index index : asked_for_) {
        handed_out_.insert(index);
        values.push_back(value_at(index));
    }
    asked_for_.clear();
    return values;
}

void SmallestValueSearch::take(std::int64_t value, bool meets) {
    const Index index = index_of(value);
    handed_out_.erase(index);
    seen_[index] = meets;
    if (handed_out_.empty() && asked_for_.empty()) advance();
}

void SmallestValueSearch::ask(Index index) {
    const bool is_known = seen_.count(index) != 0 || handed_out_.count(index) != 0 ||
                          std::find(asked_for_.begin(), asked_for_.end(), index) != asked_for_.end();
    if (!is_known) asked_for_.push_back(index);
}

std::optional<SmallestValueSearch::Index> SmallestValueSearch::first_that_meets() const {
    const auto found =
        std::find_if(seen_.begin(), seen_.end(), [](const auto& entry) { return entry.second; });
    return found == seen_.end() ? std::nullopt : std::optional<Index>(found->first);
}

SmallestValueSearch::Index SmallestValueSearch::last_miss_below(Index index) const {
    Index last = -1;
    for (const auto& [seen, meets] : seen_) {
        if (seen < index && !meets) last = seen;
    }
    return last;
}

void SmallestValueSearch::advance() {
    // Every step either asks for values or passes on to the next one.
    while (asked_for_.empty() && step_ != Step::kFinished) {
        const std::optional<Index> first = first_that_meets();
        switch (step_) {
            case Step::kDouble: {
                const Index highest = seen_.rbegin()->first;
                if (first) {
                    step_ = Step::kHalve;
                } else if (highest == last_index()) {
                    step_ = Step::kCheckGaps;
                    ask_in_gaps();
                } else {
                    // Doubles the value, not its distance from the start of the range.
                    const std::int64_t doubled = std::max<std::int64_t>(1, value_at(highest)) * 2;
                    const Index next =
                        description_.candidates.empty() ? doubled - description_.from : highest + 1;
                    ask(std::min(std::max(next, highest + 1), last_index()));
                }
                break;
            }
            case Step::kHalve:
            case Step::kHalveBelow: {
                const Index below = last_miss_below(*first);
                if (*first - below > 1) {
                    ask(below + (*first - below) / 2);
                } else if (step_ == Step::kHalve) {
                    step_ = Step::kCheck;
                    ask_for_checks();
                } else {
                    step_ = Step::kFinished;
                }
                break;
            }
            case Step::kCheckGaps:
                step_ = first ? Step::kHalve : Step::kFinished;
                break;
            case Step::kCheck:
                step_ = Step::kHalveBelow;
                break;
            case Step::kFinished:
                break;
        }
    }
}

/// Asks for values between those tried, most where they are farthest apart: one of them may meet the goal although the
/// largest does not.
void SmallestValueSearch::ask_in_gaps() {
    std::priority_queue<std::pair<Index, Index>> gaps;  // length and start
    Index former = seen_.begin()->first;
    for (const auto& [index, meets] : seen_) {
        gaps.emplace(index - former, former);
        former = index;
    }
    for (int asked = 0; asked < description_.checks && gaps.top().first > 1; ++asked) {
        const auto [length, start] = gaps.top();
        gaps.pop();
        const Index half = length / 2;
        ask(start + half);
        gaps.emplace(half, start);
        gaps.emplace(length - half, start + half);
    }
}

void SmallestValueSearch::ask_for_checks() {
    const Index first = *first_that_meets();
    const Index each_side = (description_.checks + 1) / 2;
    // Below it the checks reach all values. Above it they do not go far, since only small values are of interest.
    const Index above = std::min(last_index() - first, kChecksAbove * (first + 1));
    for (const Index distance : spread(each_side, first)) ask(first - distance);
    for (const Index distance : spread(each_side, above)) ask(first + distance);
}

std::optional<std::int64_t> SmallestValueSearch::smallest() const {
    const std::optional<Index> first = first_that_meets();
    return first ? std::optional<std::int64_t>(value_at(*first)) : std::nullopt;
}

bool SmallestValueSearch::monotonic() const {
    const std::optional<Index> first = first_that_meets();
    return !first || std::all_of(seen_.begin(), seen_.end(), [first](const auto& entry) {
        return entry.second == (entry.first >= *first);
    });
}

bool SmallestValueSearch::exhaustive() const {
    const std::optional<Index> first = first_that_meets();
    const Index all = first ? *first : last_index() + 1;
    const auto below =
        std::count_if(seen_.begin(), seen_.end(), [all](const auto& entry) { return entry.first < all; });
    return below == all;
}

std::string SmallestValueSearch::note(const std::function<std::string(std::int64_t value)>& missed) const {
    if (monotonic()) return {};
    const Index first = *first_that_meets();
    std::vector<std::int64_t> misses;
    Index last_miss = first;
    for (const auto& [index, meets] : seen_) {
        if (index <= first || meets) continue;
        misses.push_back(value_at(index));
        last_miss = index;
    }
    std::string text = "not monotonic: " + description_.text_of(value_at(first)) + " meets the goal, " +
                       listed(misses, description_) + (misses.size() == 1 ? " does not" : " do not");
    if (const std::string what = missed(misses.front()); !what.empty()) {
        text += " (" + (misses.size() == 1 ? "" : description_.text_of(misses.front()) + ": ") + what + ")";
    }
    const auto settled = seen_.upper_bound(last_miss);
    return settled == seen_.end() ? text + ", nor does any larger value that was tried"
                                  : text + "; from " + description_.text_of(value_at(settled->first)) +
                                        " on every value tried does";
}

}  // namespace metabuffer::exploration
