#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "host/text.h"
#include "report/report.h"
#include "report/text_table.h"
#include "scenario/names.h"
#include "tools/analysis/analysis_report.h"
#include "tools/analysis/taken_clocks.h"

namespace metabuffer::analysis {
namespace {

using text::counted;
using text::decimal;

constexpr double kPercent = 100.0;

std::string rate(double pixels_per_cycle) { return decimal(pixels_per_cycle, 3); }

std::string list_of(const std::vector<int>& numbers) {
    std::string text;
    for (const int number : numbers) text += (text.empty() ? "" : " ") + std::to_string(number);
    return text;
}

std::string frames_text(const std::vector<int>& frames) {
    return (frames.size() == 1 ? "frame " : "frames ") + text::number_runs(frames);
}

std::string percent_of(double part, double whole) { return decimal(kPercent * part / whole, 1) + " %"; }

/// A line of a list of figures: what it is, its value, a remark.
std::string figure(const std::string& name, const std::string& value, const std::string& remark = "") {
    constexpr std::size_t kNameWidth = 26;
    constexpr std::size_t kValueWidth = 10;
    std::string line = "  " + name;
    line.resize(std::max(line.size(), kNameWidth + 2), ' ');
    line += std::string(kValueWidth - std::min(kValueWidth, value.size()), ' ') + value;
    return line + (remark.empty() ? "" : "  " + remark) + "\n";
}

std::string task_lines(const TableAnalysis& table) {
    TextTable lines({0, 4});
    lines.add({"task", "C pixels", "T clocks", "D clocks", "displays"});
    for (const Task& task : table.tasks) {
        lines.add({task.label, std::to_string(task.data_pixels), std::to_string(task.period_cycles),
                   std::to_string(task.deadline_cycles), list_of(task.displays)});
    }
    return lines.text();
}

std::string composer_lines(const TableAnalysis& table) {
    TextTable lines;
    lines.add({"display", "task", "segment", "multiple", "slots", "bursts", "page misses", "bus clocks",
               "least buffer", "whole segment"});
    for (const ComposerAnalysis& composer : table.composers) {
        lines.add({std::to_string(composer.row.dcomp), composer.task,
                   std::to_string(composer.row.sdx) + "x" + std::to_string(composer.row.sdy),
                   std::to_string(composer.row.dmultiple), std::to_string(composer.slots),
                   std::to_string(composer.bursts), std::to_string(composer.page_misses),
                   std::to_string(composer.bus_cycles), std::to_string(composer.least_buffer_pixels),
                   std::to_string(composer.whole_buffer_pixels)});
    }
    return lines.text();
}

std::string rejected_lines(const TableAnalysis& table) {
    std::string text;
    for (const RejectedRow& row : table.rejected) {
        text += "  row " + std::to_string(row.index) + " rejected (" + row_defect_key(row.defect) +
                "): " + row.message + "\n";
    }
    return text;
}

/// Which of bus and memory sets the pace, and what the other one could do.
std::string raw_remark(const Analysis& analysis) {
    const double bus = static_cast<double>(analysis.bus.width_bits) / kPixelBits;
    const int memory = analysis.memory.words_per_cycle;
    if (bus == memory) return "bus and memory alike";
    return bus < memory ? "of the bus; its memory could read " + std::to_string(memory)
                        : "of the memory (memory.words_per_cycle); its bus could carry " + decimal(bus, 0);
}

/// What a frame's bursts wait for besides their own pages.
std::string interruption_lines(const Supply& supply, double period_cycles) {
    std::string text;
    if (supply.refresh_share > 0.0)
        text +=
            figure("refreshes", decimal(kPercent * supply.refresh_share, 1) + " %", "of the clocks at most");
    if (supply.writes.share > 0.0) {
        text += figure("writes of the link", percent_of(supply.writes.in(period_cycles), period_cycles),
                       "of the clocks at most");
    }
    if (supply.idle_cycles > 0) {
        text += figure("waits of the bus", std::to_string(supply.idle_cycles),
                       "clocks at most, for BUSREADY and for a slot table that is built");
    }
    return text;
}

std::string demand_lines(const TableAnalysis& table, const Analysis& analysis) {
    const Demand& demand = table.demand;
    const Supply& supply = table.supply;
    std::string text = "needed, in pixels a clock:\n";
    text += figure("sum of C / T", rate(demand.sum));
    text += figure("most at a time", rate(demand.most_at_once), "of the tasks that one raster row meets");
    text +=
        figure("busiest raster row", rate(demand.busiest_row), "source rows that begin in one raster row");
    text += figure("mean of the frame", rate(demand.mean), counted(demand.pixels, "pixel"));
    text += "carried, in pixels a clock:\n";
    text += figure("raw", rate(supply.raw), raw_remark(analysis));
    text += figure("sustained", rate(supply.sustained),
                   std::to_string(supply.page_misses) +
                       (supply.page_misses == 1 ? " page miss" : " page misses") + " and " +
                       counted(supply.beats, "beat") + " in " +
                       std::to_string(supply.frame_cycles() - supply.table_cycles) + " clocks" +
                       (supply.whole_bursts ? "" : ", if no burst is cut short"));
    text += interruption_lines(supply, analysis.period_cycles);
    const double period = analysis.period_cycles;
    text +=
        figure("load of the bus", percent_of(static_cast<double>(supply.frame_cycles()), period),
               std::to_string(supply.frame_cycles()) + " clocks of " + decimal(period, 0) + " for a frame");
    if (table.load > 1.0) {
        text += figure("at its busiest", decimal(kPercent * table.load, 1) + " %",
                       rate((table.load - 1.0) * supply.sustained) +
                           " pixels a clock too many: they must have been sent before");
    }
    const double most_short = table.most_pixels_short(period);
    const double least_short = table.least_pixels_short(period);
    if (least_short > 0.0) {
        text += figure("short in a frame", decimal(std::ceil(least_short), 0),
                       "pixels or more, " + rate(least_short / period) +
                           " a clock: the bus cannot carry them with any buffer");
    }
    if (most_short > 0.0) {
        text += figure(least_short > 0.0 ? "with page misses" : "short in a frame",
                       decimal(std::ceil(most_short), 0),
                       "pixels, " + rate(most_short / period) + " a clock, if every page counted is missed");
    }
    return text;
}

std::string slot_lines(const TableAnalysis& table) {
    constexpr std::size_t kMostSlotsShown = 64;
    if (table.slot_displays.empty()) return {};
    std::string text =
        "slot table: " + counted(static_cast<std::int64_t>(table.slot_displays.size()), "slot") +
        ", a rotation takes " + decimal(table.rotation_cycles, 1) + " clocks\n";
    if (table.slot_displays.size() <= kMostSlotsShown) {
        text += "  displays " + list_of(table.slot_displays) + "\n";
    }
    return text;
}

std::string buffer_lines(const Analysis& analysis) {
    std::string text = "composer buffers, of all renderers, in pixels:\n";
    text += figure("smallest legal", std::to_string(analysis.least_buffer_pixels));
    std::string reason;
    if (analysis.deciding_renderer) {
        reason = "decided by display " + std::to_string(*analysis.deciding_display) + " of renderer " +
                 std::to_string(*analysis.deciding_renderer + 1);
        for (const TableAnalysis& table : analysis.tables) {
            if (table.renderer == *analysis.deciding_renderer) {
                reason = "decided by display " + std::to_string(*analysis.deciding_display) + " of " +
                         table.renderer_name;
            }
        }
    }
    const bool has_bound = analysis.safe_buffer_pixels.has_value();
    if (analysis.memory_may_be_taken)
        reason += ": its memory may have no clock between refreshes and the link's writes";
    if (!has_bound) reason = "nothing is proved of " + std::string(to_string(analysis.bus.arbitration));
    text += figure("never starves with",
                   has_bound ? std::to_string(*analysis.safe_buffer_pixels) : "no bound", reason);
    text += figure("holds every segment", std::to_string(analysis.whole_buffer_pixels));
    text += figure("with on_starvation: stall", std::to_string(analysis.least_buffer_pixels),
                   "or more show the whole picture: columns wait for their pixels, which costs frame rate");
    const std::string not_safe = has_bound ? "may starve: the bound does not cover it" : "may starve";
    text += figure("this scenario", std::to_string(analysis.composer.buffer_pixels),
                   analysis.scenario_is_safe ? "never starves" : not_safe);
    if (analysis.safe_buffer_is_legal == false)
        text += "  the bound is larger than a scenario's buffers may be\n";
    return text;
}

std::string displays_remark(const RateLimits& limits) {
    const std::int64_t refreshes = limits.refreshes_per_frame();
    return decimal(limits.refresh_hz, 2) + " Hz" +
           (refreshes == 1 ? ", a new frame each time"
                           : ", a new frame every " + std::to_string(refreshes) +
                                 " times: the raster takes longer than a refresh");
}

std::string links_remark(const RateLimits& limits) {
    if (limits.pairs_per_second.size() == 1) return "pairs a second";
    return limits.pacing == Pacing::kLockstep ? "pairs a second of the slowest"
                                              : "pairs a second of all together";
}

std::string rate_verdict(const Analysis& analysis) {
    const double asked = *analysis.asked_frame_rate_hz * (1.0 - kRateTolerance);
    if (asked > analysis.most_frame_rate_hz()) {
        return "  the rate asked for cannot be held with any buffer: too slow for it: " +
               too_slow_for(analysis, asked) + "\n";
    }
    if (asked > analysis.sustained_frame_rate_hz) {
        return "  whether the rate asked for can be held depends on the page misses: run the scenario\n";
    }
    return "  the rate asked for can be carried\n";
}

std::string rate_lines(const Analysis& analysis) {
    const RateLimits& limits = analysis.limits;
    std::string text = "frame rate, in frames/s:\n";
    if (analysis.asked_frame_rate_hz) text += figure("asked for", decimal(*analysis.asked_frame_rate_hz, 2));
    text += figure("raster, back to back", decimal(limits.raster_hz, 2));
    const bool whole = analysis.composer.ready_space_pixels >= analysis.bus.burst_pixels;
    const std::string certain = whole ? "for certain" : "if no burst is cut short";
    const bool bus_is_slower = analysis.sustained_frame_rate_hz < limits.raster_hz;
    text += figure(
        "buses can carry", decimal(analysis.sustained_frame_rate_hz, 2),
        bus_is_slower ? certain : std::string("all that the raster takes") + (whole ? "" : ", " + certain));
    if (bus_is_slower)
        text += figure("at best", decimal(analysis.best_frame_rate_hz, 2), "each page opened once");
    text += figure("displays can show", decimal(limits.displays_hz(), 2), displays_remark(limits));
    text += figure("links can bring", decimal(limits.links_hz(), 2), links_remark(limits));
    text += figure("together, at most", decimal(analysis.most_frame_rate_hz(), 2));
    const std::vector<RateOfPart> parts = rates_of_parts(analysis);
    text += figure("bottleneck", parts[0].part,
                   decimal(parts[0].frames_per_second, 2) + "; then " + parts[1].part + ", " +
                       decimal(parts[1].frames_per_second, 2));
    if (analysis.asked_frame_rate_hz) text += rate_verdict(analysis);
    return text;
}

/// A line for each renderer, of the table that gives its bus the most to do; then the rejected rows of all tables.
std::string table_lines(const Analysis& analysis) {
    constexpr std::size_t kMostRenderers = 24;
    std::string rejected;
    std::map<int, std::vector<const TableAnalysis*>> by_renderer;
    for (const TableAnalysis& table : analysis.tables) {
        by_renderer[table.renderer].push_back(&table);
        if (table.rejected.empty()) continue;
        rejected += table.renderer_name + ", " + frames_text(table.frames) + "\n" + rejected_lines(table);
    }
    TextTable lines({0, 1});
    lines.add({"renderer", "of", "pixels a frame", "bus clocks", "load", "at its busiest", "page misses"});
    std::size_t shown = 0;
    for (const auto& [renderer, tables] : by_renderer) {
        if (shown++ == kMostRenderers) break;
        const TableAnalysis& table = **std::max_element(
            tables.begin(), tables.end(), [](const TableAnalysis* a, const TableAnalysis* b) {
                return a->supply.frame_cycles() < b->supply.frame_cycles();
            });
        const std::string others =
            tables.size() == 1 ? "" : ", the most of " + std::to_string(tables.size()) + " tables";
        lines.add({table.renderer_name, frames_text(table.frames) + others,
                   std::to_string(table.demand.pixels), std::to_string(table.supply.frame_cycles()),
                   percent_of(static_cast<double>(table.supply.frame_cycles()), analysis.period_cycles),
                   decimal(kPercent * table.load, 1) + " %", std::to_string(table.supply.page_misses)});
    }
    std::string text =
        "buses, in % of a frame's " + decimal(analysis.period_cycles, 0) + " clocks:\n" + lines.text();
    if (by_renderer.size() > kMostRenderers) {
        text += "  ... and " + std::to_string(by_renderer.size() - kMostRenderers) +
                " renderers more, see --details\n";
    }
    return text + rejected;
}

std::string table_details(const TableAnalysis& table, const Analysis& analysis) {
    const std::string title = "renderer " + table.renderer_name + ", " + frames_text(table.frames) + "\n";
    if (table.composers.empty()) return title + rejected_lines(table) + "  sends nothing\n";
    return title + rejected_lines(table) + task_lines(table) + demand_lines(table, analysis) +
           slot_lines(table) + composer_lines(table);
}

}  // namespace

std::string too_slow_for(const Analysis& analysis, double frame_rate_hz, bool buses) {
    const RateLimits& limits = analysis.limits;
    std::vector<std::string> names;
    if (limits.raster_hz < frame_rate_hz) {
        names.emplace_back("the raster");
    } else if (buses && analysis.best_frame_rate_hz < frame_rate_hz) {
        names.emplace_back("a bus");
    }
    if (limits.displays_hz() < frame_rate_hz) names.emplace_back("the displays");
    if (limits.links_hz() < frame_rate_hz) names.emplace_back("the links");
    return text::joined(names, "and");
}

std::string analysis_text(const Analysis& analysis, bool details) {
    std::string text = analysis.scenario + ": " + counted(analysis.renderers, "renderer") + ", " +
                       std::to_string(analysis.display_columns) + "x" +
                       std::to_string(analysis.display_rows) + " displays, raster " +
                       std::to_string(analysis.raster_width_pixels) + "x" +
                       std::to_string(analysis.raster_height_pixels) + "\n";
    text += "bus of " + std::to_string(analysis.bus.width_bits) + " bits, " +
            std::string(to_string(analysis.bus.arbitration)) + ", bursts of " +
            counted(analysis.bus.burst_pixels, "pixel") + ", ready space " +
            std::to_string(analysis.composer.ready_space_pixels) + "; memory of " +
            counted(analysis.memory.words_per_cycle, "word") + " a clock, pages of " +
            std::to_string(analysis.memory.page_words) + ", " +
            counted(analysis.memory.page_miss_cycles, "clock") + " a miss\n";
    if (const std::string line = idle_bus_line(analysis.bus.width_bits, analysis.memory.words_per_cycle);
        !line.empty()) {
        text += "the bus is " + line + "\n";
    }
    if (analysis.memory.banks > 1 || analysis.memory.precharge_cycles > 0) {
        text += "page misses are counted as if one bank had one page open, each at its full price: the " +
                counted(analysis.memory.banks, "bank") + " may have fewer and cheaper ones\n";
    }
    if (analysis.memory.refreshes()) {
        text += "a refresh counts " + counted(std::llround(refreshes(analysis.memory).cycles), "clock") +
                " in every " + std::to_string(analysis.memory.refresh_interval_cycles) +
                ", with those to open the burst's page again\n";
    }
    if (analysis.memory.shared()) {
        text += "a write of the link counts " +
                counted(std::llround(write_cycles(analysis.memory)), "clock") + " for every " +
                std::to_string(analysis.memory.write_block_words) +
                " words, with those to open its page and the burst's again\n";
    }
    text += "\n" + rate_lines(analysis) + buffer_lines(analysis) + table_lines(analysis);
    if (!details) return text + "(--details has tasks, supply, slot tables and composers of each)\n";
    for (const TableAnalysis& table : analysis.tables) text += "\n" + table_details(table, analysis);
    return text;
}

}  // namespace metabuffer::analysis
