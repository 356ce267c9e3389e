#include "random_scenario.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <sstream>
#include <utility>

#include "formats/control_scanline.h"
#include "formats/slot_payload.h"
#include "replicates_only.h"
#include "scenario/derived_timing.h"
#include "scenario/fault_keys.h"
#include "scenario/fault_kinds.h"
#include "scenario/limits.h"
#include "scenario/names.h"
#include "scenario/scenario_loader.h"
#include "scenario/scenario_rules.h"
#include "support/colour_tables.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

namespace metabuffer::test {
namespace {

constexpr int kLargestExtent = 64;  // of an image, both ways

std::uint8_t channel(Random& random) { return static_cast<std::uint8_t>(random.between(0, 255)); }

DisplayConfig random_displays(Random& random) {
    DisplayConfig displays;
    displays.columns = random.between(1, 3);
    displays.rows = random.between(1, 2);
    displays.width_pixels = random.between(4, 40);
    displays.height_pixels = random.between(3, 30);
    displays.supersample = one_of(random, std::array<int, 6>{1, 1, 1, 2, 2, 4});
    if (displays.supersample == 4) {
        displays.width_pixels = random.between(4, 20);  // the raster has sixteen times the pixels
        displays.height_pixels = random.between(3, 16);
    }
    if (random.one_in(8)) {  // so short a frame that the handshakes of two frames meet
        displays.supersample = 1;
        displays.width_pixels = random.between(1, 3);
        displays.height_pixels = random.between(1, 2);
    }
    for (std::uint8_t& background : displays.background) background = channel(random);
    return displays;
}

ClockConfig random_clocks(Random& random) {
    const std::array<double, 8> mhz{100.0, 100.0, 50.0, 200.0, 73.5, 66.6, 133.3, 91.7};
    return {one_of(random, mhz), one_of(random, mhz), one_of(random, mhz)};
}

/// Few different depths, both ends among them, so that images tie with each other and with the background.
PixelImage random_image(Random& random, int width, int height, DepthFormat format) {
    const std::uint32_t far = far_z(format);
    const std::array<std::uint32_t, 6> depths{0, 1, far / 2, far / 2 + 1, far - 1, far};
    const std::array<std::uint8_t, 4> alphas{0, 255, 128, channel(random)};
    PixelImage image(width, height);
    for (Pixel& pixel : image.values) {
        const std::uint32_t z =
            random.one_in(8) ? static_cast<std::uint32_t>(random.bits()) & far : one_of(random, depths);
        pixel = Pixel(channel(random), channel(random), channel(random), one_of(random, alphas), z);
    }
    return image;
}

int random_multiple(Random& random) {
    if (random.one_in(12)) return random.between(7, kMaximumMultiple);
    return random.one_in(2) ? 1 : random.between(1, 6);
}

/// Breaks one of a row's rules; the table may make a duplicate of it as well.
void corrupt(Random& random, ViewportRow& row, const ViewportLimits& limits) {
    const int m = row.dmultiple;
    switch (random.between(0, 9)) {
        case 0:
            row.dcomp = 0;
            break;
        case 1:
            row.dcomp = static_cast<std::uint16_t>(limits.displays + random.between(1, 1000));
            break;
        case 2:
            row.dmultiple = 0;
            break;
        case 3:
            row.dmultiple = static_cast<std::uint16_t>(random.between(256, 65535));
            break;
        case 4:
            (random.one_in(2) ? row.sdx : row.sdy) = 0;
            break;
        case 5:
            row.sx = static_cast<std::uint16_t>(limits.image_width_pixels - row.sdx + 1);
            break;
        case 6:
            row.sdy = static_cast<std::uint16_t>(limits.image_height_pixels - row.sy + 1);
            break;
        case 7:
            row.dx = static_cast<std::int16_t>(-m);
            break;
        case 8:
            row.dy = static_cast<std::int16_t>(limits.raster_height_pixels);
            break;
        case 9:
            row.dx = static_cast<std::int16_t>(limits.raster_width_pixels + m - row.sdx * m);
            break;
        default:
            break;
    }
}

ViewportTable random_table(Random& random, const ViewportLimits& limits) {
    ViewportTable table;
    for (int display = 1; display <= limits.displays; ++display) {
        if (!random.one_in(5)) table.push_back(random_row(random, limits, display, random_multiple(random)));
    }
    for (int extra = random.between(0, 3); extra > 0; --extra) {
        const int display = random.between(1, limits.displays);  // maybe a duplicate
        ViewportRow row = random_row(random, limits, display, random_multiple(random));
        if (!random.one_in(3)) corrupt(random, row, limits);
        table.push_back(row);
    }
    shuffle_rows(random, table);
    return table;
}

Viewport random_viewport(Random& random, const DisplayWall& wall, int image_width, int image_height) {
    Viewport viewport;
    viewport.multiple = random_multiple(random);
    const int width = wall.columns * wall.raster_width_pixels;
    const int height = wall.rows * wall.raster_height_pixels;
    const bool outside = random.one_in(4);
    viewport.x = random.between(outside ? -image_width * viewport.multiple - 2 : -width / 4, width - 1);
    viewport.y = random.between(outside ? -image_height * viewport.multiple - 2 : -height / 4, height - 1);
    return viewport;
}

Renderer random_renderer(Random& random, const Scenario& scenario, int index) {
    Renderer renderer;
    renderer.name = "renderer_" + std::to_string(index + 1);
    renderer.image_height_pixels = random.between(4, 40);
    // Wide enough for a row for each display and the extra ones.
    const int longest = width_for_rows(static_cast<std::size_t>(scenario.displays.count()) + 3);
    renderer.image_width_pixels =
        std::max(random.between(12, kLargestExtent), random.one_in(2) ? longest : 12);
    const int frames = random.between(1, 3);
    const int images = random.between(1, frames);
    for (int frame = 0; frame < frames; ++frame) {
        RendererFrame entry;
        entry.image = static_cast<std::size_t>(std::min(frame, images - 1));
        if (random.one_in(2)) {
            entry.viewport = random_viewport(random, scenario.displays.wall(), renderer.image_width_pixels,
                                             renderer.image_height_pixels);
            entry.table = split_viewport(*entry.viewport, renderer.image_width_pixels,
                                         renderer.image_height_pixels, scenario.displays.wall());
        } else {
            entry.table = random_table(random, scenario.limits(renderer));
        }
        // What does not fit the scanline is the host's error: a narrow image has fewer rows.
        while (width_for_rows(entry.table.size()) > renderer.image_width_pixels) {
            entry.viewport.reset();
            entry.table.pop_back();
        }
        renderer.frames.push_back(std::move(entry));
    }
    for (int image = 0; image < images; ++image) {
        renderer.images.push_back(std::make_shared<const StoredImage>(random_image(
            random, renderer.image_width_pixels, renderer.image_height_pixels, scenario.depth_format)));
    }
    return renderer;
}

/// What the fault's kind needs beside the frame that it names.
void choose_fault_keys(Random& random, const Renderer& renderer, Fault& fault) {
    switch (fault.kind) {
        case FaultKind::kDelay:
            fault.delay_pairs = random.between(1, 4);
            break;
        case FaultKind::kShortFrame:
        case FaultKind::kLongFrame:
            fault.lines = random.one_in(2) ? 1 : random.between(1, renderer.image_height_pixels);
            break;
        case FaultKind::kControlByte:
            fault.byte = random.between(
                0, (random.one_in(2) ? 16 : kLinkBytesPerPixel * renderer.image_width_pixels) - 1);
            fault.bits = static_cast<std::uint32_t>(random.between(1, 255));
            break;
        case FaultKind::kPixelBits:
            fault.x = random.between(0, renderer.image_width_pixels - 1);
            fault.y = random.between(0, renderer.image_height_pixels - 1);
            fault.bits = static_cast<std::uint32_t>(random.between(1, 0xFF'FFFF));
            break;
        default:
            for (const FaultKeyUse& use : fault_keys_of(fault.kind)) {
                if (!use.key->required || std::string(use.key->name()) == "pair") continue;
                const IntegerRange& range = use.rule.whole;
                use.key->set(fault, std::int64_t{random.between(static_cast<int>(range.low),
                                                                static_cast<int>(range.high))});
            }
            break;
    }
}

/// A kind of fault in one frame of a link.
FaultKind random_frame_fault(Random& random) {
    static const std::vector<FaultKind> kinds = [] {
        std::vector<FaultKind> result;
        for (const FaultTraits& traits : kFaultKinds) {
            if (traits.location == FaultLocation::kFrame) result.push_back(traits.value);
        }
        return result;
    }();
    return kinds[static_cast<std::size_t>(random.between(0, static_cast<int>(kinds.size()) - 1))];
}

/// At most one fault a pair: two can make a good pair of another number.
void add_random_faults(Random& random, Scenario& scenario) {
    for (int r = 0; r < static_cast<int>(scenario.renderers.size()); ++r) {
        for (int pair = 0; pair < scenario.frames; ++pair) {
            if (!random.one_in(4)) continue;
            Fault fault;
            fault.renderer = r;
            fault.pair = static_cast<std::uint32_t>(pair);
            fault.kind = random_frame_fault(random);
            fault.frame = random.one_in(2) ? FrameKind::kColour : FrameKind::kDepth;
            choose_fault_keys(random, scenario.renderers[static_cast<std::size_t>(r)], fault);
            scenario.faults.push_back(fault);
        }
    }
}

void choose_buffer(Random& random, Scenario& scenario) {
    const int in_flight = in_flight_pixels(scenario.bus, scenario.memory);
    ComposerConfig& composer = scenario.composer;
    switch (random.between(0, 2)) {
        case 0:
            composer.ready_space_pixels = in_flight;
            break;
        case 1:
            composer.ready_space_pixels = std::max(scenario.bus.burst_pixels, in_flight);
            break;
        default:
            composer.ready_space_pixels = in_flight + random.between(0, 40);
            break;
    }
    switch (random.between(0, 4)) {
        case 0:
            composer.buffer_pixels = composer.ready_space_pixels;
            break;  // replicated rows never fit
        case 1:
            composer.buffer_pixels = composer.ready_space_pixels + random.between(1, 12);
            break;
        case 2:
            composer.buffer_pixels = composer.ready_space_pixels + random.between(12, 64);
            break;
        case 3:
            composer.buffer_pixels = composer.ready_space_pixels + 64;
            break;  // the widest row just fits
        default:
            composer.buffer_pixels = composer.ready_space_pixels + random.between(100, 2000);
            break;
    }
}

/// Uses separate random numbers, so that the rest of a seed's machine stays what it is.
void choose_banks(std::uint64_t seed, MemoryConfig& memory) {
    constexpr std::uint64_t kOwnSequence = 0x42616E6B;
    Random random(seed ^ kOwnSequence);
    if (random.one_in(2)) return;
    memory.banks = one_of(random, limits::kMemoryBanks);
    const int most = std::min(memory.page_miss_cycles, static_cast<int>(limits::kPrechargeCycles.high));
    memory.precharge_cycles = random.between(0, most);
}

/// Likewise. Some refreshes follow each other so closely that a page is hardly opened in between.
void choose_refresh(std::uint64_t seed, MemoryConfig& memory) {
    constexpr std::uint64_t kOwnSequence = 0x52656672;
    Random random(seed ^ kOwnSequence);
    if (!random.one_in(3)) return;
    memory.refresh_cycles = random.one_in(8) ? random.between(1, 200) : random.between(1, 20);
    memory.refresh_interval_cycles = static_cast<int>(least_refresh_interval_cycles(memory)) +
                                     (random.one_in(4) ? random.between(0, 12) : random.between(0, 500));
}

/// Likewise. Chooses a block that the memory has written in time, if there is one.
void choose_ports(std::uint64_t seed, Scenario& scenario) {
    constexpr std::uint64_t kOwnSequence = 0x506F7274;
    Random random(seed ^ kOwnSequence);
    if (!random.one_in(3)) return;
    const MemoryConfig given = scenario.memory;
    MemoryConfig& memory = scenario.memory;
    memory.ports = MemoryPorts::kShared;
    memory.words_per_cycle = random.between(1, 8);
    // From the smallest block that will do, or a larger one.
    const int larger = random.between(0, 2);
    int found = 0;
    for (int words = 1; words <= 256 && found <= larger; words += words < 16 ? 1 : words / 8) {
        memory.write_block_words = words;
        memory.page_words = words * (1 + given.page_words / words);
        if (memory.refreshes()) {
            // As close to the least as it was.
            memory.refresh_interval_cycles =
                static_cast<int>(given.refresh_interval_cycles - least_refresh_interval_cycles(given) +
                                 least_refresh_interval_cycles(memory));
        }
        if (settings_violation(scenario) || renderers_violation(scenario)) continue;
        ++found;
    }
    if (settings_violation(scenario) || renderers_violation(scenario)) memory = given;
}

/// Likewise. A buffer that would not hold what can be in flight grows by as much.
void choose_bus_delay(std::uint64_t seed, Scenario& scenario) {
    constexpr std::uint64_t kOwnSequence = 0x44656C61;
    Random random(seed ^ kOwnSequence);
    if (!random.one_in(3)) return;
    if (!random.one_in(3)) {
        scenario.memory.read_latency_cycles =
            random.between(1, static_cast<int>(limits::kReadLatencyCycles.high));
    }
    if (!random.one_in(3)) {
        scenario.bus.register_stages = random.between(1, static_cast<int>(limits::kRegisterStages.high));
    }
    const int in_flight = in_flight_pixels(scenario.bus, scenario.memory);
    const int missing = std::max(0, in_flight - scenario.composer.ready_space_pixels);
    scenario.composer.ready_space_pixels += missing;
    scenario.composer.buffer_pixels += missing;
}

/// Likewise.
void choose_arbiter(std::uint64_t seed, BusConfig& bus) {
    constexpr std::uint64_t kOwnSequence = 0x4772616E;
    Random random(seed ^ kOwnSequence);
    if (!random.one_in(3)) return;
    if (random.one_in(2)) bus.grant_cycles = random.one_in(8) ? random.between(0, 255) : random.between(0, 9);
    if (random.one_in(2)) bus.slot_table = SlotTableMaker::kBuilt;
}

/// Likewise.
void choose_links(std::uint64_t seed, LinkConfig& links) {
    constexpr std::uint64_t kOwnSequence = 0x4C696E6B;
    Random random(seed ^ kOwnSequence);
    if (random.one_in(4)) links.layer = LinkLayer::kTmds;
}

/// Likewise. Displays with tables of any kind beside others without.
void choose_correction(std::uint64_t seed, DisplayConfig& displays) {
    constexpr std::uint64_t kOwnSequence = 0x436F6C6F;
    Random random(seed ^ kOwnSequence);
    if (!random.one_in(3)) return;
    const bool all = random.one_in(4);
    for (int display = displays.count(); display >= 1; --display) {
        if (!all && random.one_in(2)) continue;
        DisplayCorrection& correction = displays.correction.emplace_back();
        correction.display = display;
        if (random.one_in(3)) {
            correction.lut = std::make_shared<const ColourTable>(random_colour_table(random));
            continue;
        }
        for (double& gain : correction.gain) gain = random.between(50, 150) / 100.0;
        correction.gamma = random.one_in(3) ? 1.0 : random.between(40, 250) / 100.0;
    }
}

/// The host's own slot tables, some of them wrong. Likewise.
void choose_slots(std::uint64_t seed, Scenario& scenario) {
    constexpr std::uint64_t kOwnSequence = 0x536C6F74;
    Random random(seed ^ kOwnSequence);
    if (!random.one_in(4)) return;
    for (Renderer& renderer : scenario.renderers) {
        const std::size_t payload = payload_room_bytes(renderer.image_width_pixels);
        for (RendererFrame& entry : renderer.frames) {
            if (entry.table.empty() || random.one_in(3)) continue;
            std::vector<int>& slots = entry.slots.emplace();
            if (random.one_in(6)) continue;  // missing
            const bool wrong = random.one_in(6);
            for (const ViewportRow& row : entry.table) {
                if (!wrong || random.one_in(2)) slots.push_back(row.dcomp);
            }
            for (int more = random.between(0, 9); more > 0; --more) {
                const auto row =
                    static_cast<std::size_t>(random.between(0, static_cast<int>(entry.table.size()) - 1));
                const auto slot =
                    static_cast<std::ptrdiff_t>(random.between(0, static_cast<int>(slots.size())));
                slots.insert(slots.begin() + slot, entry.table[row].dcomp);
            }
            slots.resize(std::min(slots.size(), slots_in_payload(payload, entry.table.size())));
        }
    }
}

/// Likewise. Often grows the buffers, which must hold two source rows.
void choose_smoothing(std::uint64_t seed, Scenario& scenario) {
    if (kReplicatesOnly) return;
    constexpr std::uint64_t kOwnSequence = 0x536D6F6F;
    Random random(seed ^ kOwnSequence);
    if (!random.one_in(3)) return;
    if (!random.one_in(4)) scenario.composer.buffer_pixels += random.between(0, 2 * kLargestExtent);
    smooth_tables(random, scenario);
    if (!random.one_in(4)) return;
    // As little as some row takes.
    for (const RendererFrame& entry : scenario.renderers.front().frames) {
        for (const ViewportRow& row : entry.table) {
            if (row.dmultiple < 2 || row.sdx == 0) continue;
            scenario.composer.buffer_pixels = 2 * row.sdx + scenario.composer.ready_space_pixels;
        }
    }
}

}  // namespace

Scenario random_scenario(std::uint64_t seed) {
    Random random(seed);
    Scenario scenario;
    scenario.name = "random_" + std::to_string(seed);
    scenario.displays = random_displays(random);
    scenario.composition = one_of(random, kCompositionTable).value;
    scenario.depth_format = one_of(random, kDepthFormatTable).value;
    scenario.clocks = random_clocks(random);
    scenario.memory.page_words = random.between(4, 64);
    scenario.memory.page_miss_cycles = random.between(0, 12);
    scenario.memory.words_per_cycle = random.between(1, 8);
    scenario.bus.width_bits = 16 << random.between(0, 5);
    scenario.bus.burst_pixels = random.between(1, 64);
    scenario.bus.arbitration = one_of(random, kArbitrationTable).value;
    scenario.composer.on_starvation = random.one_in(2) ? StarvationMode::kGlitch : StarvationMode::kStall;
    choose_buffer(random, scenario);
    scenario.pacing = random.one_in(3) ? Pacing::kFreeRunning : Pacing::kLockstep;
    scenario.frames = random.between(1, 3);
    const int renderers = random.between(1, 4);
    for (int index = 0; index < renderers; ++index) {
        scenario.renderers.push_back(random_renderer(random, scenario, index));
    }
    scenario.link_timeout_pairs = random.between(1, 4);
    if (random.one_in(3)) {
        add_random_faults(random, scenario);
    }
    choose_banks(seed, scenario.memory);
    choose_refresh(seed, scenario.memory);
    choose_arbiter(seed, scenario.bus);
    choose_slots(seed, scenario);
    choose_links(seed, scenario.links);
    choose_bus_delay(seed, scenario);
    choose_smoothing(seed, scenario);
    choose_ports(seed, scenario);
    choose_correction(seed, scenario.displays);
    check_scenario(scenario);
    return scenario;
}

Scenario random_long_scenario(std::uint64_t seed) {
    constexpr int kMostFrames = 8;
    constexpr std::uint64_t kOwnSequence = 0x4C6F6E67;  // not the numbers that made the scenario
    Scenario scenario = random_scenario(seed);
    Random random(seed ^ kOwnSequence);
    scenario.name = "random_long_" + std::to_string(seed);
    scenario.frames = random.between(4, kMostFrames);
    if (random.one_in(4)) {
        const std::size_t renderers = scenario.renderers.size();
        for (int extra = random.between(1, 6); extra > 0; --extra) {
            Renderer copy =
                scenario
                    .renderers[static_cast<std::size_t>(random.between(0, static_cast<int>(renderers) - 1))];
            copy.name += "_again_" + std::to_string(extra);
            scenario.renderers.push_back(std::move(copy));
        }
    }
    for (Renderer& renderer : scenario.renderers) {
        const std::vector<RendererFrame> choice = renderer.frames;
        renderer.frames.clear();
        while (static_cast<int>(renderer.frames.size()) < scenario.frames) {
            RendererFrame entry =
                choice[static_cast<std::size_t>(random.between(0, static_cast<int>(choice.size()) - 1))];
            if (random.one_in(3)) {
                entry.table.clear();
                entry.viewport.reset();
                entry.slots.reset();
            }
            const int times = random.between(1, 4);
            renderer.frames.insert(renderer.frames.end(), static_cast<std::size_t>(times), entry);
        }
    }
    if (random.one_in(3)) {
        const int words = random.between(1, 3);
        scenario.memory.page_words = scenario.memory.shared() ? scenario.memory.write_block_words : words;
    }
    check_scenario(scenario);
    return scenario;
}

Scenario random_stalled_scenario(std::uint64_t seed) {
    Scenario scenario = random_scenario(seed);
    constexpr std::uint64_t kOwnSequence = 1'000'000;  // not the numbers that made the scenario
    Random random(seed + kOwnSequence);
    scenario.name = "random_stalled_" + std::to_string(seed);
    constexpr std::array<int, 4> kPercents{5, 20, 50, 80};
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        if (r > 0 && random.one_in(3)) continue;
        Fault fault;
        fault.kind = FaultKind::kRandomStalls;
        fault.renderer = static_cast<int>(r);
        fault.percent = kPercents[static_cast<std::size_t>(random.between(0, 3))];
        fault.seed = random.bits() >> 20U;
        fault.from_cycle = random.one_in(2) ? 0 : random.between(0, 2000);
        // Handshakes that are held back so often make a frame last long, and all machines run until the last one is
        // done. A bus that samples BUSREADY only once in a slot hardly ever finds it high then.
        const bool for_a_while = fault.percent > 50 || loses_slots(scenario.bus.arbitration);
        if (for_a_while || random.one_in(3)) fault.cycles = random.between(1, 2000);
        scenario.faults.push_back(fault);
    }
    check_scenario(scenario);
    return scenario;
}

Scenario random_level_scenario(std::uint64_t seed) {
    constexpr std::uint64_t kOneIn = 3;
    return seed % kOneIn == 0 ? random_long_scenario(seed) : random_scenario(seed);
}

std::string describe(const Scenario& scenario) {
    std::ostringstream text;
    const DisplayConfig& displays = scenario.displays;
    text << displays.columns << "x" << displays.rows << " displays of " << displays.width_pixels << "x"
         << displays.height_pixels << " (supersample " << displays.supersample << "), "
         << scenario.renderers.size() << " renderers, " << scenario.frames << " frames, "
         << to_string(scenario.composition) << ", " << to_string(scenario.depth_format) << ", "
         << to_string(scenario.pacing) << ", links of layer " << to_string(scenario.links.layer) << ", "
         << to_string(scenario.composer.on_starvation) << ", " << to_string(scenario.composer.smoothing)
         << ", " << to_string(scenario.bus.arbitration) << ", clocks " << scenario.clocks.core_mhz << "/"
         << scenario.clocks.dvi_in_mhz << "/" << scenario.clocks.dvi_out_mhz << " MHz, bus "
         << scenario.bus.width_bits << " bits, bursts of " << scenario.bus.burst_pixels << ", memory "
         << scenario.memory.words_per_cycle << " words a cycle, pages of " << scenario.memory.page_words
         << ", miss " << scenario.memory.page_miss_cycles << ", refresh " << scenario.memory.refresh_cycles
         << " every " << scenario.memory.refresh_interval_cycles << ", "
         << (scenario.memory.shared()
                 ? "shared ports, " + std::to_string(scenario.memory.write_block_words) + " words a write, "
                 : "")
         << "read latency " << scenario.memory.read_latency_cycles << ", register stages "
         << scenario.bus.register_stages << ", buffer " << scenario.composer.buffer_pixels << ", ready space "
         << scenario.composer.ready_space_pixels << ", timeout " << scenario.link_timeout_pairs
         << ", corrected displays " << displays.correction.size();
    for (const Renderer& renderer : scenario.renderers) {
        text << "; " << renderer.name << " " << renderer.image_width_pixels << "x"
             << renderer.image_height_pixels;
        for (const RendererFrame& frame : renderer.frames) {
            text << " [";
            for (const ViewportRow& row : frame.table) {
                text << "(" << row.dcomp << " " << row.sx << " " << row.sy << " " << row.sdx << " " << row.sdy
                     << " " << row.dx << " " << row.dy << " " << row.dmultiple << ")";
            }
            text << "]";
        }
    }
    for (const Fault& fault : scenario.faults) {
        text << "; fault " << to_string(fault.kind) << " of renderer " << fault.renderer << " pair "
             << fault.pair << " " << to_string(fault.frame) << " delay " << fault.delay_pairs;
    }
    return text.str();
}

}  // namespace metabuffer::test
