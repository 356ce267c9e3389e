#include "scenario/derived_timing.h"

#include <algorithm>
#include <limits>

#include "datapath/arbitration/arbitration_table.h"
#include "datapath/slot_table.h"

namespace metabuffer {

std::int64_t pair_clocks(const Renderer& renderer) {
    constexpr int kFramesPerPair = 2;
    return kFramesPerPair * renderer.timing().frame_clocks();
}

std::int64_t link_timeout_clocks(const Scenario& scenario, const Renderer& renderer) {
    return pair_clocks(renderer) * scenario.link_timeout_pairs +
           std::int64_t{DviTiming::kVerticalSyncLines} * renderer.timing().line_clocks();
}

int lost_slot_cycles(const Scenario& scenario) {
    const int beat = pixels_per_beat(scenario.bus, scenario.memory);
    return (scenario.bus.burst_pixels + beat - 1) / beat * cycles_per_beat(scenario.bus);
}

int longest_write_cycles(const MemoryConfig& memory, int words) {
    return memory.page_miss_cycles + memory.write_cycles(words);
}

int longest_write_delay_cycles(const MemoryConfig& memory) {
    constexpr int kSynchronizerCycles = 3;
    const int writing = longest_write_cycles(memory, memory.write_block_words);
    const int refresh = memory.refreshes() ? writing + memory.refresh_cycles : 0;
    return kSynchronizerCycles + memory.page_miss_cycles + refresh + writing;
}

int least_block_cycles(const MemoryConfig& memory) {
    return longest_write_delay_cycles(memory) + memory.page_miss_cycles;
}

std::int64_t least_refresh_interval_cycles(const MemoryConfig& memory) {
    const std::int64_t beat = std::int64_t{memory.refresh_cycles} + memory.page_miss_cycles + 1;
    if (!memory.shared()) return beat;
    return beat + memory.page_miss_cycles +
           std::int64_t{2} * longest_write_cycles(memory, memory.write_block_words);
}

std::int64_t longest_last_write_cycles(const MemoryConfig& memory, std::int64_t words) {
    const auto last = static_cast<int>(std::min<std::int64_t>(memory.write_block_words, words));
    return std::int64_t{longest_write_delay_cycles(memory)} + longest_write_cycles(memory, last);
}

std::int64_t verdict_link_clocks(const Renderer& renderer) {
    return std::int64_t{DviTiming::kVerticalFrontLines} * renderer.timing().line_clocks();
}

namespace {

constexpr std::int64_t kMillion = 1'000'000;

std::int64_t quotient_up(std::int64_t value, std::int64_t divisor) { return (value + divisor - 1) / divisor; }

/// By how much a renderer's link is faster than its clock, at the most.
std::int64_t fastest_drift_ppm(const Scenario& scenario, std::size_t renderer) {
    std::int64_t fastest_ppm = 0;
    for (const Fault& fault : scenario.faults) {
        if (fault.kind == FaultKind::kDrift && static_cast<std::size_t>(fault.renderer) == renderer) {
            fastest_ppm = std::max<std::int64_t>(fastest_ppm, fault.ppm);
        }
    }
    return fastest_ppm;
}

}  // namespace

std::int64_t shortest_link_period_picoseconds(const Scenario& scenario, std::size_t renderer) {
    return clock_period_picoseconds(scenario.clocks.dvi_in_mhz) * kMillion /
           (kMillion + fastest_drift_ppm(scenario, renderer));
}

std::int64_t longest_core_period_picoseconds(const Scenario& scenario) {
    const MemoryConfig& memory = scenario.memory;
    std::int64_t period = std::numeric_limits<std::int64_t>::max();
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        const Renderer& renderer = scenario.renderers[r];
        const std::int64_t link = shortest_link_period_picoseconds(scenario, r);
        period = std::min({period, memory.write_block_words * link / least_block_cycles(memory),
                           verdict_link_clocks(renderer) * link /
                               longest_last_write_cycles(memory, renderer.image_words())});
    }
    return period;
}

