#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "coverage.h"
#include "scenario/names.h"

// Goals are declared in the header of the file that hits them. They are members of a group, which is made with the
// Coverage that they belong to.
//
//     struct BurstGoals : CoverGroup {
//         explicit BurstGoals(Coverage& coverage) : CoverGroup(coverage, {"bus/burst", "how a burst runs and ends"}) {}
//         Bin whole = bin("whole");
//         Cross<Arbitration, int> pixels{*this, every<Arbitration>(), numbers(1, 8, " pixels")};
//     };
//     goals.whole.hit();
//     goals.pixels(scenario.bus.arbitration, 3).hit();  // "irsa, 3 pixels"

namespace metabuffer::coverage {

/// One goal, for the code that hits it. Its Coverage must outlive it.
class Bin {
  public:
    explicit Bin(Goal& goal) : goal_(&goal) {}
    void hit(std::int64_t times = 1) const { goal_->count += times; }
    void hit_if(bool condition) const { goal_->count += condition ? 1 : 0; }
    std::int64_t count() const { return goal_->count; }

  private:
    Goal* goal_;
};

/// Declares goals of one group.
class CoverGroup {
  public:
    CoverGroup(Coverage& coverage, const GroupTitle& title) : coverage_(coverage), title_(title) {}
    CoverGroup(const CoverGroup&) = delete;
    CoverGroup& operator=(const CoverGroup&) = delete;

    Bin bin(const std::string& name) { return Bin(coverage_.declare(title_, name)); }

  private:
    Coverage& coverage_;
    GroupTitle title_;
};

/// Groups, each made with `coverage`, or sets of them.
class GoalSet {
  public:
    explicit GoalSet(Coverage& all) : coverage(all) {}
    GoalSet(const GoalSet&) = delete;
    GoalSet& operator=(const GoalSet&) = delete;

  protected:
    Coverage& coverage;
};

/// Values, and what each is called in the names of goals.
template <typename Value>
using Axis = std::vector<std::pair<Value, std::string>>;

/// Every enumerator of an enumeration that has names: a new one is a new goal by itself.
template <typename Enum>
Axis<Enum> every(const std::string& before = "", const std::string& behind = "") {
    Axis<Enum> axis;
    for (const auto& entry : EnumNames<Enum>::kTable) {
        axis.emplace_back(entry.value, before + entry.name + behind);
    }
    return axis;
}

/// Numbers of a list, named by their digits.
template <typename List>
Axis<int> numbers(const List& list, const std::string& behind = "") {
    Axis<int> axis;
    for (const int number : list) axis.emplace_back(number, std::to_string(number) + behind);
    return axis;
}

inline Axis<int> numbers(int first, int last, const std::string& behind = "") {
    Axis<int> axis;
    for (int number = first; number <= last; ++number) {
        axis.emplace_back(number, std::to_string(number) + behind);
    }
    return axis;
}

/// A goal for each combination of values, called "A, B". Of one axis: a goal for each value.
template <typename... Values>
class Cross {
  public:
    Cross(CoverGroup& group, const Axis<Values>&... axes) {
        std::tuple<Values...> values;
        declare<0>(group, "", values, std::tie(axes...));
    }

    /// Throws std::out_of_range for a value that is on no axis.
    const Bin& operator()(Values... values) const { return bins_.at({values...}); }

  private:
    template <std::size_t Place>
    void declare(CoverGroup& group, const std::string& name, std::tuple<Values...>& values,
                 const std::tuple<const Axis<Values>&...>& axes) {
        if constexpr (Place == sizeof...(Values)) {
            bins_.emplace(values, group.bin(name));
        } else {
            for (const auto& [value, value_name] : std::get<Place>(axes)) {
                std::get<Place>(values) = value;
                declare<Place + 1>(group, Place == 0 ? value_name : name + ", " + value_name, values, axes);
            }
        }
    }

    std::map<std::tuple<Values...>, Bin> bins_;
};

/// A goal for each range that a number can lie in.
class Ranges {
  public:
    struct Range {
        std::int64_t first;  ///< its end is the next one's first; the last has none
        const char* name;
    };
    Ranges(CoverGroup& group, std::initializer_list<Range> ranges) {
        for (const Range& range : ranges) bins_.emplace(range.first, group.bin(range.name));
    }

    /// number: not below the first range.
    const Bin& operator()(std::int64_t number) const { return std::prev(bins_.upper_bound(number))->second; }

  private:
    std::map<std::int64_t, Bin> bins_;
};

}  // namespace metabuffer::coverage
