#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datapath/link/reject_cause.h"
#include "formats/image.h"
#include "formats/pixel.h"
#include "formats/viewport_table.h"
#include "report/machine_cost.h"
#include "scenario/rate_limits.h"

namespace metabuffer {

/// "geometry", "magic", "version", "kind", "crc", "pair".
const char* reject_cause_key(RejectCause cause);

// counters.h says of each counter what it counts, in which unit, and what the total over the machine is.

/// What one bus did. Every core cycle of the run is exactly one of busy, table, page miss, refresh, write, grant, poll,
/// lost or idle.
struct BusCounters {
    std::int64_t busy_cycles = 0;
    std::int64_t table_cycles = 0;
    std::int64_t page_miss_cycles = 0;
    std::int64_t refresh_cycles = 0;
    std::int64_t write_cycles = 0;
    std::int64_t grant_cycles = 0;
    std::int64_t poll_cycles = 0;
    std::int64_t lost_cycles = 0;
    std::int64_t idle_cycles = 0;
    std::int64_t page_misses = 0;
    std::int64_t pixels_sent = 0;
    std::int64_t bursts = 0;
    std::int64_t recovered_slots = 0;

    /// Cycles with something to send: all but the idle ones.
    std::int64_t wanted_cycles() const;
    /// Share of the cycles with something to send in which pixels moved; 0 when there were none.
    double utilization() const;
};

constexpr std::size_t kRowMessagesKept = 16;

struct RendererCounters {
    std::string name;
    BusCounters bus;
    std::array<std::int64_t, kRejectCauseCount> rejected_frames{};
    std::array<std::int64_t, kRowDefectCount> rejected_rows{};  ///< [kNone] stays 0
    std::vector<std::string> rejected_row_messages;             ///< "pair 0, row 2: ...", the first few
    std::int64_t repeated_frames = 0;
    std::int64_t dropped_frames = 0;
    std::int64_t rejected_slot_tables = 0;
    std::int64_t injected_faults = 0;

    std::int64_t total_rejected_frames() const;
    std::int64_t total_rejected_rows() const;
    /// Frames, rows and slot tables.
    std::int64_t total_rejected() const;
    /// Counts the rows that a pair's table lost and keeps the messages of the first kRowMessagesKept.
    void add_rejected_rows(std::uint32_t pair, const ValidatedTable& table);
};

struct StarvedPixel {
    int frame = 0;
    int x = 0;
    int y = 0;
    friend bool operator==(const StarvedPixel& a, const StarvedPixel& b) {
        return a.frame == b.frame && a.x == b.x && a.y == b.y;
    }
};

/// Starved raster pixels x_first..x_last of one raster row.
struct StarvedRun {
    int frame = 0;
    int y = 0;
    int x_first = 0;
    int x_last = 0;
    friend bool operator==(const StarvedRun& a, const StarvedRun& b) {
        return a.frame == b.frame && a.y == b.y && a.x_first == b.x_first && a.x_last == b.x_last;
    }
};
/// How many of a composer's runs are kept; all are counted.
constexpr std::int64_t kStarvedRunsKept = 1024;

struct ComposerCounters {
    int renderer = 0;  ///< from 1
    int display = 0;   ///< from 1
    std::int64_t starved_pixels = 0;
    std::int64_t stalled_cycles = 0;
    std::int64_t buffer_high_water = 0;
    std::int64_t busready_drops = 0;
    std::int64_t late_pixels = 0;
    std::int64_t replayed_pixels = 0;
    std::int64_t lost_pixels = 0;
    std::int64_t lost_tables = 0;
    std::optional<StarvedPixel> first_glitch;
    std::optional<StarvedPixel> last_glitch;
    std::int64_t starved_run_count = 0;
    std::vector<StarvedRun> starved_runs;          ///< the first kStarvedRunsKept
    std::vector<std::int64_t> starved_by_frame{};  ///< pixels, up to the last frame that has any

    std::int64_t starved_pixels_of(int frame) const {
        const auto f = static_cast<std::size_t>(frame);
        return f < starved_by_frame.size() ? starved_by_frame[f] : 0;
    }
    /// Counts a starved raster pixel and its position. Pixels come in raster order.
    void add_starved_pixel(const StarvedPixel& pixel);
    /// The same for a run of pixels that touches no other run.
    void add_starved_run(const StarvedRun& run);

