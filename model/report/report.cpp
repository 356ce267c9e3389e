#include "report/report.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "report/counters.h"

namespace metabuffer {

const char* reject_cause_key(RejectCause cause) {
    switch (cause) {
        case RejectCause::kGeometry:
            return "geometry";
        case RejectCause::kMagic:
            return "magic";
        case RejectCause::kVersion:
            return "version";
        case RejectCause::kKind:
            return "kind";
        case RejectCause::kCrc:
            return "crc";
        case RejectCause::kPair:
            return "pair";
    }
    return "unknown";
}

std::int64_t BusCounters::wanted_cycles() const {
    return busy_cycles + table_cycles + page_miss_cycles + refresh_cycles + write_cycles + grant_cycles +
           poll_cycles + lost_cycles;
}

double BusCounters::utilization() const {
    const std::int64_t wanted = wanted_cycles();
    return wanted == 0 ? 0.0 : static_cast<double>(busy_cycles) / static_cast<double>(wanted);
}

std::int64_t RendererCounters::total_rejected_frames() const {
    return std::accumulate(rejected_frames.begin(), rejected_frames.end(), std::int64_t{0});
}

std::int64_t RendererCounters::total_rejected_rows() const {
    return std::accumulate(rejected_rows.begin(), rejected_rows.end(), std::int64_t{0});
}

std::int64_t RendererCounters::total_rejected() const {
    return total_rejected_frames() + total_rejected_rows() + rejected_slot_tables;
}

void RendererCounters::add_rejected_rows(std::uint32_t pair, const ValidatedTable& table) {
    for (const RejectedRow& row : table.rejected) {
        ++rejected_rows[static_cast<std::size_t>(row.defect)];
        if (rejected_row_messages.size() < kRowMessagesKept) {
            rejected_row_messages.push_back("pair " + std::to_string(pair) + ", row " +
                                            std::to_string(row.index) + ": " + row.message);
        }
    }
}

void ComposerCounters::add_glitch(const Glitch& glitch) {
    if (starved_pixels++ == 0) first_glitch = glitch;
    const bool goes_on = last_glitch && last_glitch->frame == glitch.frame && last_glitch->y == glitch.y &&
                         last_glitch->x + 1 == glitch.x;
    last_glitch = glitch;
    if (!goes_on) {
        ++starved_run_count;
        if (starved_run_count <= kStarvedRunsKept) {
            starved_runs.push_back({glitch.frame, glitch.y, glitch.x, glitch.x});
        }
    } else if (starved_run_count <= kStarvedRunsKept) {
        starved_runs.back().x_last = glitch.x;
    }
}

void ComposerCounters::add_starved_run(const StarvedRun& run) {
    starved_pixels += run.x_last - run.x_first + 1;
    if (!first_glitch) first_glitch = Glitch{run.frame, run.x_first, run.y};
    last_glitch = Glitch{run.frame, run.x_last, run.y};
    ++starved_run_count;
    if (starved_run_count <= kStarvedRunsKept) starved_runs.push_back(run);
}

BusCounters RunReport::total_bus() const {
    BusCounters total;
    for (const RendererCounters& renderer : renderers) add_counters(total, renderer.bus);
    return total;
}

RendererCounters RunReport::total_renderer() const {
    RendererCounters total;
    const auto add = [](auto& sums, const auto& counts) {
        std::transform(sums.begin(), sums.end(), counts.begin(), sums.begin(), std::plus<>());
    };
    for (const RendererCounters& renderer : renderers) {
        add_counters(total, renderer);
        add(total.rejected_frames, renderer.rejected_frames);
        add(total.rejected_rows, renderer.rejected_rows);
    }
    return total;
}

ComposerCounters RunReport::total_composer() const {
    ComposerCounters total;
    for (const ComposerCounters& composer : composers) add_counters(total, composer);
    return total;
}

DisplayCounters RunReport::total_display() const {
    DisplayCounters total;
    for (const DisplayCounters& display : displays) add_counters(total, display);
    return total;
}

std::int64_t RunReport::frames_shown() const {
    if (displays.empty()) return 0;
    return std::min_element(displays.begin(), displays.end(),
                            [](const DisplayCounters& a, const DisplayCounters& b) {
                                return a.frames_shown < b.frames_shown;
                            })
        ->frames_shown;
}

std::int64_t RunReport::composition_cycles() const {
    // Both ends count: the last pixel is composited in the clock end_cycle.
    return frames.empty() ? 0 : frames.back().end_cycle - frames.front().start_cycle + 1;
}

std::optional<double> RunReport::frames_per_second() const {
    const std::int64_t clocks = composition_cycles();
    if (clocks <= 0) return std::nullopt;
    return core_mhz * 1.0e6 * static_cast<double>(frames.size()) / static_cast<double>(clocks);
}

}  // namespace metabuffer