std::int64_t shortest_dvi_in_period_picoseconds(const Scenario& scenario) {
    const MemoryConfig& memory = scenario.memory;
    const std::int64_t core = clock_period_picoseconds(scenario.clocks.core_mhz);
    std::int64_t period = 0;
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        const Renderer& renderer = scenario.renderers[r];
        const std::int64_t link =
            std::max(quotient_up(least_block_cycles(memory) * core, std::int64_t{memory.write_block_words}),
                     quotient_up(longest_last_write_cycles(memory, renderer.image_words()) * core,
                                 verdict_link_clocks(renderer)));
        period = std::max(period, quotient_up(link * (kMillion + fastest_drift_ppm(scenario, r)), kMillion));
    }
    return period;
}

int longest_word_wait_cycles(const Scenario& scenario) {
    const MemoryConfig& memory = scenario.memory;
    const int refresh = memory.refreshes() ? memory.refresh_cycles + memory.activate_cycles() : 0;
    constexpr int kBlocks = 3;
    const int writes =
        memory.shared()
            ? kBlocks * (longest_write_cycles(memory, memory.write_block_words) + memory.page_miss_cycles)
            : 0;
    return memory.page_miss_cycles + refresh + writes;
}

int longest_beat_gap_cycles(const Scenario& scenario) {
    return longest_word_wait_cycles(scenario) + cycles_per_beat(scenario.bus);
}

std::int64_t least_reset_cycles(const ClockConfig& clocks) {
    constexpr std::int64_t kEdges = 2;
    const std::int64_t core = clock_period_picoseconds(clocks.core_mhz);
    const std::int64_t slowest = std::max(
        {core, clock_period_picoseconds(clocks.dvi_in_mhz), clock_period_picoseconds(clocks.dvi_out_mhz)});
    return (kEdges * slowest + core - 1) / core;
}

/// Nothing may move while the machine waits for a link or for the next frame of the DVI outputs, while a page is opened, or
/// while all slots of a table are lost, each after an answer of the arbiter. Twice the longest such silence, and some for
/// short waits, is safe. In floating point, since legal settings multiply to more than a 64-bit count of picoseconds; a run
/// never gets that far.
std::int64_t watchdog_interval_picoseconds(const Scenario& scenario) {
    constexpr double kShortWaitsCycles = 10'000.0;
    constexpr double kLongestPicoseconds = 4.0e18;
    const auto core_period = static_cast<double>(clock_period_picoseconds(scenario.clocks.core_mhz));
    double interval = static_cast<double>(scenario.watchdog_cycles) * core_period;
    if (scenario.watchdog_cycles == 0) {
        const auto dvi_in_period = static_cast<double>(clock_period_picoseconds(scenario.clocks.dvi_in_mhz));
        const auto dvi_out_period =
            static_cast<double>(clock_period_picoseconds(scenario.clocks.dvi_out_mhz));
        double quiet = 0.0;
        for (const Renderer& renderer : scenario.renderers) {
            quiet =
                std::max(quiet, static_cast<double>(link_timeout_clocks(scenario, renderer)) * dvi_in_period);
        }
        const DviTiming out = scenario.displays.timing();
        quiet += 2.0 * static_cast<double>(out.frame_clocks()) * dvi_out_period;
        quiet += static_cast<double>(scenario.links.latency_clocks()) * (dvi_in_period + dvi_out_period);
        double bus_cycles =
            longest_word_wait_cycles(scenario) + bus_loop_cycles(scenario.bus, scenario.memory) +
            scenario.bus.grant_cycles +
            scenario.bus.build_cycles(static_cast<std::size_t>(most_slots(scenario.displays.count())));
        if (loses_slots(scenario.bus.arbitration)) {
            bus_cycles += static_cast<double>(most_slots(scenario.displays.count())) *
                          static_cast<double>(lost_slot_cycles(scenario) + scenario.bus.grant_cycles);
        }
        std::int64_t reset_cycles = 0;
        for (const Fault& fault : scenario.faults) {
            if (fault.kind == FaultKind::kReset)
                reset_cycles = std::max(reset_cycles, fault.cycles.value_or(0));
        }
        interval = 2.0 * quiet + (2.0 * bus_cycles + 2.0 * static_cast<double>(reset_cycles) +
                                  static_cast<double>(scenario.renderers.size()) + kShortWaitsCycles) *
                                     core_period;
    }
    return static_cast<std::int64_t>(std::min(interval, kLongestPicoseconds));
}

}  // namespace metabuffer
