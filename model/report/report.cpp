#include "report/report.h"

#include <numeric>

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

double BusCounters::utilization() const {
    const std::int64_t wanted = busy_cycles + table_cycles + page_miss_cycles + poll_cycles + lost_cycles;
    return wanted == 0 ? 0.0 : static_cast<double>(busy_cycles) / static_cast<double>(wanted);
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

std::int64_t RunReport::total_starved_pixels() const {
    return std::accumulate(
        composers.begin(), composers.end(), std::int64_t{0},
        [](std::int64_t sum, const ComposerCounters& composer) { return sum + composer.starved_pixels; });
}

std::int64_t RunReport::total_stalled_cycles() const {
    std::int64_t total = 0;
    for (const ComposerCounters& composer : composers) total += composer.stalled_cycles;
    return total;
}

std::int64_t RunReport::total_rejected() const {
    std::int64_t sum = 0;
    for (const RendererCounters& renderer : renderers) {
        sum = std::accumulate(renderer.rejected_frames.begin(), renderer.rejected_frames.end(), sum);
        sum = std::accumulate(renderer.rejected_rows.begin(), renderer.rejected_rows.end(), sum);
    }
    return sum;
}

BusCounters RunReport::total_bus() const {
    BusCounters total;
    for (const RendererCounters& renderer : renderers) {
        const BusCounters& bus = renderer.bus;
        total.busy_cycles += bus.busy_cycles;
        total.table_cycles += bus.table_cycles;
        total.page_miss_cycles += bus.page_miss_cycles;
        total.poll_cycles += bus.poll_cycles;
        total.lost_cycles += bus.lost_cycles;
        total.idle_cycles += bus.idle_cycles;
        total.page_misses += bus.page_misses;
        total.pixels_sent += bus.pixels_sent;
        total.bursts += bus.bursts;
        total.recovered_slots += bus.recovered_slots;
    }
    return total;
}

}  // namespace metabuffer
