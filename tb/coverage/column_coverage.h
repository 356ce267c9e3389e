#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cover_group.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"
#include "shared_groups.h"

namespace metabuffer::coverage {

class BusCoverage;
class ComposerCoverage;

struct PipereadyGoals : CoverGroup {
    explicit PipereadyGoals(Coverage& coverage) : CoverGroup(coverage, groups::kPipeready) {}
    Bin waited_for_below = bin("waited for below");
    Bin waited_for_prefetch = bin("waited for the prefetch");
    Bin both_at_once = bin("both in the same clock");
    Bin segment_in_buffer = bin("segment wholly in the buffer");
    Bin buffer_filled = bin("buffer takes no further slot");
    Bin segment_empty = bin("segment empty");
    Bin table_last = bin("table comes last");
    Bin single_composer = bin("single composer in the column");
};

struct BackToBackGoals : CoverGroup {
    explicit BackToBackGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSequence) {}
    Bin prefetched_first = bin("all prefetched before PIPEREADY from below");
    Bin two_frames = bin("back to back: STARTFRAME at the earliest clock behind a frame");
    Bin three_frames = bin("three frames back to back");
};

struct ColumnStallGoals : CoverGroup {
    explicit ColumnStallGoals(Coverage& coverage) : CoverGroup(coverage, groups::kStall) {}
    Ranges clocks{*this, {{1, "for one clock"}, {2, "for 2 to 8 clocks"}, {9, "for more than 8 clocks"}}};
    Bin two_composers = bin("two composers at once");
    Bin bus_silent = bin("bus sends nothing");
    Bin bus_opens_page = bin("bus opens a page");
    Bin bus_serves_another = bin("bus sends to another composer");
    Bin again_after_one_clock = bin("again after one clock");
    Bin startframe_stands = bin("STARTFRAME stands still");
};

struct StarvedColumnGoals : CoverGroup {
    explicit StarvedColumnGoals(Coverage& coverage) : CoverGroup(coverage, groups::kStarvationPlace) {}
    Bin two_composers = bin("two composers of a column at one raster pixel");
};

enum class Rounding : std::uint8_t { kExact, kDown, kHalfUp, kUp };

struct AverageGoals : CoverGroup {
    explicit AverageGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSupersample) {}
    Cross<int, Rounding> rounding{*this,
                                  {{2, "2"}, {4, "4"}},
                                  {{Rounding::kExact, "exact"},
                                   {Rounding::kDown, "down"},
                                   {Rounding::kHalfUp, "half up"},
                                   {Rounding::kUp, "up"}}};
};

/// Goals of one column.
struct ColumnGoals : GoalSet {
    using GoalSet::GoalSet;
    PipereadyGoals pipeready{coverage};
    BackToBackGoals sequence{coverage};
    ColumnStallGoals stall{coverage};
    StarvedColumnGoals starved{coverage};
    AverageGoals average{coverage};
};

/// The values of a column's wires at a core clock edge, before the edge, from the top. One entry for each composer and,
/// at the end, one for the output framebuffer.
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
    /// display: from 1. Goals and scenario must outlive it.
    ColumnCoverage(const ColumnGoals& goals, const Scenario& scenario, int display);

    /// A core clock edge. The composers, from the top, and the buses have already sampled the edge before it.
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

    /// What a composer's PIPEREADY depends on, at the edge sampled last.
    struct Readiness {
        bool below = false;
        bool prefetched = false;
        bool table = false;
        bool raised = false;
    };

    const ColumnGoals& goals_;
    const Scenario& scenario_;
    int display_;
    std::int64_t edge_ = 0;
    std::vector<Readiness> readiness_;
    std::vector<bool> below_now_;  ///< PIPEREADY from below, at the edge before
    bool bottom_ready_ = false;
    std::int64_t bottom_ready_edge_ = -1;
    bool back_to_back_ = false;  ///< the latest frame, directly after the one before it
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
