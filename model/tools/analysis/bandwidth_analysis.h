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
    double sum = 0.0;  ///< of C / T over all tasks
    double most_at_once =
        0.0;  ///< the same over the composers that one raster row meets: the largest of all rows
    double busiest_row =
        0.0;            ///< source pixels that one raster row is the first to show: the largest of all rows
    double mean = 0.0;  ///< over the whole frame
    std::int64_t pixels = 0;  ///< in a frame
};

/// What the bus can carry, for one table.
struct Supply {
    double raw = 0.0;               ///< pixels a clock: the lesser of bus and memory
    double sustained = 0.0;         ///< the same with this table's page misses and beats that are not full
    std::int64_t table_cycles = 0;  ///< of a frame: its start and its table
    std::int64_t burst_cycles = 0;  ///< of a frame: bursts with their page misses, and the arbiter's answers
    /// The same with each page opened only once: no order of the bursts takes less.
    std::int64_t least_burst_cycles = 0;
    /// Of a frame: the bus waits until a composer has answered, or for its slot table.
    std::int64_t idle_cycles = 0;
    /// The part of all clocks that refreshes take; at the least without opening a page again.
    double refresh_share = 0.0;
    double least_refresh_share = 0.0;
    /// With shared ports: the link's words. Each block opens a page and closes the burst's; at the least each page is
    /// opened once.
    struct Writes {
        double share = 0.0;                       ///< of all clocks, of a link that always sends
        std::optional<std::int64_t> pair_cycles;  ///< in lockstep, in which a frame has one pair
        /// Clocks of them in so many, in which there is one frame.
        double in(double cycles) const;
    };
    Writes writes;
    Writes least_writes;
    std::int64_t grant_cycles = 0;  ///< of burst_cycles: the arbiter's
    std::int64_t beats = 0;
    std::int64_t page_misses = 0;
    /// Bursts are never cut short, so a run has at most these clocks and misses. It may have fewer, since a page counts
    /// as missed wherever another composer's burst may have come between. False: bursts may be cut, and cost more.
    bool whole_bursts = true;

    std::int64_t frame_cycles() const;
    std::int64_t least_frame_cycles() const;
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
    std::int64_t least_buffer_pixels = 0;  ///< the smallest legal buffer
    std::int64_t whole_buffer_pixels = 0;  ///< a buffer that holds the whole segment
};

struct TableAnalysis {
    int renderer = 0;  ///< index
    std::string renderer_name;
    std::vector<int> frames;  ///< indices in the renderer's list, from 0
    std::vector<Task> tasks;
    std::vector<ComposerAnalysis> composers;  ///< in table order
    std::vector<RejectedRow> rejected;
    Demand demand;
    Supply supply;
    std::vector<int> slot_displays;  ///< the slot table, by display; empty if the policy has none
    /// Bus clocks needed in each raster clock: by the composers of the busiest raster row, or by the whole frame on the
    /// average, whichever is more. Above 1 the bus cannot keep pace: pixels must have been sent before.
    double load = 0.0;
    double rotation_cycles = 0.0;  ///< of the slot table, with average bursts

    /// Pixels of a frame that the bus cannot carry in `period_cycles`: the most, and the least that any order of the
    /// bursts leaves. 0 if it can carry them all.
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

    /// Clocks of a frame: those of the frame rate asked for, else the raster's, for frames back to back.
    double period_cycles = 0.0;
    std::optional<double> asked_frame_rate_hz;
    /// Frames a second that every bus can carry and the raster can show: for certain, and at best.
    double sustained_frame_rate_hz = 0.0;
    double best_frame_rate_hz = 0.0;
    /// Frames a second of the bus that has the most to do, if nothing else set a limit, not even the raster: as it is,
    /// if its memory took no time, and if only its memory took time.
    double supply_hz = 0.0;
    double bus_alone_hz = 0.0;
    double memory_alone_hz = 0.0;
    RateLimits limits;  ///< what displays, links and raster allow

    /// The most different frames a second that the displays can show, if buffers set no limit.
    double most_frame_rate_hz() const { return std::min(best_frame_rate_hz, limits.different_hz()); }

    std::int64_t least_buffer_pixels = 0;  ///< the smallest buffer with which no row is rejected
    std::int64_t whole_buffer_pixels = 0;  ///< the smallest buffer that holds every segment
    /// A buffer with which nothing starves in any frame of the run. Empty if nothing is proved of the arbitration.
    std::optional<std::int64_t> safe_buffer_pixels;
    std::optional<bool> safe_buffer_is_legal;  ///< a scenario may have buffers of that size
    std::optional<int> deciding_renderer;      ///< index; one of its composers needs that many
    std::optional<int> deciding_display;       ///< of that composer, from 1
    /// By what is counted for refreshes and the link's writes, a renderer's memory may be left without a clock for bursts.
    /// Then only a buffer that holds a whole segment is known to be enough for its composers.
    bool memory_may_be_taken = false;
    bool scenario_is_safe = false;  ///< it is proved that nothing starves with its own buffers
};

/// The most frames a second that one part of a machine allows, by arithmetic.
struct RateOfPart {
    std::string part;  ///< "raster", "displays", "links", "memory" or "bus"
    double frames_per_second = 0.0;
};
/// The slowest part comes first: the bottleneck.
std::vector<RateOfPart> rates_of_parts(const Analysis& analysis);

struct AnalysisOptions {
    /// Only the tables that renderers have in this frame (from 0). Empty: every different table of the run. The figures
    /// of buffers are always those of the whole run.
    std::optional<int> frame;
    /// Empty: as fast as the raster goes.
    std::optional<double> frame_rate_hz;
};

/// Takes a checked scenario (check_scenario) and raises nothing.
Analysis analyze(const Scenario& scenario, const AnalysisOptions& options = {});

}  // namespace metabuffer::analysis
