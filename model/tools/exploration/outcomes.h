#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "tools/exploration/results_database.h"

namespace metabuffer::exploration {

/// How the points of an exploration ended, in numbers. It does not grow with them.
class Outcomes {
  public:
    /// Failed points that are kept.
    static constexpr std::size_t kKeptFailures = 8;

    /// number: of the point in the plan.
    void add(std::size_t number, const PointRecord& point);

    const std::map<RunStatus, std::size_t>& counts() const { return counts_; }
    std::size_t not_monotonic() const { return not_monotonic_; }
    /// Points by what they wait for most.
    const std::map<std::string, std::size_t>& bottlenecks() const { return bottlenecks_; }
    /// The first of those that did not end well, in the order of the plan.
    const std::map<std::size_t, PointRecord>& failures() const { return failures_; }
    std::size_t failed() const { return failed_; }
    /// Whether no point made a scenario.
    bool all_invalid() const;

  private:
    std::map<RunStatus, std::size_t> counts_;
    std::map<std::string, std::size_t> bottlenecks_;
    std::map<std::size_t, PointRecord> failures_;
    std::size_t failed_ = 0;
    std::size_t not_monotonic_ = 0;
};

}  // namespace metabuffer::exploration
