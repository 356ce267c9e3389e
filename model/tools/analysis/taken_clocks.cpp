#include "tools/analysis/taken_clocks.h"

#include <algorithm>

#include "formats/dvi_timing.h"
#include "scenario/derived_timing.h"
#include "tools/analysis/arithmetic.h"

namespace metabuffer::analysis {
namespace {

/// Core clocks in a clock of the renderer's link.
double core_cycles_per_link_clock(const Scenario& scenario, std::size_t renderer) {
    return as_double(shortest_link_period_picoseconds(scenario, renderer)) /
           as_double(clock_period_picoseconds(scenario.clocks.core_mhz));
}

/// Words in a clock of the link, as a mean over its lines. Each has a pause.
double words_per_link_clock(const Renderer& renderer) {
    return as_double(renderer.image_width_pixels) / as_double(renderer.timing().line_clocks());
}

/// The most blocks that become full in a window of no clocks, where `per_cycle` of them do so in each clock more.
double blocks_at_once(const Scenario& scenario, const Renderer& renderer, double per_cycle) {
    const std::int64_t block = scenario.memory.write_block_words;
    const DviTiming timing = renderer.timing();
    // A window that begins where a line does has no pause of the first line.
    const double pause = as_double(timing.line_clocks() - renderer.image_width_pixels);
    double blocks = 1.0 + words_per_link_clock(renderer) * pause / as_double(block);
    // The last block of an image may have fewer words, but after it the link pauses for some lines.
    const std::int64_t rest = renderer.image_words() % block;
    const std::int64_t lines = timing.frame_clocks() / timing.line_clocks() - renderer.image_height_pixels;
    const std::int64_t paused_words = lines * renderer.image_width_pixels;
    if (rest > 0)
        blocks += as_double(std::max<std::int64_t>(0, block - rest - paused_words)) / as_double(block);
    constexpr double kEdgeCycles = 2.0;  // a block becomes full between two core clocks
    return blocks + kEdgeCycles * per_cycle;
}

}  // namespace

double TakenClocks::stretch() const {
    // A memory that never rests still gives some words now and then (least_refresh_interval_cycles, least_block_cycles).
    constexpr double kSlowest = 1e6;
    return share < 1.0 - 1.0 / kSlowest ? 1.0 / (1.0 - share) : kSlowest;
}

Interruption refreshes(const MemoryConfig& memory) {
    if (!memory.refreshes()) return {};
    return {as_double(memory.refresh_cycles + memory.activate_cycles()),
            1.0 / as_double(memory.refresh_interval_cycles)};
}

double write_cycles(const MemoryConfig& memory) {
    return as_double(longest_write_cycles(memory, memory.write_block_words) + memory.page_miss_cycles);
}

Interruption link_writes(const Scenario& scenario, std::size_t renderer) {
    const MemoryConfig& memory = scenario.memory;
    if (!memory.shared()) return {};
    const double words_per_cycle =
        words_per_link_clock(scenario.renderers[renderer]) / core_cycles_per_link_clock(scenario, renderer);
    return {write_cycles(memory), words_per_cycle / as_double(memory.write_block_words)};
}

std::int64_t least_write_cycles(const MemoryConfig& memory, std::int64_t image_words) {
    const std::int64_t blocks = divide_up(image_words, memory.write_block_words);
    const std::int64_t last = image_words - (blocks - 1) * memory.write_block_words;
    return divide_up(image_words, memory.page_words) * memory.activate_cycles() +
           (blocks - 1) * memory.write_cycles(memory.write_block_words) +
           memory.write_cycles(static_cast<int>(last));
}

TakenClocks taken_clocks(const Scenario& scenario, std::size_t renderer, bool opens_each) {
    const MemoryConfig& memory = scenario.memory;
    TakenClocks taken;
    if (const Interruption each = refreshes(memory); each.cycles > 0.0) {
        // They come at even distances, and a window begins at worst with a whole one.
        taken.share += each.share();
        taken.once += each.cycles * std::max(0.0, 1.0 - each.share());
        if (!opens_each) taken.once += as_double(memory.activate_cycles());
    }
    if (const Interruption each = link_writes(scenario, renderer); each.cycles > 0.0) {
        // Blocks may wait, so that those of an earlier time fall into the window, too.
        const std::int64_t synchronizer = 3;
        const double delay =
            as_double(longest_write_delay_cycles(memory) - synchronizer + memory.page_miss_cycles);
        const double blocks = blocks_at_once(scenario, scenario.renderers[renderer], each.per_cycle);
        taken.share += each.share();
        taken.once += each.cycles * (blocks + each.per_cycle * std::max(0.0, delay - each.cycles / 2.0));
        if (!opens_each) taken.once += as_double(memory.page_miss_cycles);
    }
    return taken;
}

}  // namespace metabuffer::analysis
