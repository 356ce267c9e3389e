#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "tools/exploration/results_database.h"

namespace metabuffer::exploration {

/// How the points of an exploration ended, in numbers. Its size does not grow with their number.
class Outcomes {
  public:
    /// The most failed points that are kept.
    static constexpr std::size_t kKeptFailures = 8;

    /// number: that of the point in the plan.
    void add(std::size_t number, const PointRecord& point);

    const std::map<RunStatus, std::size_t>& counts() const { return counts_; }
    std::size_t not_monotonic() const { return not_monotonic_; }
    /// How many points wait most for each resource, by its name.
    const std::map<std::string, std::size_t>& bottlenecks() const { return bottlenecks_; }
    /// Points whose buses are wider than memory fills.
    std::size_t with_idle_bus_bits() const { return with_idle_bus_bits_; }
    /// Points whose pictures are whole, of those that have figures.
    std::size_t whole() const { return whole_; }
    std::size_t with_figures() const { return with_figures_; }
    /// The first points that did not end well, by their number in the plan.
    const std::map<std::size_t, PointRecord>& failures() const { return failures_; }
    std::size_t failed() const { return failed_; }
    /// Whether no point made a valid scenario.
    bool all_invalid() const;

  private:
    std::map<RunStatus, std::size_t> counts_;
    std::map<std::string, std::size_t> bottlenecks_;
    std::map<std::size_t, PointRecord> failures_;
    std::size_t failed_ = 0;
    std::size_t not_monotonic_ = 0;
    std::size_t with_idle_bus_bits_ = 0;
    std::size_t with_figures_ = 0;
    std::size_t whole_ = 0;
};

}  // namespace metabuffer::exploration
