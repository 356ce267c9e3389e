#include "report/bottleneck.h"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace metabuffer {
namespace {

/// Clocks that a bus works.
std::int64_t work_of(const BusCounters& bus) { return bus.wanted_cycles() - bus.poll_cycles; }

/// The index of the worst renderer.
std::size_t worst_off(const RunReport& report) {
    std::vector<std::int64_t> missed(report.renderers.size());
    for (const ComposerCounters& composer : report.composers) {
        missed[static_cast<std::size_t>(composer.renderer) - 1] +=
            composer.starved_pixels + composer.stalled_cycles;
    }
    const auto most = std::max_element(missed.begin(), missed.end());
    if (*most > 0) return static_cast<std::size_t>(most - missed.begin());
    const auto busiest = std::max_element(
        report.renderers.begin(), report.renderers.end(),
        [](const RendererCounters& a, const RendererCounters& b) { return work_of(a.bus) < work_of(b.bus); });
    return static_cast<std::size_t>(std::distance(report.renderers.begin(), busiest));
}

Resource supply_of(const RunReport& report, const BusCounters& bus, double bus_load) {
    if (bus_load <= 1.0) return Resource::kBuffers;
    const std::int64_t waiting = bus.page_miss_cycles + bus.refresh_cycles + bus.write_cycles;
    const std::int64_t bus_only = bus.table_cycles + bus.grant_cycles + bus.lost_cycles;
    const SupplyAlone alone =
        supply_alone(static_cast<double>(bus.pixels_sent), static_cast<double>(waiting),
                     static_cast<double>(bus_only), report.memory_words_per_cycle, report.bus_width_bits);
    return alone.memory_is_slower() ? Resource::kMemory : Resource::kBus;
}

/// Clocks between two frames that the handshakes take: a swap crosses into the core clock, and PIPEREADY climbs.
std::int64_t handshake_cycles(const RunReport& report) {
    constexpr std::int64_t kCrossing = 8;
    return kCrossing + static_cast<std::int64_t>(report.renderers.size());
}

/// Assigns the clocks from the end of a frame to the start of the next one to the resource that was ready last.
void blame_gap(const RunReport& report, const FrameRecord& frame, const FrameRecord& next,
               Bottleneck& found) {
    const auto cycles = [&found](Resource resource) -> std::int64_t& {
        return found.cycles[static_cast<std::size_t>(resource)];
    };
    const std::int64_t gap = next.start_cycle - frame.end_cycle - 1;
    if (next.start_cycle - frame.swap_cycle <= handshake_cycles(report)) {
        cycles(Resource::kDisplays) += gap;
        return;
    }
    // Where no pair is new, none was waited for.
    const std::int64_t newest_cycle =
        next.latency_cycles ? next.end_cycle - *next.latency_cycles : frame.end_cycle;
    const std::int64_t links = std::clamp<std::int64_t>(newest_cycle - frame.end_cycle, 0, gap);
    cycles(Resource::kLinks) += links;
    cycles(found.supply) += gap - links;
}

}  // namespace

const char* resource_name(Resource resource) {
    constexpr std::array<const char*, kResourceCount> kNames{"raster", "displays", "links",
                                                             "memory", "bus",      "buffers"};
    return kNames[static_cast<std::size_t>(resource)];
}

std::int64_t Bottleneck::total_cycles() const {
    return std::accumulate(cycles.begin(), cycles.end(), std::int64_t{0});
}

Resource Bottleneck::what() const {
    if (starves) return supply;
    return static_cast<Resource>(std::max_element(cycles.begin(), cycles.end()) - cycles.begin());
}

double Bottleneck::share() const {
    if (starves) return bus_load;
    return static_cast<double>(cycles[static_cast<std::size_t>(what())]) /
           static_cast<double>(total_cycles());
}

SupplyAlone supply_alone(double pixels, double waiting_cycles, double bus_only_cycles, int words_per_cycle,
                         int bus_width_bits) {
    return {bus_only_cycles + pixels * kPixelBits / bus_width_bits,
            waiting_cycles + pixels / words_per_cycle};
}

std::optional<Bottleneck> find_bottleneck(const RunReport& report) {
    const bool has_frames = !report.frames.empty() && !report.renderers.empty() && report.rate_limits;
    // In these runs buses have also worked for frames that were never shown.
    if (!has_frames || report.is_reset || !report.watchdog.empty()) return std::nullopt;
    Bottleneck found;
    const RendererCounters& worst = report.renderers[worst_off(report)];
    found.supply_renderer = worst.name;
    const auto frames = static_cast<std::int64_t>(report.frames.size());
    found.bus_load =
        static_cast<double>(work_of(worst.bus)) / static_cast<double>(frames * report.raster_pixels);
    found.supply = supply_of(report, worst.bus, found.bus_load);
    found.starves = report.total_starved_pixels() > 0;
    const FrameRecord* previous = nullptr;
    for (const FrameRecord& frame : report.frames) {
        if (previous != nullptr) blame_gap(report, *previous, frame, found);
        const std::int64_t composed = frame.end_cycle - frame.start_cycle + 1;
        const std::int64_t raster =
            std::min(composed, report.raster_pixels + static_cast<std::int64_t>(report.renderers.size()) - 1);
        found.cycles[static_cast<std::size_t>(Resource::kRaster)] += raster;
        found.cycles[static_cast<std::size_t>(found.supply)] += composed - raster;
        previous = &frame;
    }
    return found;
}

}  // namespace metabuffer
