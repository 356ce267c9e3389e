#include "load_scenario.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "datapath/arbitration/arbitration_table.h"
#include "scenario/derived_timing.h"
#include "scenario/limits.h"
#include "scenario/scenario_loader.h"
#include "scenario/scenario_rules.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

namespace metabuffer::test {
namespace {

DisplayConfig random_displays(Random& random) {
    DisplayConfig displays;
    displays.columns = random.between(1, 3);
    displays.rows = random.between(1, 3);
    displays.width_pixels = random.between(4, 72);
    displays.height_pixels = random.between(4, 48);
    if (random.one_in(8)) displays.supersample = 2;
    return displays;
}

int random_multiple(Random& random) {
    if (random.one_in(20)) return random.between(5, 30);
    return random.one_in(2) ? 1 : random.between(2, 4);
}

ViewportTable random_rows(Random& random, const ViewportLimits& limits) {
    ViewportTable table;
    const int common = random_multiple(random);
    for (int display = 1; display <= limits.displays; ++display) {
        if (random.one_in(4)) continue;
        table.push_back(
            random_row(random, limits, display, random.one_in(2) ? common : random_multiple(random)));
    }
    shuffle_rows(random, table);
    return table;
}

/// An image as large as a good part of the wall, somewhere on it.
Renderer random_renderer(Random& random, const Scenario& scenario, int index) {
    constexpr int kLargestImage = 160;
    const DisplayWall wall = scenario.displays.wall();
    const int multiple = random_multiple(random);
    const int wall_width = wall.columns * wall.raster_width_pixels;
    const int wall_height = wall.rows * wall.raster_height_pixels;
    Renderer renderer;
    renderer.name = "renderer_" + std::to_string(index + 1);
    renderer.image_width_pixels =
        std::clamp(wall_width * random.between(20, 110) / (100 * multiple), 1, kLargestImage);
    renderer.image_width_pixels = std::max(
        renderer.image_width_pixels, width_for_rows(static_cast<std::size_t>(scenario.displays.count())));
    renderer.image_height_pixels =
        std::clamp(wall_height * random.between(20, 110) / (100 * multiple), 2, kLargestImage);
    renderer.images.push_back(std::make_shared<const StoredImage>(
        PixelImage(renderer.image_width_pixels, renderer.image_height_pixels, scenario.background_pixel())));
    const bool by_rows = random.one_in(4);
    for (int frame = random.between(1, scenario.frames); frame > 0; --frame) {
        RendererFrame entry;
        if (by_rows) {
            entry.table = random_rows(random, scenario.limits(renderer));
        } else {
            Viewport viewport;
            viewport.multiple = multiple;
            const auto position = [&](int image, int extent) {
                const int room = extent - image * multiple;
                return random.between(std::min(0, room) - extent / 8, std::max(0, room) + extent / 8);
            };
            viewport.x = position(renderer.image_width_pixels, wall_width);
            viewport.y = position(renderer.image_height_pixels, wall_height);
            entry.viewport = viewport;
            entry.table =
                split_viewport(viewport, renderer.image_width_pixels, renderer.image_height_pixels, wall);
        }
        renderer.frames.push_back(std::move(entry));
    }
    return renderer;
}

/// Pixels a clock that a table needs in its busiest raster row, if all columns run side by side.
double busiest_row(const ViewportTable& table, const DisplayWall& wall) {
    double most = 0.0;
    for (int y = 0; y < wall.raster_height_pixels; ++y) {
        double sum = 0.0;
        for (const ViewportRow& row : table) {
            if (y < row.dy || y >= row.dy + row.sdy * row.dmultiple) continue;
            sum += static_cast<double>(row.sdx) / (row.dmultiple * wall.raster_width_pixels);
        }
        most = std::max(most, sum);
    }
    return most;
}

/// The part of the clocks that a memory has for bursts, about: for a link that always sends.
double free_share(const Scenario& scenario, const MemoryConfig& memory) {
    double share = 1.0;
    if (memory.refreshes())
        share -= static_cast<double>(memory.refresh_cycles) / memory.refresh_interval_cycles;
    if (memory.shared()) {
        constexpr double kLinePauses = 0.6;
        const double words = kLinePauses * scenario.clocks.dvi_in_mhz / scenario.clocks.core_mhz;
        share -=
            words * (1.0 / memory.words_per_cycle + 2.0 * memory.page_miss_cycles / memory.write_block_words);
    }
    return std::max(0.1, share);
}

/// Chooses, of random buses and memories, the one that comes closest to what the tables need, or to some share of it.
void choose_bus(Random& random, Scenario& scenario) {
    constexpr int kTries = 12;
    double needed = 0.0;
    for (const Renderer& renderer : scenario.renderers) {
        for (const RendererFrame& frame : renderer.frames) {
            needed = std::max(needed, busiest_row(frame.table, scenario.displays.wall()));
        }
    }
    const double wanted = needed * one_of(random, std::array<double, 6>{0.6, 0.9, 1.1, 1.4, 1.8, 3.0});
    double closest = std::numeric_limits<double>::max();
    for (int tried = 0; tried < kTries; ++tried) {
        BusConfig bus = scenario.bus;
        MemoryConfig memory = scenario.memory;
        bus.width_bits = 16 << random.between(0, 5);
        bus.burst_pixels =
            random.one_in(3) ? one_of(random, std::array<int, 4>{8, 16, 32, 64}) : random.between(1, 48);
        memory.words_per_cycle = random.between(1, 8);
        memory.page_words = random.one_in(4) ? 512 : random.between(4, 128);
        memory.page_miss_cycles = random.one_in(3) ? 0 : random.between(1, 10);
        const double burst_cycles =
            bus.grant_cycles +
            static_cast<double>(bus.burst_pixels) / pixels_per_beat(bus, memory) * cycles_per_beat(bus) +
            memory.page_miss_cycles * (1.0 + static_cast<double>(bus.burst_pixels) / memory.page_words);
        const double carried = bus.burst_pixels / burst_cycles * free_share(scenario, memory);
        const double distance = std::abs(carried - wanted) / wanted;
        if (distance < closest) {
            closest = distance;
            scenario.bus = bus;
            scenario.memory = memory;
        }
    }
}

/// Pairs that are late or do not come, so that frames are made of earlier ones.
void add_faults(Random& random, Scenario& scenario) {
    for (int renderer = 0; renderer < static_cast<int>(scenario.renderers.size()); ++renderer) {
        Fault fault;
        fault.renderer = renderer;
        fault.pair = static_cast<std::uint32_t>(random.between(0, scenario.frames - 1));
        fault.kind = random.one_in(2) ? FaultKind::kMissing : FaultKind::kDelay;
        fault.delay_pairs = fault.kind == FaultKind::kDelay ? random.between(1, 4) : 0;
        scenario.faults.push_back(fault);
    }
}

/// By random numbers of its own, so that a seed's machine stays what it is otherwise.
void choose_smoothing(std::uint64_t seed, Scenario& scenario) {
    constexpr std::uint64_t kOwnSequence = 0x536D6F6F;
    Random random(seed ^ kOwnSequence);
    if (random.one_in(3)) smooth_tables(random, scenario);
}

/// Blocks and pages for a memory with shared ports that has written the link's words in time, if there are such. Otherwise
/// the ports are dual.
void choose_blocks(Random& random, Scenario& scenario) {
    MemoryConfig& memory = scenario.memory;
    const int page_words = memory.page_words;
    const int interval =
        memory.refresh_interval_cycles - static_cast<int>(least_refresh_interval_cycles(memory));
    for (int words = 8 << random.between(0, 3); words <= 256; words *= 2) {
        memory.write_block_words = words;
        memory.page_words = (page_words + words - 1) / words * words;
        if (memory.refreshes()) {
            memory.refresh_interval_cycles =
                std::max(memory.refresh_interval_cycles,
                         interval + static_cast<int>(least_refresh_interval_cycles(memory)));
        }
        if (!settings_violation(scenario) && !renderers_violation(scenario)) return;
    }
    memory.ports = MemoryPorts::kDual;
}

/// Likewise. Banks, refreshes, shared ports, delays and a slow arbiter, in two of three machines.
void choose_memory(std::uint64_t seed, Scenario& scenario) {
    constexpr std::uint64_t kOwnSequence = 0x4D656D6F;
    Random random(seed ^ kOwnSequence);
    if (random.one_in(3)) return;
    MemoryConfig& memory = scenario.memory;
    BusConfig& bus = scenario.bus;
    if (random.one_in(2)) memory.banks = one_of(random, limits::kMemoryBanks);
    if (random.one_in(2)) {
        memory.refresh_cycles = random.between(1, 20);
        memory.refresh_interval_cycles = 60 + memory.refresh_cycles * random.between(3, 40);
    }
    if (random.one_in(2)) memory.ports = MemoryPorts::kShared;
    if (random.one_in(2)) {
        memory.read_latency_cycles = random.between(0, 6);
        bus.register_stages = random.between(memory.read_latency_cycles == 0 ? 1 : 0, 3);
    }
    if (random.one_in(6)) bus.grant_cycles = random.between(1, 6);
    if (random.one_in(6)) bus.slot_table = SlotTableMaker::kBuilt;
    choose_bus(random, scenario);
    if (memory.banks > 1) {
        const int most = std::min(memory.page_miss_cycles, static_cast<int>(limits::kPrechargeCycles.high));
        memory.precharge_cycles = random.between(0, most);
    }
    if (memory.shared()) choose_blocks(random, scenario);
    // While the only frame is sent, the link would have no other pair to write.
    if (memory.shared()) scenario.frames = std::max(2, scenario.frames);
}

}  // namespace

Scenario random_load_scenario(std::uint64_t seed) {
    Random random(seed);
    Scenario scenario;
    scenario.name = "load_" + std::to_string(seed);
    scenario.displays = random_displays(random);
    const std::array<double, 6> mhz{100.0, 100.0, 100.0, 50.0, 200.0, 133.3};
    scenario.clocks = {one_of(random, mhz), one_of(random, mhz), one_of(random, mhz)};
    scenario.composer.buffer_pixels = static_cast<int>(limits::kBufferPixels.high);
    scenario.frames = random.between(1, 3);
    scenario.pacing = random.one_in(4) ? Pacing::kFreeRunning : Pacing::kLockstep;
    scenario.bus.arbitration =
        random.one_in(2) ? Arbitration::kIrsa : one_of(random, kArbitrationTable).value;
    const int renderers = random.one_in(2) ? 1 : random.between(1, 3);
    for (int index = 0; index < renderers; ++index) {
        scenario.renderers.push_back(random_renderer(random, scenario, index));
    }
    choose_bus(random, scenario);
    choose_memory(seed, scenario);
    const int in_flight = in_flight_pixels(scenario.bus, scenario.memory);
    const int burst = scenario.bus.burst_pixels;
    int ready = burst;
    if (random.one_in(3)) ready = random.one_in(2) ? random.between(1, 2 * burst) : in_flight;
    scenario.composer.ready_space_pixels = std::max(in_flight, ready);
    if (random.one_in(6)) add_faults(random, scenario);
    choose_smoothing(seed, scenario);
    check_scenario(scenario);
    return scenario;
}

std::vector<std::string> machine_kinds(const Scenario& scenario) {
    const MemoryConfig& memory = scenario.memory;
    const BusConfig& bus = scenario.bus;
    std::vector<std::string> kinds;
    if (memory.banks > 1) kinds.emplace_back("banks");
    if (memory.refreshes()) kinds.emplace_back("refresh");
    if (memory.shared()) kinds.emplace_back("shared");
    if (bus_loop_cycles(bus, memory) > 0) kinds.emplace_back("delays");
    if (bus.grant_cycles > 0 || bus.slot_table == SlotTableMaker::kBuilt) kinds.emplace_back("arbiter");
    return kinds;
}

}  // namespace metabuffer::test
