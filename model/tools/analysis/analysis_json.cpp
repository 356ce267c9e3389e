#include <nlohmann/json.hpp>
#include <string>

#include "scenario/names.h"
#include "tools/analysis/analysis_report.h"

namespace metabuffer::analysis {
namespace {

using Json = nlohmann::ordered_json;

template <typename Value>
Json optional_json(const std::optional<Value>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json task_json(const Task& task) {
    return {{"task", task.label},
            {"data_pixels", task.data_pixels},
            {"period_cycles", task.period_cycles},
            {"deadline_cycles", task.deadline_cycles},
            {"displays", task.displays}};
}

Json composer_json(const ComposerAnalysis& composer) {
    const ViewportRow& row = composer.row;
    return {{"display", row.dcomp},
            {"task", composer.task},
            {"row", {row.dcomp, row.sx, row.sy, row.sdx, row.sdy, row.dx, row.dy, row.dmultiple}},
            {"pixels", composer.pixels},
            {"bursts", composer.bursts},
            {"page_misses", composer.page_misses},
            {"bus_cycles", composer.bus_cycles},
            {"slots", composer.slots},
            {"least_buffer_pixels", composer.least_buffer_pixels},
            {"whole_buffer_pixels", composer.whole_buffer_pixels}};
}

Json rejected_json(const RejectedRow& row) {
    return {{"row", row.index}, {"cause", row_defect_key(row.defect)}, {"message", row.message}};
}

template <typename Items, typename Convert>
Json list_json(const Items& items, Convert convert) {
    Json list = Json::array();
    for (const auto& item : items) list.push_back(convert(item));
    return list;
}

Json table_json(const TableAnalysis& table, const Analysis& analysis) {
    const double period = analysis.period_cycles;
    return {{"renderer", table.renderer_name},
            {"frames", table.frames},
            {"tasks", list_json(table.tasks, task_json)},
            {"demand",
             {{"sum_pixels_per_cycle", table.demand.sum},
              {"most_at_once_pixels_per_cycle", table.demand.most_at_once},
              {"busiest_row_pixels_per_cycle", table.demand.busiest_row},
              {"mean_pixels_per_cycle", table.demand.mean},
              {"pixels_per_frame", table.demand.pixels}}},
            {"supply",
             {{"raw_pixels_per_cycle", table.supply.raw},
              {"sustained_pixels_per_cycle", table.supply.sustained},
              {"table_cycles", table.supply.table_cycles},
              {"burst_cycles", table.supply.burst_cycles},
              {"least_burst_cycles", table.supply.least_burst_cycles},
              {"idle_cycles", table.supply.idle_cycles},
              {"refresh_share", table.supply.refresh_share},
              {"write_share", table.supply.writes.in(period) / period},
              {"beats", table.supply.beats},
              {"page_misses", table.supply.page_misses},
              {"whole_bursts", table.supply.whole_bursts},
              {"frame_load", static_cast<double>(table.supply.frame_cycles()) / period},
              {"busiest_load", table.load},
              {"most_pixels_short_per_frame", table.most_pixels_short(period)},
              {"least_pixels_short_per_frame", table.least_pixels_short(period)},
              {"most_pixels_short_per_cycle", table.most_pixels_short(period) / period},
              {"least_pixels_short_per_cycle", table.least_pixels_short(period) / period}}},
            {"slot_table", {{"displays", table.slot_displays}, {"rotation_cycles", table.rotation_cycles}}},
            {"composers", list_json(table.composers, composer_json)},
            {"rejected_rows", list_json(table.rejected, rejected_json)}};
}

}  // namespace

std::string analysis_json(const Analysis& analysis) {
    Json json = {{"scenario", analysis.scenario},
                 {"core_mhz", analysis.core_mhz},
                 {"raster_width_pixels", analysis.raster_width_pixels},
                 {"raster_height_pixels", analysis.raster_height_pixels},
                 {"arbitration", to_string(analysis.bus.arbitration)},
                 {"burst_pixels", analysis.bus.burst_pixels},
                 {"ready_space_pixels", analysis.composer.ready_space_pixels},
                 {"period_cycles", analysis.period_cycles},
                 {"asked_frame_rate_hz", optional_json(analysis.asked_frame_rate_hz)},
                 {"sustained_frame_rate_hz", analysis.sustained_frame_rate_hz},
                 {"best_frame_rate_hz", analysis.best_frame_rate_hz},
                 {"most_frame_rate_hz", analysis.most_frame_rate_hz()},
                 {"bottleneck", rates_of_parts(analysis).front().part},
                 {"supply_hz", analysis.supply_hz},
                 {"bus_alone_hz", analysis.bus_alone_hz},
                 {"memory_alone_hz", analysis.memory_alone_hz},
                 {"raster_hz", analysis.limits.raster_hz},
                 {"refresh_hz", analysis.limits.refresh_hz},
                 {"pairs_per_second", analysis.limits.pairs_per_second},
                 {"buffer",
                  {{"scenario_pixels", analysis.composer.buffer_pixels},
                   {"scenario_is_safe", analysis.scenario_is_safe},
                   {"least_pixels", analysis.least_buffer_pixels},
                   {"safe_pixels", optional_json(analysis.safe_buffer_pixels)},
                   {"safe_is_legal", optional_json(analysis.safe_buffer_is_legal)},
                   {"whole_segment_pixels", analysis.whole_buffer_pixels},
                   {"deciding_renderer", optional_json(analysis.deciding_renderer)},
                   {"deciding_display", optional_json(analysis.deciding_display)}}},
                 {"tables", list_json(analysis.tables, [&](const TableAnalysis& table) {
                      return table_json(table, analysis);
                  })}};
    return json.dump(2) + "\n";
}

}  // namespace metabuffer::analysis
