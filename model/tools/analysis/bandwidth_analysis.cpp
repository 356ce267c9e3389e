#include "tools/analysis/bandwidth_analysis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "formats/control_scanline.h"
#include "report/bottleneck.h"
#include "scenario/limits.h"
#include "scenario/link_program.h"
#include "tools/analysis/arithmetic.h"
#include "tools/analysis/buffer_bound.h"
#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {
namespace {

/// A sum for each raster row, kept as its changes from row to row.
class RowSums {
  public:
    void add(int first_row, int behind_row, double value) {
        changes_[first_row] += value;
        changes_[behind_row] -= value;
    }
    double most() const {
        double sum = 0.0;
        double most = 0.0;
        for (const auto& [row, change] : changes_) {
            sum += change;
            most = std::max(most, sum);
        }
        return most;
    }

  private:
    std::map<int, double> changes_;
};

Demand demand_of(const TableAnalysis& table, const Scenario& scenario) {
    const int width = scenario.displays.raster_width_pixels();
    const int height = scenario.displays.raster_height_pixels();
    Demand demand;
    for (const Task& task : table.tasks) demand.sum += task.pixels_per_cycle();
    RowSums rates;
    std::vector<double> first_shown(static_cast<std::size_t>(height), 0.0);
    for (const ComposerAnalysis& composer : table.composers) {
        const Segment segment(composer.row, width, height, scenario.composer.smoothing);
        rates.add(segment.top(), segment.bottom(),
                  as_double(composer.row.sdx) / as_double(std::int64_t{composer.row.dmultiple} * width));
        for (int line = 0; line < composer.row.sdy; ++line) {
            const int y = segment.newest_rows(line).begin;
            if (y < segment.bottom()) {
                first_shown[static_cast<std::size_t>(y)] += as_double(composer.row.sdx) / width;
            }
        }
        demand.pixels += composer.pixels;
    }
    demand.most_at_once = rates.most();
    demand.busiest_row = *std::max_element(first_shown.begin(), first_shown.end());
    demand.mean = as_double(demand.pixels) / (as_double(width) * height);
    return demand;
}

/// Pages that a table's segments touch. No page is open when a frame begins.
std::int64_t pages_of(const BusTable& table, int image_width, int page_words) {
    std::set<std::int64_t> pages;
    for (const BusUser& user : table.users()) {
        const ViewportRow& row = user.segment.row();
        for (std::int64_t line = row.sy; line < row.sy + row.sdy; ++line) {
            const std::int64_t first = (line * image_width + row.sx) / page_words;
            const std::int64_t last = (line * image_width + row.sx + row.sdx - 1) / page_words;
            for (std::int64_t page = first; page <= last; ++page) pages.insert(page);
        }
    }
    return static_cast<std::int64_t>(pages.size());
}

/// Clocks to open each page of a frame once. Before a bank's first page there is nothing to precharge.
std::int64_t least_opening_cycles(const MemoryConfig& memory, std::int64_t pages) {
    return pages * memory.activate_cycles() +
           std::max<std::int64_t>(0, pages - memory.banks) * memory.precharge_cycles;
}

/// image_cycles: clocks in which an image's words are written.
Supply::Writes writes_of(const Scenario& scenario, std::size_t renderer, double image_cycles) {
    constexpr double kFramesPerPair = 2.0;
    if (!scenario.memory.shared()) return {};
    const RateLimits limits = rate_limits(scenario);
    Supply::Writes writes;
    writes.share = kFramesPerPair * image_cycles * limits.pairs_per_second[renderer] / limits.core_hz;
    if (scenario.pacing == Pacing::kLockstep)
        writes.pair_cycles = static_cast<std::int64_t>(kFramesPerPair * image_cycles);
    return writes;
}

/// While a composer is passed over others may have the bus. It is idle only if all that are left are passed over, the
/// one that is done last among them.
std::int64_t idle_cycles(const BusTable& table) {
    std::int64_t most_bursts = 0;
    for (const BusUser& user : table.users()) most_bursts = std::max(most_bursts, user.costs.bursts());
    const MachineFigures& machine = table.machine();
    const std::int64_t passed_over =
        machine.loop_cycles > 0 ? most_bursts * machine.passed_over_cycles() : std::int64_t{0};
    return passed_over + static_cast<std::int64_t>(table.build_cycles());
}

Supply supply_of(const BusTable& table, const Scenario& scenario, std::int64_t pixels) {
    const MachineFigures& machine = table.machine();
    const auto renderer = static_cast<std::size_t>(table.renderer());
    Supply supply;
    supply.raw = as_double(machine.pixels_per_beat) / as_double(machine.cycles_per_beat);
    supply.whole_bursts = machine.whole_bursts();
    const std::int64_t row_cycles =
        std::max(1, static_cast<int>(8 * kControlRowBytes) / scenario.bus.width_bits);
    supply.table_cycles = 1 + static_cast<std::int64_t>(table.users().size()) * row_cycles;
    for (const BusUser& user : table.users()) {
        supply.burst_cycles += user.costs.total_cycles();
        supply.grant_cycles += user.costs.bursts() * scenario.bus.grant_cycles;
        supply.beats += user.costs.beats();
        supply.page_misses += user.costs.page_misses();
    }
    if (table.first_word() == FirstWord::kHits && !table.users().empty()) {
        supply.page_misses += 1;
        supply.burst_cycles += machine.page_miss_cycles;
    }
    // Cut bursts may have other beats, but no beat has more pixels than fit.
    const std::int64_t least_beats =
        supply.whole_bursts ? supply.beats : (pixels + machine.pixels_per_beat - 1) / machine.pixels_per_beat;
    supply.least_burst_cycles =
        supply.grant_cycles + least_beats * machine.cycles_per_beat +
        least_opening_cycles(scenario.memory, pages_of(table, scenario.renderers[renderer].image_width_pixels,
                                                       scenario.memory.page_words));
    supply.idle_cycles = idle_cycles(table);
    const Interruption refresh = refreshes(scenario.memory);
    supply.refresh_share = refresh.share();
    supply.least_refresh_share = refresh.per_cycle * scenario.memory.refresh_cycles;
    const std::int64_t words = scenario.renderers[renderer].image_words();
    const std::int64_t blocks = divide_up(words, scenario.memory.write_block_words);
    supply.writes = writes_of(scenario, renderer, as_double(blocks) * write_cycles(scenario.memory));
    supply.least_writes =
        writes_of(scenario, renderer, as_double(least_write_cycles(scenario.memory, words)));
    if (pixels == 0) {
        supply.sustained = supply.raw;
        return supply;
    }
    const std::int64_t cycles = supply.frame_cycles() - supply.table_cycles;
    supply.sustained = as_double(pixels) / as_double(cycles);
    return supply;
}

double load_of(const BusTable& table, const Supply& supply) {
    RowSums clocks;
    for (const BusUser& user : table.users()) {
        std::int64_t cycles = user.costs.total_cycles();
        if (table.users().size() == 1 && table.machine().loop_cycles > 0)
            cycles += user.costs.bursts() * table.machine().passed_over_cycles();
        const double each = as_double(cycles) / as_double(user.segment.pixels());
        clocks.add(user.segment.top(), user.segment.bottom(), user.releases.rate * each);
    }
    return std::max(clocks.most() + table.taken_share(),
                    as_double(supply.frame_cycles()) / as_double(table.machine().raster_pixels));
}

/// The bound's copy of a table, since the costs of bursts take the longest to find. If it has none, one is made.
const BusTable& bus_table(const BufferBound& bound, const Scenario& scenario, int renderer_index,
                          const ViewportTable& rows, std::vector<int> slots, std::optional<BusTable>& made) {
    for (const BusTable& table : bound.tables()) {
        const bool same =
            table.renderer() == renderer_index && table.shares().table() == slots &&
            std::equal(table.users().begin(), table.users().end(), rows.begin(), rows.end(),
                       [](const BusUser& user, const ViewportRow& row) { return user.segment.row() == row; });
        if (same) return table;
    }
    return made.emplace(scenario, MachineFigures(scenario), renderer_index, rows, std::move(slots));
}

TableAnalysis analyze_table(const Scenario& scenario, const BufferBound& bound, int renderer_index,
                            const RendererFrame& entry) {
    const ViewportTable& rows = entry.table;
    const Renderer& renderer = scenario.renderers[static_cast<std::size_t>(renderer_index)];
    ViewportLimits limits = scenario.limits(renderer);
    const ValidatedTable own_buffers = validate_table(rows, limits);
    // A row for which this scenario's buffers are too small is listed as rejected. Its composer is analyzed all the
    // same, since the question is how much buffer it needs.
    limits.buffer_pixels = static_cast<int>(limits::kBufferPixels.high);
    const ValidatedTable valid = validate_table(rows, limits);
    std::optional<BusTable> made;
    const BusTable& bus = bus_table(bound, scenario, renderer_index, valid.rows,
                                    frame_slots(scenario, renderer, entry, valid).slots, made);

    TableAnalysis table;
    table.renderer = renderer_index;
    table.renderer_name = renderer.name;
    table.rejected = own_buffers.rejected;
    table.tasks = task_table(valid.rows, limits.raster_width_pixels, limits.raster_height_pixels,
                             scenario.displays.columns);
    const bool has_slots = !bus.shares().table().empty();
    for (std::size_t i = 0; i < valid.rows.size(); ++i) {
        const ViewportRow& row = valid.rows[i];
        const BusUser& user = bus.users()[i];
        ComposerAnalysis composer;
        composer.row = row;
        for (const Task& task : table.tasks) {
            const bool member = std::count(task.displays.begin(), task.displays.end(), row.dcomp) > 0;
            if (member) composer.task = task.label;
        }
        composer.pixels = user.segment.pixels();
        composer.bursts = user.costs.bursts();
        composer.page_misses = user.costs.page_misses();
        composer.bus_cycles = user.costs.total_cycles();
        composer.slots = has_slots ? bus.shares().slots(i) : 0;
        composer.least_buffer_pixels = least_buffer_pixels(row, limits.smoothing, limits.ready_space_pixels);
        composer.whole_buffer_pixels =
            std::max(composer.least_buffer_pixels, composer.pixels + bus.machine().ready_space - 1);
        table.composers.push_back(composer);
        table.rotation_cycles += as_double(composer.slots) * user.slot_average;
    }
    table.demand = demand_of(table, scenario);
    table.supply = supply_of(bus, scenario, table.demand.pixels);
    table.load = load_of(bus, table.supply);
    for (const int row : bus.shares().table()) {
        table.slot_displays.push_back(valid.rows[static_cast<std::size_t>(row)].dcomp);
    }
    return table;
}

/// Adds the different tables of a renderer, each with the frames that have it.
void add_tables(const Scenario& scenario, const BufferBound& bound, int renderer_index,
                const AnalysisOptions& options, std::vector<TableAnalysis>& tables) {
    const Renderer& renderer = scenario.renderers[static_cast<std::size_t>(renderer_index)];
    const std::size_t first = tables.size();
    std::vector<const RendererFrame*> known;
    for (std::size_t frame = 0; frame < renderer.frames.size(); ++frame) {
        const RendererFrame* entry = &renderer.frames[frame];
        if (options.frame) {
            if (entry != &renderer.frame_of_pair(static_cast<std::uint32_t>(*options.frame))) continue;
        } else if (scenario.pacing == Pacing::kLockstep &&
                   frame >= static_cast<std::size_t>(scenario.frames)) {
            break;
        }
        const auto same = std::find_if(known.begin(), known.end(), [entry](const RendererFrame* other) {
            return has_same_tables(*other, *entry);
        });
        const auto index = static_cast<std::size_t>(same - known.begin());
        if (same == known.end()) {
            known.push_back(entry);
            tables.push_back(analyze_table(scenario, bound, renderer_index, *entry));
        }
        tables[first + index].frames.push_back(static_cast<int>(frame));
    }
}

/// taken_cycles: of a frame's clocks, what bursts cannot have.
double pixels_short(std::int64_t pixels, double taken_cycles, std::int64_t burst_cycles,
                    double period_cycles) {
    const double available = std::max(0.0, period_cycles - taken_cycles);
    return as_double(pixels) * std::max(0.0, 1.0 - available / as_double(burst_cycles));
}

/// Clocks of a frame that has so many of its own: as its link sends one pair, or as it always sends, if that is less.
std::int64_t frame_cycles_of(std::int64_t cycles, double refresh_share, const Supply::Writes& writes) {
    const auto stretched = [](double cycles, double share) {
        return share == 0.0 ? cycles : std::ceil(cycles * TakenClocks{share, 0.0}.stretch());
    };
    double all = stretched(as_double(cycles), refresh_share + writes.share);
    if (writes.pair_cycles)
        all = std::min(all, stretched(as_double(cycles + *writes.pair_cycles), refresh_share));
    return static_cast<std::int64_t>(all);
}

}  // namespace

