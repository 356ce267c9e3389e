#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "scenario/scenario.h"
#include "tools/analysis/buffer_case.h"
#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {

/// Answers whether a pixel can starve on a scenario's machine if its buffers have a given size: in any frame, at
/// whatever frame rate results. The scenario's own buffer_pixels and on_starvation do not matter. docs/analysis.md has
/// the derivation and what it assumes.
class BufferBound {
  public:
    /// Takes the tables that a run of the scenario can come to. It leaves out the rows that the scenario would reject
    /// with any buffer.
    explicit BufferBound(const Scenario& scenario) : BufferBound(scenario, MachineFigures(scenario)) {}
    BufferBound(const Scenario& scenario, const MachineFigures& machine);

    /// The different tables of the renderers, in the order of renderers and frames.
    const std::vector<BusTable>& tables() const { return tables_; }

    /// The smallest buffer with which no row is rejected, see least_buffer_pixels().
    std::int64_t smallest_legal_pixels() const;
    /// The smallest buffer that holds each segment as a whole, and so never starves.
    std::int64_t whole_segment_pixels() const;

    /// True: a machine with these buffers never starves. False: it may, or may not.
    bool is_safe(std::int64_t buffer_pixels) const;

    struct Result {
        std::int64_t pixels = 0;
        /// A composer for which one pixel less is not known to be enough. Empty at the smallest legal size.
        std::optional<int> renderer;  ///< index
        std::optional<int> display;   ///< from 1
    };
    /// The smallest safe size that a search finds. Empty if nothing is proved of the policy; whole_segment_pixels() is
    /// safe even then.
    std::optional<Result> find() const;

  private:
    struct RowIndex {
        std::size_t table = 0;
        std::size_t row = 0;
    };
    /// When a composer is prefetched, in clocks.
    class FillTimes;

    std::optional<RowIndex> find_unsafe(std::int64_t buffer_pixels) const;
    BufferCase case_of(RowIndex index, std::int64_t buffer_pixels, const FillTimes& fill) const;
    double refill_pixels(const BusTable& table, std::size_t row) const;

    MachineFigures machine_;
    std::vector<BusTable> tables_;
    std::size_t renderers_ = 0;
    std::size_t displays_ = 0;
    bool several_frames_ = false;
    std::vector<std::vector<double>> refills_;  ///< by table and row
    mutable std::optional<RowIndex> suspect_;   ///< was unsafe last, so it is checked first
};

}  // namespace metabuffer::analysis
