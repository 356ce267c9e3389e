#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "report/bottleneck.h"
#include "report/counters.h"
#include "report/report.h"

// Every key but "check", which only a checked run has, is always there: a level that has no clock reports zeros for what
// is counted in clocks, and empty lists for what it has no records of.

namespace metabuffer {

namespace {

using Json = nlohmann::ordered_json;
using FrameCounts = std::array<std::int64_t, kRejectCauseCount>;
using RowCounts = std::array<std::int64_t, kRowDefectCount>;

constexpr int kFirstRowDefect = static_cast<int>(RowDefect::kNone) + 1;

/// Appends an owner's counters, by their names there or among the totals.
template <typename Owner>
void put_counters(Json& json, const Owner& owner, bool among_totals = false) {
    for (const Counter<Owner>& counter : Counters<Owner>::kTable) {
        json[among_totals ? counter.name_in_totals() : counter.name] = owner.*counter.member;
    }
}

template <typename Value>
Json optional_json(const std::optional<Value>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json bus_json(const BusCounters& bus) {
    Json json = Json::object();
    put_counters(json, bus);
    json["utilization"] = bus.utilization();
    return json;
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
            {"swap_cycle", frame.swap_cycle},
            {"kept", frame.kept},
            {"latency_cycles", optional_json(frame.latency_cycles)},
            {"pairs", frame.pairs},
            {"starved_pixels", frame.starved_pixels},
            {"wrong_pixels", optional_json(frame.wrong_pixels)}};
}

Json renderer_json(const RendererCounters& renderer) {
    Json json{{"name", renderer.name},
              {"bus", bus_json(renderer.bus)},
              {"rejected_frames", rejected_frames_json(renderer.rejected_frames)},
              {"rejected_rows", rejected_rows_json(renderer.rejected_rows)},
              {"rejected_row_messages", renderer.rejected_row_messages}};
    put_counters(json, renderer);
    return json;
}

Json glitch_json(const std::optional<StarvedPixel>& glitch) {
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
    Json json{{"renderer", composer.renderer}, {"display", composer.display}};
    put_counters(json, composer);
    json["first_glitch"] = glitch_json(composer.first_glitch);
    json["starved_run_count"] = composer.starved_run_count;
    json["starved_runs"] = starved_runs_json(composer.starved_runs);
    json["starved_runs_left_out"] =
        composer.starved_run_count - static_cast<std::int64_t>(composer.starved_runs.size());
    return json;
}

Json display_json(const RunReport& report, std::size_t index) {
    Json json{{"display", index + 1}};
    const std::vector<int>& corrected = report.corrected_displays;
    json["corrected"] = std::binary_search(corrected.begin(), corrected.end(), static_cast<int>(index) + 1);
    put_counters(json, report.displays[index]);
    json["starved_pixels"] = report.starved_pixels_of_display(index);
    json["wrong_pixels"] = optional_json(report.wrong_pixels_of_display(index));
    return json;
}

/// Frames a second, with what the machine allows.
Json rates_json(const RunReport& report) {
    const FrameRates rates = report.frame_rates();
    Json json{{"frames_per_second", optional_json(rates.held_hz())},
              {"composition_hz", optional_json(rates.composition_hz)},
              {"slowest_interval_cycles", nullptr},
              {"slowest_interval_frame", nullptr},
              {"display_hz", optional_json(rates.display_hz)}};
    if (rates.slowest_interval) {
        json["slowest_interval_cycles"] = rates.slowest_interval->cycles;
        json["slowest_interval_frame"] = rates.slowest_interval->frame;
    }
    const auto limit = [&report](double (*of)(const RateLimits&)) {
        return report.rate_limits ? Json(of(*report.rate_limits)) : Json(nullptr);
    };
    json["raster_hz"] = limit([](const RateLimits& limits) { return limits.raster_hz; });
    json["refresh_hz"] = limit([](const RateLimits& limits) { return limits.refresh_hz; });
    json["pairs_per_second"] =
        report.rate_limits ? Json(report.rate_limits->pairs_per_second) : Json::array();
    return json;
}

/// What the run waited for, and for how long.
Json bottleneck_json(const RunReport& report) {
    const std::optional<Bottleneck> found = find_bottleneck(report);
    if (!found) return nullptr;
    Json cycles = Json::object();
    for (std::size_t resource = 0; resource < kResourceCount; ++resource) {
        cycles[resource_name(static_cast<Resource>(resource))] = found->cycles[resource];
    }
    return {{"resource", resource_name(found->what())}, {"share", found->share()},
            {"pixels_starve", found->starves},          {"cycles", std::move(cycles)},
            {"worst_renderer", found->supply_renderer}, {"bus_load", found->bus_load}};
}

Json cost_json(const RunReport& report) {
    if (!report.cost) return nullptr;
    Json json{{"cost", report.cost->weighted()}};
    for (const CostItem& item : cost_items()) {
        const double value = item.value(*report.cost);
        json[item.name] = item.is_whole ? Json(static_cast<std::int64_t>(value)) : Json(value);
    }
    return json;
}

Json clamped_depths_json(const RunReport& report) {
    Json json = Json::array();
    for (const auto& [file, clamped] : report.clamped_depths) {
        json.push_back({{"file", file},
                        {"before_near_pixels", clamped.before_near_pixels},
                        {"behind_far_pixels", clamped.behind_far_pixels}});
    }
    return json;
}

Json totals_json(const RunReport& report) {
    const RendererCounters renderers = report.total_renderer();
    Json json{{"bus", bus_json(report.total_bus())},
              {"rejected_frames", rejected_frames_json(renderers.rejected_frames)},
              {"rejected_rows", rejected_rows_json(renderers.rejected_rows)}};
    put_counters(json, renderers, true);
    put_counters(json, report.total_composer(), true);
    put_counters(json, report.total_display(), true);
    json["wrong_pixels"] = optional_json(report.total_wrong_pixels());
    return json;
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
    for (std::size_t index = 0; index < report.displays.size(); ++index) {
        displays.push_back(display_json(report, index));
    }

    Json json;
    json["scenario"] = report.scenario;
    json["level"] = report.level;
    json["core_cycles"] = report.core_cycles;
    json["core_mhz"] = report.core_mhz;
    json["buffer_pixels"] = report.buffer_pixels;
    json["rates"] = rates_json(report);
    json["bottleneck"] = bottleneck_json(report);
    json["cost"] = cost_json(report);
    json["frames"] = std::move(frames);
    json["renderers"] = std::move(renderers);
    json["composers"] = std::move(composers);
    json["displays"] = std::move(displays);
    json["totals"] = totals_json(report);
    json["clamped_depths"] = clamped_depths_json(report);
    json["watchdog"] = report.watchdog;
    if (report.check) {
        json["check"] = {{"rules", report.check->rules},
                         {"pictures", report.check->pictures},
                         {"violations", report.check->violations},
                         {"first_violations", report.check->first_violations}};
    }
    // Names come from the user's file and need not be UTF-8: invalid bytes are replaced, not refused.
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace metabuffer