double Supply::Writes::in(double cycles) const {
    const double always = share * cycles;
    return pair_cycles ? std::min(always, as_double(*pair_cycles)) : always;
}

std::int64_t Supply::frame_cycles() const {
    return frame_cycles_of(table_cycles + burst_cycles + idle_cycles, refresh_share, writes);
}

std::int64_t Supply::least_frame_cycles() const {
    return frame_cycles_of(table_cycles + least_burst_cycles, least_refresh_share, least_writes);
}

double TableAnalysis::most_pixels_short(double period_cycles) const {
    const double taken = as_double(supply.table_cycles + supply.idle_cycles) +
                         supply.refresh_share * period_cycles + supply.writes.in(period_cycles);
    return pixels_short(demand.pixels, taken, supply.burst_cycles, period_cycles);
}

double TableAnalysis::least_pixels_short(double period_cycles) const {
    const double taken = as_double(supply.table_cycles) + supply.least_refresh_share * period_cycles +
                         supply.least_writes.in(period_cycles);
    return pixels_short(demand.pixels, taken, supply.least_burst_cycles, period_cycles);
}

std::vector<RateOfPart> rates_of_parts(const Analysis& analysis) {
    const RateLimits& limits = analysis.limits;
    std::vector<RateOfPart> parts{
        {"raster", limits.raster_hz}, {"displays", limits.displays_hz()}, {"links", limits.links_hz()}};
    if (analysis.supply_hz > 0.0) {
        parts.push_back(
            {analysis.memory_alone_hz < analysis.bus_alone_hz ? "memory" : "bus", analysis.supply_hz});
    }
    std::stable_sort(parts.begin(), parts.end(), [](const RateOfPart& a, const RateOfPart& b) {
        return a.frames_per_second < b.frames_per_second;
    });
    return parts;
}