  private:
    void add_starved_pixels(int frame, std::int64_t pixels);
};

struct DisplayCounters {
    std::int64_t frames_shown = 0;
    std::int64_t stalled_cycles = 0;
    std::int64_t kept_frames = 0;
};

struct FrameRecord {
    int index = 0;
    std::int64_t start_cycle = 0;  ///< core cycle of the first pixel composited in any column
    std::int64_t end_cycle = 0;    ///< core cycle of the last pixel composited in any column
    std::int64_t swap_cycle = 0;   ///< core cycle in which the displays switched to it
    bool kept = false;             ///< the displays kept the picture before: pixels or tables were lost
    std::optional<std::int64_t> latency_cycles;  ///< from the pairs' last DVI pixel; none if no pair is new
    std::vector<int> pairs;                      ///< the pair each renderer contributed, -1: none
    std::vector<std::int64_t> starved_pixels{};  ///< by display: of its raster, over its composers
    /// By display: shown pixels that differ from those of a machine in which nothing starves and no link errs. None if the
    /// pictures were not compared.
    std::optional<std::vector<std::int64_t>> wrong_pixels = std::nullopt;
};

/// The longest time between the starts of two frames that follow each other.
struct SlowestInterval {
    std::int64_t cycles = 0;
    int frame = 0;    ///< the one that begins at its end
    double hz = 0.0;  ///< no more than displays, links and raster allow
};

/// Frames that a run must have for all of FrameRates.
constexpr int kFramesForRates = 3;

/// How fast frames came in a run. No rate is higher than displays, links and raster allow. A few frames may begin
/// closer together than many can, since the first ones need not wait for a display.
struct FrameRates {
    std::optional<double>
        composition_hz;  ///< from the first frame's start to the last one's; with two frames or more
    std::optional<SlowestInterval> slowest_interval;
    std::optional<double>
        display_hz;  ///< different frames shown, from the second swap to the last; with three or more

    /// The least of the three, if all are there: it must reach a goal in frames a second for the goal to be met.
    std::optional<double> held_hz() const;
};

/// What checks of a run have found.
struct CheckRecord {
    static constexpr std::size_t kViolationsKept = 10;

    int rules = 0;              ///< that every wire was checked against; 0: only pictures were compared
    std::int64_t pictures = 0;  ///< compared with the functional level
    std::int64_t violations = 0;
    std::vector<std::string> first_violations;  ///< a line each, the first kViolationsKept

    void add(const std::string& violation) {
        ++violations;
        if (first_violations.size() < kViolationsKept) first_violations.push_back(violation);
    }
};

/// Depths of an image's file that lay outside of the depth range.
struct ImageDepths {
    std::string file;  ///< of Z
    ClampedDepths clamped;
};

/// Everything that report.json reports of a run.
struct RunReport {
    std::string scenario;
    std::string level;
    double core_mhz = 0.0;
    std::int64_t core_cycles = 0;
    std::optional<RateLimits> rate_limits;  ///< none of a level that has no clock
    std::int64_t raster_pixels = 0;         ///< of one display
    int memory_words_per_cycle = 1;
    int bus_width_bits = kPixelBits;
    bool is_reset = false;  ///< a fault resets the machine: counters go on, frames count from 0 again
    std::optional<MachineCost> cost;  ///< none of a report that is not of a machine
    std::vector<FrameRecord> frames;
    std::vector<RendererCounters> renderers;
    std::vector<ComposerCounters> composers;
    std::vector<DisplayCounters> displays;
    std::vector<int> corrected_displays{};  ///< from 1, ascending: those whose colours are corrected
    int buffer_pixels = 0;
    std::vector<ImageDepths> clamped_depths{};  ///< of the images that were read and have such depths
    std::vector<std::string> watchdog;          ///< what waited for what, if the watchdog ended the run
    std::optional<CheckRecord> check;           ///< only of a run that was checked

    // Totals over the machine; lists of positions and messages stay empty.
    BusCounters total_bus() const;
    RendererCounters total_renderer() const;  ///< without the bus
    ComposerCounters total_composer() const;
    DisplayCounters total_display() const;
    std::int64_t total_starved_pixels() const { return total_composer().starved_pixels; }
    /// None if a frame in which pixels starved was not compared.
    std::optional<std::int64_t> total_wrong_pixels() const;
    std::optional<std::int64_t> wrong_pixels_of_display(std::size_t display) const;  ///< index
    std::int64_t starved_pixels_of_display(std::size_t display) const;
    std::int64_t total_stalled_cycles() const {
        return total_composer().stalled_cycles;
    }  ///< of all composers
    std::int64_t total_rejected_frames() const { return total_renderer().total_rejected_frames(); }
    std::int64_t total_rejected_rows() const { return total_renderer().total_rejected_rows(); }
    std::int64_t total_rejected() const { return total_renderer().total_rejected(); }

    /// The frames that every display has shown.
    std::int64_t frames_shown() const;
    /// Clocks from the first pixel composited to the last, both included; 0 if no frame was composited.
    std::int64_t composition_cycles() const;
    FrameRates frame_rates() const;
};

/// A line about a bus that is wider than its memory fills; empty for any other bus.
std::string idle_bus_line(int width_bits, int words_per_cycle);

/// The report as JSON text, keys in a fixed order.
std::string report_json(const RunReport& report);

/// The summary a run prints.
std::string report_summary(const RunReport& report);

}  // namespace metabuffer
