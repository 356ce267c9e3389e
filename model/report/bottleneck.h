#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "report/report.h"

namespace metabuffer {

/// What a machine may have to wait for.
enum class Resource : std::uint8_t { kRaster, kDisplays, kLinks, kMemory, kBus, kBuffers };
constexpr std::size_t kResourceCount = 6;

/// "raster", "displays", "links", "memory", "bus", "buffers".
const char* resource_name(Resource resource);

/// What limits a run. Each clock from the first frame's start to the last frame's end is assigned to one resource:
///
/// - raster: the pixels of a frame go through the pipelines;
/// - displays: between two frames, if the next one begins as soon as the swap allows;
/// - links: between two frames otherwise, until the newest pair of the next one has come;
/// - supply: the rest of that time, and the clocks in which a column stands still and waits for pixels.
///
/// So between frames the resource that came last counts: the others sooner would not help.
///
/// Supply means the memory, the bus or the buffers, by the worst renderer: the one whose pixels starve or stall most,
/// else the one whose bus works most. If its bus works, on the average, for fewer clocks in each frame than the raster
/// has, the bus could keep pace, and deeper buffers would help. Otherwise it is the memory or the bus, whichever would
/// take longer if the other took no time.
struct Bottleneck {
    std::array<std::int64_t, kResourceCount> cycles{};  ///< by Resource
    Resource supply = Resource::kBus;                   ///< the cause if pixels do not come in time
    std::string supply_renderer;                        ///< the worst one
    double bus_load = 0.0;  ///< of its bus: clocks of work over clocks of the raster
    bool starves = false;   ///< pixels starved, so that supply is the bottleneck

    std::int64_t total_cycles() const;
    /// The supply if pixels starve, else the resource that most of the clocks are assigned to.
    Resource what() const;
    /// Its share of the clocks; if pixels starve, the bus's load instead.
    double share() const;
};

/// Clocks that a bus and its memory would each take for the same pixels if the other took no time.
struct SupplyAlone {
    double bus_cycles = 0.0;  ///< tables and pixels at the bus's width, and what the arbiter takes
    double memory_cycles =
        0.0;  ///< pixels at the words that it reads a clock, and the clocks until it can be read

    bool memory_is_slower() const { return memory_cycles > bus_cycles; }
};
/// waiting_cycles: in which the memory opens pages, refreshes or writes. bus_only_cycles: of tables and arbiter.
SupplyAlone supply_alone(double pixels, double waiting_cycles, double bus_only_cycles, int words_per_cycle,
                         int bus_width_bits);

/// Nothing for a run that has composited nothing, or was reset, or ended by the watchdog, or for a level without
/// clocks.
std::optional<Bottleneck> find_bottleneck(const RunReport& report);

}  // namespace metabuffer