Analysis analyze(const Scenario& scenario, const AnalysisOptions& options) {
    Analysis analysis;
    analysis.scenario = scenario.name;
    analysis.renderers = static_cast<int>(scenario.renderers.size());
    analysis.display_columns = scenario.displays.columns;
    analysis.display_rows = scenario.displays.rows;
    analysis.raster_width_pixels = scenario.displays.raster_width_pixels();
    analysis.raster_height_pixels = scenario.displays.raster_height_pixels();
    analysis.core_mhz = scenario.clocks.core_mhz;
    analysis.memory = scenario.memory;
    analysis.bus = scenario.bus;
    analysis.composer = scenario.composer;
    const BufferBound bound(scenario);
    for (int renderer = 0; renderer < analysis.renderers; ++renderer) {
        add_tables(scenario, bound, renderer, options, analysis.tables);
    }

    analysis.limits = rate_limits(scenario);
    const double core_hz = analysis.limits.core_hz;
    const double raster_cycles =
        as_double(std::int64_t{analysis.raster_width_pixels} * analysis.raster_height_pixels);
    analysis.asked_frame_rate_hz = options.frame_rate_hz;
    analysis.period_cycles = options.frame_rate_hz ? core_hz / *options.frame_rate_hz : raster_cycles;
    const TableAnalysis* longest = nullptr;
    double longest_cycles = raster_cycles;
    double least_cycles = raster_cycles;
    for (const TableAnalysis& table : analysis.tables) {
        longest_cycles = std::max(longest_cycles, as_double(table.supply.frame_cycles()));
        least_cycles = std::max(least_cycles, as_double(table.supply.least_frame_cycles()));
        if (longest == nullptr || table.supply.frame_cycles() > longest->supply.frame_cycles())
            longest = &table;
    }
    if (longest != nullptr && longest->supply.frame_cycles() > 0) {
        const Supply& supply = longest->supply;
        const double pixels = as_double(longest->demand.pixels);
        const double beat_cycles = as_double(supply.beats * cycles_per_beat(scenario.bus));
        const std::int64_t bus_only = supply.table_cycles + supply.idle_cycles + supply.grant_cycles;
        const double waiting_cycles = as_double(supply.frame_cycles() - bus_only) - beat_cycles;
        analysis.supply_hz = core_hz / as_double(supply.frame_cycles());
        const SupplyAlone alone = supply_alone(pixels, waiting_cycles, as_double(bus_only),
                                               scenario.memory.words_per_cycle, scenario.bus.width_bits);
        analysis.bus_alone_hz = core_hz / alone.bus_cycles;
        analysis.memory_alone_hz = core_hz / std::max(1.0, alone.memory_cycles);
    }
    analysis.sustained_frame_rate_hz = core_hz / longest_cycles;
    analysis.best_frame_rate_hz = core_hz / least_cycles;

    analysis.least_buffer_pixels = bound.smallest_legal_pixels();
    analysis.whole_buffer_pixels = bound.whole_segment_pixels();
    if (const std::optional<BufferBound::Result> found = bound.find()) {
        analysis.safe_buffer_pixels = found->pixels;
        analysis.safe_buffer_is_legal = limits::kBufferPixels.contains(found->pixels);
        analysis.deciding_renderer = found->renderer;
        analysis.deciding_display = found->display;
    }
    for (const BusTable& table : bound.tables())
        analysis.memory_may_be_taken = analysis.memory_may_be_taken || table.taken_share() >= 1.0;
    analysis.scenario_is_safe = bound.is_safe(scenario.composer.buffer_pixels);
    return analysis;
}

}  // namespace metabuffer::analysis
