#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/viewport_table.h"
#include "scenario/rate_limits.h"
#include "scenario/scenario.h"
#include "tools/analysis/task_table.h"

namespace metabuffer::analysis {

/// What the composers of one table need, in pixels a raster clock.
struct Demand {
    double sum = 0.0;           ///< of C / T over all tasks
    double most_at_once = 0.0;  ///< of C / T over the composers that a raster row meets, in the row of most
    double busiest_row = 0.0;   ///< pixels that one raster row is the first to show, in the row of most
    double mean = 0.0;          ///< over the whole frame
    std::int64_t pixels = 0;    ///< in a frame
};

/// What the bus can carry of a table.
struct Supply {
    double raw = 0.0;               ///< pixels a clock: the lesser of bus and memory
    double sustained = 0.0;         ///< with page misses and beats that are not full, as this table has them
    std::int64_t table_cycles = 0;  ///< of a frame: frame start and table
    std::int64_t burst_cycles = 0;  ///< of a frame: bursts with their page misses
    /// The same with each page opened once, which no order of the bursts can better.
    std::int64_t least_burst_cycles = 0;
    std::int64_t beats = 0;
    std::int64_t page_misses = 0;
    /// Bursts are never cut short, so that clocks and misses are those of the run; at most, since a page counts as
    /// missed wherever another composer's burst may have come between. False: bursts may be cut, and cost more.
    bool whole_bursts = true;

    std::int64_t frame_cycles() const { return table_cycles + burst_cycles; }
    std::int64_t least_frame_cycles() const { return table_cycles + least_burst_cycles; }
};

/// One valid row of a table.
struct ComposerAnalysis {
    ViewportRow row;
    std::string task;
    std::int64_t pixels = 0;
    std::int64_t bursts = 0;
    std::int64_t page_misses = 0;
    std::int64_t bus_cycles = 0;
    std::int64_t slots = 0;                ///< of the slot table; 0 if the policy has none
    std::int64_t least_buffer_pixels = 0;  ///< the smallest legal
    std::int64_t whole_buffer_pixels = 0;  ///< holds the whole segment whatever the bus does
};

struct TableAnalysis {
    int renderer = 0;  ///< index
    std::string renderer_name;
    std::vector<int> frames;  ///< entries of the renderer's list, from 0
    std::vector<Task> tasks;
    std::vector<ComposerAnalysis> composers;  ///< in table order
    std::vector<RejectedRow> rejected;
    Demand demand;
    Supply supply;
    std::vector<int> slot_displays;  ///< the slot table, by display; empty if the policy has none
    /// Clocks of the bus that the composers of the busiest raster row need in each clock, or the whole frame does in
    /// each of the raster's, whichever is more. Beyond 1 the bus cannot keep pace: pixels must have been sent before.
    double load = 0.0;
    double rotation_cycles = 0.0;  ///< of the slot table, with average bursts

    /// Pixels of a frame that the bus cannot carry in `period_cycles`: at most, and at least whatever the order of the
    /// bursts. 0 if it can carry them.
    double most_pixels_short(double period_cycles) const;
    double least_pixels_short(double period_cycles) const;
};

/// Section 5.1 of the paper for a scenario.
struct Analysis {
    std::string scenario;
    int renderers = 0;
    int display_columns = 0;
    int display_rows = 0;
    int raster_width_pixels = 0;
    int raster_height_pixels = 0;
    double core_mhz = 0.0;
    MemoryConfig memory;
    BusConfig bus;
    ComposerConfig composer;
    std::vector<TableAnalysis> tables;

    /// Clocks of a frame: the raster's, frames back to back, or those of the frame rate asked for.
    double period_cycles = 0.0;
    std::optional<double> asked_frame_rate_hz;
    /// Frames a second that every bus can carry, and no more than the raster can take: for certain, and at best.
    double sustained_frame_rate_hz = 0.0;
    double best_frame_rate_hz = 0.0;
    /// Frames a second if the bus were all there is, however fast the raster; without what the memory costs, and without
    /// what the bus costs. The last two are of the bus that has most to do.
    double supply_hz = 0.0;
    double bus_alone_hz = 0.0;
    double memory_alone_hz = 0.0;
    RateLimits limits;  ///< what displays, links and raster allow

    /// Different frames a second that the displays can show, if buffers do not get in the way: at best.
    double most_frame_rate_hz() const { return std::min(best_frame_rate_hz, limits.different_hz()); }

    std::int64_t least_buffer_pixels = 0;  ///< the smallest with which no row is rejected
    std::int64_t whole_buffer_pixels = 0;  ///< the smallest that holds every segment
    /// Nothing starves with these, in any frame of the run; none if nothing is proved of the arbitration.
    std::optional<std::int64_t> safe_buffer_pixels;
    std::optional<bool> safe_buffer_is_legal;  ///< a scenario may have such buffers
    std::optional<int> deciding_renderer;      ///< whose composer needs that many; index
    std::optional<int> deciding_display;       ///< from 1
    bool scenario_is_safe = false;             ///< the scenario's own buffers are known to do
};

/// What of a machine takes so many frames a second and no more, as far as arithmetic tells.
struct RateOfPart {
    std::string part;  ///< "raster", "displays", "links", "memory" or "bus"
    double frames_per_second = 0.0;
};
/// The slowest first: the bottleneck.
std::vector<RateOfPart> rates_of_parts(const Analysis& analysis);

struct AnalysisOptions {
    /// Only the tables that renderers have in this frame (from 0); none: every different table of the run. The buffer's
    /// figures are of the whole run in any case.
    std::optional<int> frame;
    /// None: as fast as the raster goes.
    std::optional<double> frame_rate_hz;
};

/// Takes a checked scenario (check_scenario) and raises nothing.
Analysis analyze(const Scenario& scenario, const AnalysisOptions& options = {});

}  // namespace metabuffer::analysis
