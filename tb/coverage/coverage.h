#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "goals.h"

namespace metabuffer::coverage {

/// How often each goal has been reached.
class Coverage {
  public:
    Coverage() : counts_(goal_count()) {}

    /// Throws std::logic_error for a name that is no goal.
    void hit(std::string_view group, std::string_view bin, std::int64_t times = 1) {
        counts_[goal_index(group, bin)] += times;
    }
    void hit_if(bool condition, std::string_view group, std::string_view bin) {
        if (condition) hit(group, bin);
    }
    std::int64_t count(std::string_view group, std::string_view bin) const {
        return counts_[goal_index(group, bin)];
    }
    std::int64_t& counter(std::size_t goal) { return counts_[goal]; }
    std::int64_t count(std::size_t goal) const { return counts_[goal]; }
    void add(const Coverage& other);

  private:
    std::vector<std::int64_t> counts_;  ///< by goal_index
};

/// A goal whose name is looked up once, for what may happen at every clock. The coverage must outlive it.
class Bin {
  public:
    Bin(Coverage& coverage, std::string_view group, std::string_view bin)
        : count_(&coverage.counter(goal_index(group, bin))) {}
    void hit() { ++*count_; }
    void hit_if(bool condition) { *count_ += condition ? 1 : 0; }

  private:
    std::int64_t* count_;
};

}  // namespace metabuffer::coverage
