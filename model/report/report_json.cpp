#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/report.h"

// Every key but "check", which only a checked run has, is always there: a level that has no clock reports zeros for what is counted in clocks, and empty
// lists for what it has no records of.

namespace metabuffer {

namespace {

using Json = nlohmann::ordered_json;
using FrameCounts = std::array<std::int64_t, kRejectCauseCount>;
using RowCounts = std::array<std::int64_t, kRowDefectCount>;

constexpr int kFirstRowDefect = static_cast<int>(RowDefect::kNone) + 1;

Json bus_json(const BusCounters& bus) {
    return {{"busy_cycles", bus.busy_cycles},
            {"table_cycles", bus.table_cycles},
            {"page_miss_cycles", bus.page_miss_cycles},
            {"poll_cycles", bus.poll_cycles},
            {"lost_cycles", bus.lost_cycles},
            {"idle_cycles", bus.idle_cycles},
            {"page_misses", bus.page_misses},
            {"pixels_sent", bus.pixels_sent},
            {"bursts", bus.bursts},
            {"recovered_slots", bus.recovered_slots},
            {"utilization", bus.utilization()}};
}

Json rejected_frames_json(const FrameCounts& counts) {
    Json json = Json::object();
    for (int cause = 0; cause < kRejectCauseCount; ++cause) {
        json[reject_cause_key(static_cast<RejectCause>(cause))] = counts[static_cast<std::size_t>(cause)];
    }
    return json;
}

Json rejected_rows_json(const RowCounts& counts) {
    Json json = Json::object();
    for (int defect = kFirstRowDefect; defect < kRowDefectCount; ++defect) {
        json[row_defect_key(static_cast<RowDefect>(defect))] = counts[static_cast<std::size_t>(defect)];
    }
    return json;
}

Json frame_json(const FrameRecord& frame) {
    return {{"index", frame.index},
            {"start_cycle", frame.start_cycle},
            {"end_cycle", frame.end_cycle},
            {"latency_cycles", frame.latency_cycles ? Json(*frame.latency_cycles) : Json(nullptr)},
            {"pairs", frame.pairs}};
}

Json renderer_json(const RendererCounters& renderer) {
    return {{"name", renderer.name},
            {"bus", bus_json(renderer.bus)},
            {"rejected_frames", rejected_frames_json(renderer.rejected_frames)},
            {"rejected_rows", rejected_rows_json(renderer.rejected_rows)},
            {"rejected_row_messages", renderer.rejected_row_messages},
            {"repeated_frames", renderer.repeated_frames},
            {"dropped_frames", renderer.dropped_frames},
            {"injected_faults", renderer.injected_faults}};
}

Json glitch_json(const std::optional<Glitch>& glitch) {
    if (!glitch) return nullptr;
    return {{"frame", glitch->frame}, {"x", glitch->x}, {"y", glitch->y}};
}

Json starved_runs_json(const std::vector<StarvedRun>& runs) {
    Json json = Json::array();
    for (const StarvedRun& run : runs) {
        // A string, since the printer would spread four numbers over six lines.
        json.push_back("frame " + std::to_string(run.frame) + ", y " + std::to_string(run.y) + ", x " +
                       std::to_string(run.x_first) + ".." + std::to_string(run.x_last));
    }
    return json;
}

Json composer_json(const ComposerCounters& composer) {
    return {{"renderer", composer.renderer},
            {"display", composer.display},
            {"starved_pixels", composer.starved_pixels},
            {"stalled_cycles", composer.stalled_cycles},
            {"buffer_high_water", composer.buffer_high_water},
            {"busready_drops", composer.busready_drops},
            {"late_pixels", composer.late_pixels},
            {"replayed_pixels", composer.replayed_pixels},
            {"lost_pixels", composer.lost_pixels},
            {"lost_tables", composer.lost_tables},
            {"first_glitch", glitch_json(composer.first_glitch)},
            {"starved_run_count", composer.starved_run_count},
            {"starved_runs", starved_runs_json(composer.starved_runs)}};
}

Json display_json(int display, const DisplayCounters& counters) {
    return {{"display", display},
            {"frames_shown", counters.frames_shown},
            {"stalled_cycles", counters.stalled_cycles},
            {"kept_frames", counters.kept_frames}};
}

/// Sums over the machine; the buffers' high water is the highest. A display's stalled clocks are its
/// column's, so they have a key of their own beside the composers'.
Json totals_json(const RunReport& report) {
    FrameCounts frames{};
    RowCounts rows{};
    for (const RendererCounters& renderer : report.renderers) {
        for (std::size_t n = 0; n < frames.size(); ++n) frames[n] += renderer.rejected_frames[n];
        for (std::size_t n = 0; n < rows.size(); ++n) rows[n] += renderer.rejected_rows[n];
    }

    const ComposerCounters composers = report.total_composer();
    DisplayCounters displays;
    for (const DisplayCounters& display : report.displays) {
        displays.frames_shown += display.frames_shown;
        displays.stalled_cycles += display.stalled_cycles;
        displays.kept_frames += display.kept_frames;
    }

    return {{"bus", bus_json(report.total_bus())},
            {"rejected_frames", rejected_frames_json(frames)},
            {"rejected_rows", rejected_rows_json(rows)},
            {"repeated_frames", report.total_repeated_frames()},
            {"dropped_frames", report.total_dropped_frames()},
            {"injected_faults", report.total_injected_faults()},
            {"starved_pixels", composers.starved_pixels},
            {"stalled_cycles", composers.stalled_cycles},
            {"buffer_high_water", composers.buffer_high_water},
            {"busready_drops", composers.busready_drops},
            {"late_pixels", composers.late_pixels},
            {"replayed_pixels", composers.replayed_pixels},
            {"lost_pixels", composers.lost_pixels},
            {"lost_tables", composers.lost_tables},
            {"frames_shown", displays.frames_shown},
            {"display_stalled_cycles", displays.stalled_cycles},
            {"kept_frames", displays.kept_frames}};
}

}  // namespace

std::string report_json(const RunReport& report) {
    Json frames = Json::array();
    for (const FrameRecord& frame : report.frames) frames.push_back(frame_json(frame));
    Json renderers = Json::array();
    for (const RendererCounters& renderer : report.renderers) renderers.push_back(renderer_json(renderer));
    Json composers = Json::array();
    for (const ComposerCounters& composer : report.composers) composers.push_back(composer_json(composer));
    Json displays = Json::array();
    for (const DisplayCounters& display : report.displays) {
        displays.push_back(display_json(static_cast<int>(displays.size()) + 1, display));
    }

    Json json;
    json["scenario"] = report.scenario;
    json["level"] = report.level;
    json["core_cycles"] = report.core_cycles;
    json["core_mhz"] = report.core_mhz;
    json["buffer_pixels"] = report.buffer_pixels;
    json["frames"] = std::move(frames);
    json["renderers"] = std::move(renderers);
    json["composers"] = std::move(composers);
    json["displays"] = std::move(displays);
    json["totals"] = totals_json(report);
    json["watchdog"] = report.watchdog;
    if (report.check) {
        json["check"] = {{"rules", report.check->rules},
                         {"pictures", report.check->pictures},
                         {"violations", report.check->violations},
                         {"first_violations", report.check->first_violations}};
    }
    // Names come from the user's file and need not be UTF-8: what is not is replaced, not refused.
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace metabuffer
