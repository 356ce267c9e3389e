#include "tools/exploration/figures.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include "formats/pixel.h"

namespace metabuffer::exploration {

namespace {

/// What several figures are made from.
struct Sums {
    Sums(const RunReport& report_in, const Scenario& scenario_in)
        : report(report_in),
          scenario(scenario_in),
          bus(report_in.total_bus()),
          composer(report_in.total_composer()),
          composers(static_cast<std::int64_t>(scenario_in.renderers.size()) * scenario_in.displays.count()) {}

    const RunReport& report;
    const Scenario& scenario;
    BusCounters bus;
    ComposerCounters composer;
    std::int64_t composers;
};

Value ratio(std::int64_t numerator, std::int64_t denominator) {
    if (denominator <= 0) return {};
    return static_cast<double>(numerator) / static_cast<double>(denominator);
}

Value frame_cycles(const Sums& sums) {
    return ratio(sums.report.composition_cycles(), static_cast<std::int64_t>(sums.report.frames.size()));
}

Value frames_per_second(const Sums& sums) {
    const std::optional<double> rate = sums.report.frames_per_second();
    return rate ? Value(*rate) : Value();
}

Value latency_cycles(const Sums& sums) {
    std::optional<std::int64_t> longest;
    for (const FrameRecord& frame : sums.report.frames) longest = std::max(longest, frame.latency_cycles);
    return longest ? Value(*longest) : Value();
}

Value pixels_per_cycle(const Sums& sums) {
    const BusCounters& bus = sums.bus;
    return ratio(bus.pixels_sent,
                 bus.busy_cycles + bus.table_cycles + bus.page_miss_cycles + bus.lost_cycles);
}

Value demand_pixels_per_cycle(const Sums& sums) {
    std::int64_t most = 0;
    for (const RendererCounters& renderer : sums.report.renderers) {
        most = std::max(most, renderer.bus.pixels_sent);
    }
    return ratio(most, sums.report.composition_cycles());
}

/// A figure with the way to it.
struct Figure {
    FigureKind kind;
    Value (*value)(const Sums& sums);
};

// The order is that of the results' columns.
const std::vector<Figure>& all_figures() {
    static const std::vector<Figure> figures{
        {{"frames_shown", "frames", "composited frames that every display has shown"},
         [](const Sums& s) -> Value { return s.report.frames_shown(); }},
        {{"frames_asked", "frames", "composited frames that the scenario asks for"},
         [](const Sums& s) -> Value { return static_cast<std::int64_t>(s.scenario.frames); }},
        {{"core_cycles", "clocks", "core clocks of the whole run"},
         [](const Sums& s) -> Value { return s.report.core_cycles; }},
        {{"frame_cycles", "clocks", "mean core clocks a frame, from the first pixel composited to the last"},
         frame_cycles},
        {{"frames_per_second", "frames/s",
          "composited frames over the same clocks, at the core clock's rate"},
         frames_per_second},
        {{"latency_cycles", "clocks",
          "the longest of the frames' latencies, last DVI pixel to last composited pixel"},
         latency_cycles},
        {{"starved_pixels", "pixels",
          "covered raster pixels that went without their local pixel, all composers"},
         [](const Sums& s) -> Value { return s.composer.starved_pixels; }},
        {{"stalled_cycles", "clocks", "clocks that composers made their columns wait, all composers"},
         [](const Sums& s) -> Value { return s.composer.stalled_cycles; }},
        {{"rejected_frames", "frames", "frames rejected at the links, for whatever cause"},
         [](const Sums& s) -> Value { return s.report.total_rejected_frames(); }},
        {{"rejected_rows", "rows", "rows of viewport tables rejected"},
         [](const Sums& s) -> Value { return s.report.total_rejected_rows(); }},
        {{"repeated_frames", "frames", "frames that showed a renderer's earlier pair again, all renderers"},
         [](const Sums& s) -> Value { return s.report.total_repeated_frames(); }},
        {{"dropped_frames", "frames", "pairs that newer ones overtook before they were shown, all renderers"},
         [](const Sums& s) -> Value { return s.report.total_dropped_frames(); }},
        {{"busy_cycles", "clocks", "clocks in which a pixel moved, all buses"},
         [](const Sums& s) -> Value { return s.bus.busy_cycles; }},
        {{"table_cycles", "clocks", "clocks in which the viewport table was broadcast, all buses"},
         [](const Sums& s) -> Value { return s.bus.table_cycles; }},
        {{"page_miss_cycles", "clocks",
          "clocks in which a burst waited for the memory to open a page, all buses"},
         [](const Sums& s) -> Value { return s.bus.page_miss_cycles; }},
        {{"poll_cycles", "clocks", "clocks with something to send and no composer that took it, all buses"},
         [](const Sums& s) -> Value { return s.bus.poll_cycles; }},
        {{"lost_cycles", "clocks",
          "clocks of slots that their composer could not use (slot-allocation), all buses"},
         [](const Sums& s) -> Value { return s.bus.lost_cycles; }},
        {{"idle_cycles", "clocks", "clocks with nothing to send, all buses"},
         [](const Sums& s) -> Value { return s.bus.idle_cycles; }},
        {{"page_misses", "", "pages that the memories opened, all buses"},
         [](const Sums& s) -> Value { return s.bus.page_misses; }},
        {{"pixels_sent", "pixels", "pixels that moved over the buses"},
         [](const Sums& s) -> Value { return s.bus.pixels_sent; }},
        {{"bursts", "", "bursts on the buses"}, [](const Sums& s) -> Value { return s.bus.bursts; }},
        {{"recovered_slots", "", "slots passed over and used by the next composer in the table, all buses"},
         [](const Sums& s) -> Value { return s.bus.recovered_slots; }},
        {{"utilization", "", "share of the clocks with something to send in which pixels moved, all buses"},
         [](const Sums& s) -> Value { return s.bus.utilization(); }},
        {{"pixels_per_cycle", "pixels/clock",
          "pixels sent over the clocks in which buses worked (busy, table, page miss, lost): what a bus "
          "sustained"},
         pixels_per_cycle},
        {{"demand_pixels_per_cycle", "pixels/clock",
          "pixels sent on the busiest bus over the clocks from the first pixel composited to the last"},
         demand_pixels_per_cycle},
        {{"buffer_high_water", "pixels", "the most that any composer's buffer held"},
         [](const Sums& s) -> Value { return s.composer.buffer_high_water; }},
        {{"busready_drops", "", "bursts that a composer cut short, all composers"},
         [](const Sums& s) -> Value { return s.composer.busready_drops; }},
        {{"late_pixels", "pixels",
          "pixels that arrived behind their last use and were dropped, all composers"},
         [](const Sums& s) -> Value { return s.composer.late_pixels; }},
        {{"replayed_pixels", "pixels", "pixels that composers read again from their moving windows"},
         [](const Sums& s) -> Value { return s.composer.replayed_pixels; }},
        {{"renderers", "", "renderers of the machine"},
         [](const Sums& s) -> Value { return static_cast<std::int64_t>(s.scenario.renderers.size()); }},
        {{"displays", "", "displays of the machine"},
         [](const Sums& s) -> Value { return static_cast<std::int64_t>(s.scenario.displays.count()); }},
        {{"composers", "", "composers of the machine: renderers times displays"},
         [](const Sums& s) -> Value { return s.composers; }},
        {{"raster_pixels", "pixels", "pixels of one display's raster, supersampling included"},
         [](const Sums& s) -> Value {
             return std::int64_t{s.scenario.displays.raster_width_pixels()} *
                    s.scenario.displays.raster_height_pixels();
         }},
        {{"buffer_bits", "bits", "cost: composers times composer.buffer_pixels times 64"},
         [](const Sums& s) -> Value { return s.composers * s.scenario.composer.buffer_pixels * kPixelBits; }},
        {{"bus_wires", "wires", "cost: renderers times bus.width_bits"}, [](const Sums& s) -> Value {
             return static_cast<std::int64_t>(s.scenario.renderers.size()) * s.scenario.bus.width_bits;
         }}};
    return figures;
}

}  // namespace

const std::vector<FigureKind>& figure_kinds() {
    static const std::vector<FigureKind> kinds = [] {
        std::vector<FigureKind> result;
        for (const Figure& figure : all_figures()) result.push_back(figure.kind);
        return result;
    }();
    return kinds;
}

std::optional<std::size_t> figure_index(const std::string& name) {
    const std::vector<FigureKind>& kinds = figure_kinds();
    const auto found = std::find_if(kinds.begin(), kinds.end(),
                                    [&name](const FigureKind& kind) { return name == kind.name; });
    if (found == kinds.end()) return std::nullopt;
    return static_cast<std::size_t>(found - kinds.begin());
}

std::vector<Value> figures_of(const RunReport& report, const Scenario& scenario) {
    const Sums sums(report, scenario);
    std::vector<Value> values;
    for (const Figure& figure : all_figures()) values.push_back(figure.value(sums));
    return values;
}

}  // namespace metabuffer::exploration
