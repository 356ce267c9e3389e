#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datapath/link/reject_cause.h"
#include "formats/viewport_table.h"

namespace metabuffer {

/// "geometry", "magic", "version", "kind", "crc", "pair".
const char* reject_cause_key(RejectCause cause);

/// What one bus did, in core cycles. Every cycle of the run is exactly one of busy, table, page miss, poll,
/// lost or idle.
struct BusCounters {
    std::int64_t busy_cycles = 0;       ///< a pixel, or a part of one, moves
    std::int64_t table_cycles = 0;      ///< the viewport table is broadcast
    std::int64_t page_miss_cycles = 0;  ///< a burst waits for the memory to open a page
    std::int64_t poll_cycles = 0;       ///< there is something to send and no composer that takes it
    std::int64_t lost_cycles = 0;       ///< slot-allocation only: a slot whose composer cannot use it
    std::int64_t idle_cycles = 0;       ///< nothing to send
    std::int64_t page_misses = 0;
    std::int64_t pixels_sent = 0;
    std::int64_t bursts = 0;
    std::int64_t recovered_slots = 0;  ///< slots passed over and used by the next composer in the table

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
    /// Faults of the scenario that have taken effect on the renderer's link, its bus and its composers.
    std::int64_t injected_faults = 0;

    std::int64_t total_rejected_frames() const;
    std::int64_t total_rejected_rows() const;
    /// Counts the rows that a pair's table lost and keeps the messages of the first kRowMessagesKept.
    void add_rejected_rows(std::uint32_t pair, const ValidatedTable& table);
};

/// Where a raster pixel starved.
struct Glitch {
    int frame = 0;
    int x = 0;
    int y = 0;
    friend bool operator==(const Glitch& a, const Glitch& b) {
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
    std::int64_t stalled_cycles = 0;  ///< clocks this composer made its column wait
    std::int64_t buffer_high_water = 0;
    std::int64_t busready_drops = 0;   ///< bursts it cut short
    std::int64_t late_pixels = 0;      ///< arrived after their last use and were dropped
    std::int64_t replayed_pixels = 0;  ///< local pixels read again from the moving window
    std::int64_t lost_pixels = 0;      ///< sent and never arrived: their frames are not shown
    std::int64_t lost_tables = 0;      ///< whose start or a row never arrived: their frames are not shown
    std::optional<Glitch> first_glitch;
    std::optional<Glitch> last_glitch;
    std::int64_t starved_run_count = 0;
    std::vector<StarvedRun> starved_runs;  ///< the first kStarvedRunsKept

    /// Counts a starved raster pixel and where it lies. Pixels come in raster order.
    void add_glitch(const Glitch& glitch);
    /// The same for a run of them that no other touches.
    void add_starved_run(const StarvedRun& run);
};

struct DisplayCounters {
    std::int64_t frames_shown = 0;
    std::int64_t stalled_cycles = 0;  ///< clocks its column stood still
    std::int64_t kept_frames = 0;     ///< of those shown, frames of lost pixels: the picture before stayed
};

struct FrameRecord {
    int index = 0;
    std::int64_t start_cycle = 0;                ///< core cycle of the first pixel composited in any column
    std::int64_t end_cycle = 0;                  ///< core cycle of the last pixel composited in any column
    std::optional<std::int64_t> latency_cycles;  ///< from the pairs' last DVI pixel; none if no pair is new
    std::vector<int> pairs;                      ///< the pair each renderer contributed, -1: none
};

/// What checks of a run have found.
struct CheckRecord {
    static constexpr std::size_t kViolationsKept = 10;

    int rules = 0;              ///< that every wire was held to; 0: only pictures were compared
    std::int64_t pictures = 0;  ///< compared with the functional level
    std::int64_t violations = 0;
    std::vector<std::string> first_violations;  ///< a line each, the first kViolationsKept

    void add(const std::string& violation) {
        ++violations;
        if (first_violations.size() < kViolationsKept) first_violations.push_back(violation);
    }
};

/// Everything report.json tells of a run.
struct RunReport {
    std::string scenario;
    std::string level;
    double core_mhz = 0.0;
    std::int64_t core_cycles = 0;
    std::vector<FrameRecord> frames;
    std::vector<RendererCounters> renderers;
    std::vector<ComposerCounters> composers;
    std::vector<DisplayCounters> displays;
    int buffer_pixels = 0;
    std::vector<std::string> watchdog;  ///< what waited for what, if the watchdog ended the run
    std::optional<CheckRecord> check;   ///< only of a run that was checked

    std::int64_t total_starved_pixels() const;
    std::int64_t total_stalled_cycles() const;   ///< of all composers
    std::int64_t total_rejected_frames() const;  ///< for whatever cause
    std::int64_t total_rejected_rows() const;
    std::int64_t total_rejected() const;  ///< frames and rows
    std::int64_t total_repeated_frames() const;
    std::int64_t total_dropped_frames() const;
    std::int64_t total_injected_faults() const;
    BusCounters total_bus() const;            ///< the sums over all renderers
    ComposerCounters total_composer() const;  ///< the sums over all composers; the high water is the highest

    /// The frames that every display has shown.
    std::int64_t frames_shown() const;
    /// Clocks from the first pixel composited to the last, both included; 0 if no frame was composited.
    std::int64_t composition_cycles() const;
    /// Composited frames over those clocks; none if there are none.
    std::optional<double> frames_per_second() const;
};

/// The report as JSON text, keys in a fixed order.
std::string report_json(const RunReport& report);

/// The summary a run prints.
std::string report_summary(const RunReport& report);

}  // namespace metabuffer
