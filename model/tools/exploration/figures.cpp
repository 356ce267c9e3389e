#include "tools/exploration/figures.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>

#include "host/text.h"
#include "report/bottleneck.h"
#include "report/counters.h"
#include "report/machine_cost.h"

namespace metabuffer::exploration {

namespace {

/// What several figures are made from.
struct Sums {
    Sums(const RunReport& report_in, const Scenario& scenario_in)
        : report(report_in),
          scenario(scenario_in),
          bus(report_in.total_bus()),
          renderer(report_in.total_renderer()),
          composer(report_in.total_composer()),
          display(report_in.total_display()),
          rates(report_in.frame_rates()),
          limits(rate_limits(scenario_in)),
          bottleneck(find_bottleneck(report_in)),
          cost(machine_cost(scenario_in)),
          composers(static_cast<std::int64_t>(scenario_in.renderers.size()) * scenario_in.displays.count()) {}

    const RunReport& report;
    const Scenario& scenario;
    BusCounters bus;
    RendererCounters renderer;
    ComposerCounters composer;
    DisplayCounters display;
    FrameRates rates;
    RateLimits limits;
    std::optional<Bottleneck> bottleneck;
    MachineCost cost;
    std::int64_t composers;
};

Value ratio(std::int64_t numerator, std::int64_t denominator) {
    if (denominator <= 0) return {};
    return static_cast<double>(numerator) / static_cast<double>(denominator);
}

Value frame_cycles(const Sums& sums) {
    return ratio(sums.report.composition_cycles(), static_cast<std::int64_t>(sums.report.frames.size()));
}

Value optional_value(const std::optional<double>& number) { return number ? Value(*number) : Value(); }

Value slowest_interval(const Sums& sums, std::int64_t (*of)(const SlowestInterval&)) {
    const std::optional<SlowestInterval>& slowest = sums.rates.slowest_interval;
    return slowest ? Value(of(*slowest)) : Value();
}

Value latency_cycles(const Sums& sums) {
    std::optional<std::int64_t> longest;
    for (const FrameRecord& frame : sums.report.frames) longest = std::max(longest, frame.latency_cycles);
    return longest ? Value(*longest) : Value();
}

Value pixels_per_cycle(const Sums& sums) {
    const BusCounters& bus = sums.bus;
    return ratio(bus.pixels_sent, bus.busy_cycles + bus.table_cycles + bus.page_miss_cycles +
                                      bus.refresh_cycles + bus.write_cycles + bus.grant_cycles +
                                      bus.lost_cycles);
}

Value demand_pixels_per_cycle(const Sums& sums) {
    std::int64_t most = 0;
    for (const RendererCounters& renderer : sums.report.renderers) {
        most = std::max(most, renderer.bus.pixels_sent);
    }
    return ratio(most, sums.report.composition_cycles());
}

/// A figure and how to compute it.
struct Figure {
    FigureKind kind;
    std::function<Value(const Sums& sums)> value;
};

void add_figures(std::vector<Figure>& figures, std::initializer_list<Figure> more) {
    figures.insert(figures.end(), more);
}

/// Adds the totals of an owner's counters, except those with names that figures have already.
template <typename Owner>
void add_totals(std::vector<Figure>& figures, const Owner& (*total)(const Sums&)) {
    for (const Counter<Owner>& counter : Counters<Owner>::kTable) {
        const std::string name = counter.name_in_totals();
        const bool is_taken = std::any_of(figures.begin(), figures.end(),
                                          [&name](const Figure& figure) { return name == figure.kind.name; });
        if (is_taken) continue;
        const char* const of = counter.total == CounterTotal::kMost ? ", the most of all " : ", all ";
        figures.push_back(
            {{counter.name_in_totals(), counter.unit,
              std::string(counter.meaning) + of + Counters<Owner>::kOwners},
             [member = counter.member, total](const Sums& s) -> Value { return total(s).*member; }});
    }
}

void add_costs(std::vector<Figure>& figures) {
    add_figures(
        figures,
        {{{kCost, "", "in one number: the items below by their weights, or what the sweep's `cost` says"},
          [](const Sums& s) -> Value { return s.cost.weighted(); }}});
    for (const CostItem& item : cost_items()) {
        figures.push_back({{item.name, item.unit, std::string("cost: ") + item.meaning},
                           [value = item.value, whole = item.is_whole](const Sums& s) -> Value {
                               const double amount = value(s.cost);
                               return whole ? Value(static_cast<std::int64_t>(amount)) : Value(amount);
                           }});
    }
}

// The order is that of the results' columns.
std::vector<Figure> make_figures() {
    std::vector<Figure> figures;
    add_figures(
        figures,
        {{{"frames_shown", "frames", "composited frames that every display has shown"},
          [](const Sums& s) -> Value { return s.report.frames_shown(); }},
         {{"frames_asked", "frames", "composited frames that the scenario asks for"},
          [](const Sums& s) -> Value { return static_cast<std::int64_t>(s.scenario.frames); }},
         {{"core_cycles", "clocks", "core clocks of the whole run"},
          [](const Sums& s) -> Value { return s.report.core_cycles; }},
         {{"frame_cycles", "clocks", "mean core clocks a frame, from the first pixel composited to the last"},
          frame_cycles},
         {{"frames_per_second", "frames/s",
           "what a goal of so many frames a second asks for: the least of composition_hz, display_hz and one "
           "frame in slowest_interval_cycles; with three frames or more"},
          [](const Sums& s) { return optional_value(s.rates.held_hz()); }},
         {{"composition_hz", "frames/s",
           "frames after the first over the clocks from the first one's start to the last one's; with two "
           "frames or more"},
          [](const Sums& s) { return optional_value(s.rates.composition_hz); }},
         {{"slowest_interval_cycles", "clocks",
           "the longest from the start of a frame to the start of the next"},
          [](const Sums& s) {
              return slowest_interval(s, [](const SlowestInterval& slowest) { return slowest.cycles; });
          }},
         {{"slowest_interval_frame", "", "the frame that begins at its end, from 0"},
          [](const Sums& s) {
              return slowest_interval(
                  s, [](const SlowestInterval& slowest) { return std::int64_t{slowest.frame}; });
          }},
         {{"display_hz", "frames/s",
           "different frames that the displays showed, from the second swap to the last; with three frames "
           "or more"},
          [](const Sums& s) { return optional_value(s.rates.display_hz); }},
         {{"raster_hz", "frames/s", "what the raster allows: frames back to back through the pipelines"},
          [](const Sums& s) -> Value { return s.limits.raster_hz; }},
         {{"refresh_hz", "Hz", "what the displays allow: their frames a second"},
          [](const Sums& s) -> Value { return s.limits.refresh_hz; }},
         {{"pairs_per_second", "pairs/s", "what the links allow: pairs a second on the slowest"},
          [](const Sums& s) -> Value { return s.limits.slowest_pairs_per_second(); }},
         {{"latency_cycles", "clocks",
           "the longest of the frames' latencies, last DVI pixel to last composited pixel"},
          latency_cycles}});
    add_figures(
        figures,
        {{{"bottleneck", "", "what the run waited for most: raster, displays, links, memory, bus or buffers"},
          [](const Sums& s) {
              return s.bottleneck ? Value(std::string(resource_name(s.bottleneck->what()))) : Value();
          }},
         {{"bottleneck_share", "",
           "share of the clocks that the bottleneck is to blame for; while pixels starve, clocks that the "
           "worst bus works over those of the raster"},
          [](const Sums& s) { return s.bottleneck ? Value(s.bottleneck->share()) : Value(); }},
         {{kIdleBusBits, "bits",
           "bits of each bus that memory never fills: bus.width_bits beyond 64 x memory.words_per_cycle"},
          [](const Sums& s) -> Value {
              return std::int64_t{
                  idle_bus_bits(s.scenario.bus.width_bits, s.scenario.memory.words_per_cycle)};
          }},
         {{"bus_load", "", "clocks that the worst or busiest bus works over those of the raster"},
          [](const Sums& s) { return s.bottleneck ? Value(s.bottleneck->bus_load) : Value(); }}});
    add_figures(figures, {{{kWhole, "",
                            "1 if every frame was shown, no pixel starved, and no frame, table row or slot "
                            "table was rejected; else 0"},
                           // figures_of() sets it by the others.
                           [](const Sums& /*s*/) { return Value(); }}});
    add_figures(figures, {{{kWrongPixels, "pixels",
                            "pixels shown that differ from those of a machine in which nothing starves; if "
                            "pixels starved, only of runs "
                            "whose pictures are kept, or whose goal or cost names them"},
                           [](const Sums& s) {
                               const std::optional<std::int64_t> pixels = s.report.total_wrong_pixels();
                               return pixels ? Value(*pixels) : Value();
                           }}});
    add_totals<ComposerCounters>(figures,
                                 [](const Sums& s) -> const ComposerCounters& { return s.composer; });
    add_figures(figures, {{{"rejected_frames", "frames", "frames rejected at the links, for whatever cause"},
                           [](const Sums& s) -> Value { return s.renderer.total_rejected_frames(); }},
                          {{"rejected_rows", "rows", "rows of viewport tables rejected"},
                           [](const Sums& s) -> Value { return s.renderer.total_rejected_rows(); }}});
    add_totals<RendererCounters>(figures,
                                 [](const Sums& s) -> const RendererCounters& { return s.renderer; });
    add_totals<BusCounters>(figures, [](const Sums& s) -> const BusCounters& { return s.bus; });
    add_figures(
        figures,
        {{{"utilization", "", "share of the clocks with something to send in which pixels moved, all buses"},
          [](const Sums& s) -> Value { return s.bus.utilization(); }},
         {{"pixels_per_cycle", "pixels/clock",
           "pixels sent over the clocks in which buses worked (busy, table, page miss, refresh, write, "
           "grant, lost): what a bus sustained"},
          pixels_per_cycle},
         {{"demand_pixels_per_cycle", "pixels/clock",
           "pixels sent on the busiest bus over the clocks from the first pixel composited to the last"},
          demand_pixels_per_cycle}});
    add_totals<DisplayCounters>(figures, [](const Sums& s) -> const DisplayCounters& { return s.display; });
    add_figures(
        figures,
        {{{"renderers", "", "renderers of the machine"},
          [](const Sums& s) -> Value { return static_cast<std::int64_t>(s.scenario.renderers.size()); }},
         {{"displays", "", "displays of the machine"},
          [](const Sums& s) -> Value { return static_cast<std::int64_t>(s.scenario.displays.count()); }},
         {{"composers", "", "composers of the machine: renderers times displays"},
          [](const Sums& s) -> Value { return s.composers; }},
         {{"raster_pixels", "pixels", "pixels of one display's raster, supersampling included"},
          [](const Sums& s) -> Value {
              return std::int64_t{s.scenario.displays.raster_width_pixels()} *
                     s.scenario.displays.raster_height_pixels();
          }}});
    add_costs(figures);
    return figures;
}

const std::vector<Figure>& all_figures() {
    static const std::vector<Figure> figures = make_figures();
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

std::int64_t count_in(const std::vector<Value>& figures, const char* name) {
    const std::size_t index = figure_index(name).value();
    const auto* const number = index < figures.size() ? std::get_if<std::int64_t>(&figures[index]) : nullptr;
    return number == nullptr ? 0 : *number;
}

std::string missing_from_whole(const std::vector<Value>& figures) {
    std::vector<std::string> parts;
    for (const char* const name :
         {"starved_pixels", "rejected_frames", "rejected_rows", "rejected_slot_tables"}) {
        const std::int64_t count = count_in(figures, name);
        if (count > 0) parts.push_back(std::string(name) + " " + std::to_string(count));
    }
    const std::int64_t shown = count_in(figures, "frames_shown");
    const std::int64_t asked = count_in(figures, "frames_asked");
    if (shown < asked)
        parts.push_back("frames_shown " + std::to_string(shown) + " of " + std::to_string(asked));
    return text::listed(parts);
}

std::vector<Value> figures_of(const RunReport& report, const Scenario& scenario) {
    const Sums sums(report, scenario);
    std::vector<Value> values;
    for (const Figure& figure : all_figures()) values.push_back(figure.value(sums));
    // 1 or 0: SQL has no other truth.
    values[figure_index(kWhole).value()] = std::int64_t{missing_from_whole(values).empty()};
    return values;
}

}  // namespace metabuffer::exploration
