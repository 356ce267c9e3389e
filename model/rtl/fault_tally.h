#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace metabuffer::rtl {

/// What each fault inside the machine has done so far, by its index in Scenario::faults. Several modules may carry out
/// one fault; it counts once.
class FaultTally {
  public:
    explicit FaultTally(std::size_t faults) : counts_(faults, 0) {}

    /// A fault that lasts has changed something; the first time counts.
    void took_effect(std::size_t fault) { counts_[fault] = std::max<std::int64_t>(counts_[fault], 1); }
    /// One part of a fault that consists of several has been done; each counts.
    void add(std::size_t fault) { ++counts_[fault]; }
    /// 0 of a fault that has joined the scenario since, as those of live links do.
    std::int64_t count(std::size_t fault) const { return fault < counts_.size() ? counts_[fault] : 0; }

  private:
    std::vector<std::int64_t> counts_;
};

}  // namespace metabuffer::rtl
