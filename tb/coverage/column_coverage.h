#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "coverage.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

class BusCoverage;
class ComposerCoverage;

/// What stands on a column's wires at a core clock edge, before the edge. One entry for each composer and, at the end,
/// one for the output framebuffer, from the top.
struct ColumnWires {
    std::vector<bool> pipeready;   ///< raised by the composer, at the end by the output framebuffer
    std::vector<bool> startframe;  ///< into the composer
    std::vector<bool> stall;       ///< of the composers, as they drive it
    bool column_stall = false;
    rtl::PipePixel pipe_out;  ///< into the output framebuffer
};

/// Follows one display's pipeline: who waits for whom, when it starts and when it stands still.
class ColumnCoverage {
  public:
    /// display: from 1.
    ColumnCoverage(Coverage& coverage, const Scenario& scenario, int display);

    /// A core clock edge. The composers, from the top, and the buses have sampled the edge before already.
    void clock_edge(const ColumnWires& wires, const std::vector<const ComposerCoverage*>& composers,
                    const std::vector<const BusCoverage*>& buses);

    bool stalled() const { return stalled_; }
    bool running() const { return running_; }
    /// Core clock edges at which frame k was started and ended, as far as that is seen.
    const std::vector<std::int64_t>& starts() const { return starts_; }
    const std::vector<std::int64_t>& ends() const { return ends_; }

  private:
    void cover_pipeready(const ColumnWires& wires, const std::vector<const ComposerCoverage*>& composers);
    void cover_start(const ColumnWires& wires, const std::vector<const ComposerCoverage*>& composers);
    void cover_stall(const ColumnWires& wires, const std::vector<const ComposerCoverage*>& composers,
                     const std::vector<const BusCoverage*>& buses);
    void end_stall();
    void cover_starved(const std::vector<const ComposerCoverage*>& composers);
    void cover_average(const rtl::PipePixel& pixel);

    /// What a composer's PIPEREADY goes by, at the edge sampled last.
    struct Readiness {
        bool below = false;
        bool prefetched = false;
        bool table = false;
        bool raised = false;
    };

    Coverage& coverage_;
    const Scenario& scenario_;
    int display_;
    std::int64_t edge_ = 0;
    std::vector<Readiness> readiness_;
    std::vector<bool> below_now_;  ///< PIPEREADY from below, at the edge before
    bool bottom_ready_ = false;
    std::int64_t bottom_ready_edge_ = -1;
    bool back_to_back_ = false;  ///< the latest frame, behind the one before it
    bool started_ = false;
    bool running_ = false;
    bool stalled_ = false;
    std::int64_t stalled_clocks_ = 0;
    std::int64_t moving_clocks_ = 0;
    std::vector<std::int64_t> starts_;
    std::vector<std::int64_t> ends_;
    std::vector<int>
        starved_frame_;  ///< by raster position: the frame in which some composer starved there last
    std::int64_t raster_position_ = 0;
    std::vector<int> block_sums_;  ///< by display pixel of the row: red of its raster pixels so far
};

}  // namespace metabuffer::coverage
