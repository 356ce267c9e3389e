#include "report/machine_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "datapath/slot_table.h"
#include "formats/bus_side_band.h"
#include "report/synthesis_table.h"

namespace metabuffer {
namespace {

constexpr int kPictureBits = 24;
constexpr int kBanks = 2;  ///< of an output framebuffer, and images of an input framebuffer
/// Besides a pixel: valid, lost, STARTFRAME, PIPEREADY, STALL and COLUMNSTALL.
constexpr int kPipelineSideBits = 6;
/// Besides a device's words and addresses: a byte mask and the command.
constexpr int kMemoryMaskBits = 8;
constexpr int kMemoryCommandBits = 3;
/// Behind a DVI receiver: DE, HSYNC, VSYNC and the clock, besides the data.
constexpr int kDviSidePins = 4;
constexpr int kBlockRamBits = 32 * 1024;  ///< of 36 Kbit without parity
constexpr int kFifoBanks = 8;             ///< of the composer in SystemVerilog: each a block RAM or more
constexpr int kSmallestMemoryPixels = 64;

std::int64_t bits_of(std::int64_t values) {
    std::int64_t bits = 1;
    while ((std::int64_t{1} << bits) < values) ++bits;
    return bits;
}

template <std::size_t Terms>
double value_of(const synthesis::Fit<Terms>& fit, const std::array<double, Terms>& terms) {
    double sum = 0.0;
    for (std::size_t n = 0; n < Terms; ++n) sum += fit.coefficients[n] * terms[n];
    return sum;
}

/// A composer's memory is a power of two.
std::int64_t memory_pixels(const Scenario& scenario) {
    return std::max<std::int64_t>(kSmallestMemoryPixels,
                                  std::int64_t{1} << bits_of(scenario.composer.buffer_pixels));
}

double doublings(double value, double first) { return std::max(0.0, std::log2(value / first)); }

struct BlockCells {
    std::int64_t lookup_tables = 0;
    std::int64_t registers = 0;
    std::int64_t block_rams = 0;
    std::int64_t multipliers = 0;
};

/// Source rows in a composer's window. The FIFO has a read port for each, and a copy of its memory behind it.
int composer_rows(const Scenario& scenario) { return scenario.composer.window_rows(); }

/// The fits are in the order of the rows, from one row on.
template <typename Fits>
const auto& fit_of(const Fits& fits, const Scenario& scenario) {
    return fits.at(static_cast<std::size_t>(composer_rows(scenario)) - 1);
}

BlockCells composer_cells(const Scenario& scenario) {
    const std::int64_t pixels = memory_pixels(scenario);
    const int rows = composer_rows(scenario);
    const bool several = scenario.bus.width_bits > kPixelBits;
    const bool has_block_rams = pixels >= synthesis::kFirstBlockRamPixels;
    const std::array<double, 5> terms{1.0, doublings(static_cast<double>(pixels), kSmallestMemoryPixels),
                                      doublings(scenario.bus.width_bits, kPixelBits),
                                      has_block_rams ? 0.0 : 1.0, several ? 1.0 : 0.0};
    BlockCells cells;
    cells.lookup_tables = std::llround(value_of(fit_of(synthesis::kComposerLookupTables, scenario), terms));
    cells.registers = std::llround(value_of(fit_of(synthesis::kComposerRegisters, scenario), terms));
    if (has_block_rams) {
        cells.block_rams = rows * std::max<std::int64_t>(kFifoBanks, pixels * kPixelBits / kBlockRamBits);
    }
    const auto row =
        std::find_if(synthesis::kComposers.begin(), synthesis::kComposers.end(),
                     [several, rows](const synthesis::ComposerRow& each) {
                         return (each.bus_bits > kPixelBits) == several && each.window_rows == rows;
                     });
    cells.multipliers = row->multipliers;
    return cells;
}

int arbiter_lines(const Scenario& scenario) { return std::max(2, scenario.displays.count()); }

BlockCells arbiter_cells(const Scenario& scenario) {
    const double lines = arbiter_lines(scenario);
    const double slot_bits = most_slots(arbiter_lines(scenario)) * std::ceil(std::log2(lines));
    BlockCells cells;
    cells.lookup_tables = std::llround(value_of(synthesis::kArbiterLookupTables, {1.0, lines, slot_bits}));
    cells.registers = std::llround(value_of(synthesis::kArbiterRegisters, {1.0, lines, slot_bits}));
    return cells;
}

double mhz_of_period(double nanoseconds) { return 1000.0 / nanoseconds; }

/// Devices of an input framebuffer.
std::int64_t devices_each(const MemoryConfig& memory) {
    return std::int64_t{memory.shared() ? 1 : kBanks} * memory.words_per_cycle;
}

std::int64_t input_framebuffer_bits(const Scenario& scenario, const Renderer& renderer) {
    const std::int64_t buffered = scenario.memory.shared() ? scenario.memory.write_block_words : 0;
    return kBanks * (renderer.image_words() + buffered) * kPixelBits;
}

std::int64_t memory_pins(const MemoryConfig& memory, const Renderer& renderer) {
    const std::int64_t words =
        memory.shared() ? memory.memory_words(renderer.image_words()) : renderer.image_words();
    const std::int64_t device_words = (words + memory.words_per_cycle - 1) / memory.words_per_cycle;
    return devices_each(memory) * (kPixelBits + kMemoryMaskBits + kMemoryCommandBits + bits_of(device_words));
}

}  // namespace

MachineCost machine_cost(const Scenario& scenario) {
    constexpr std::int64_t kWordBytes = kPixelBits / 8;
    const auto renderers = static_cast<std::int64_t>(scenario.renderers.size());
    const std::int64_t displays = scenario.displays.count();
    const std::int64_t composers = renderers * displays;
    MachineCost cost;
    cost.buffer_bits = composers * composer_rows(scenario) * scenario.composer.buffer_pixels * kPixelBits;
    cost.output_framebuffer_bits =
        displays * kBanks * scenario.displays.width_pixels * scenario.displays.height_pixels * kPictureBits;
    cost.correction_bits =
        static_cast<std::int64_t>(scenario.displays.correction.size()) * ColourTable::kBits;
    for (const Renderer& renderer : scenario.renderers) {
        cost.input_framebuffer_bits += input_framebuffer_bits(scenario, renderer);
        cost.memory_pins += memory_pins(scenario.memory, renderer);
    }
    cost.bus_wires = renderers * (scenario.bus.width_bits + BusSideBand::kAllBits +
                                  BusSideBand::kHandshakesPerComposer * displays);
    cost.pipeline_wires = composers * (kPixelBits + kPipelineSideBits);
    cost.dvi_pins = (renderers + displays) * (kPictureBits + kDviSidePins);
    cost.memory_devices = renderers * devices_each(scenario.memory);
    cost.memory_megabytes_per_second =
        static_cast<double>(cost.memory_devices * kWordBytes) * scenario.clocks.core_mhz;
    const BlockCells composer = composer_cells(scenario);
    const BlockCells arbiter = arbiter_cells(scenario);
    cost.lookup_tables = composers * composer.lookup_tables + renderers * arbiter.lookup_tables;
    cost.registers = composers * composer.registers + renderers * arbiter.registers;
    cost.block_rams = composers * composer.block_rams;
    cost.multipliers = composers * composer.multipliers;
    cost.composer_mhz = mhz_of_period(
        value_of(fit_of(synthesis::kComposerPeriod, scenario),
                 {1.0, doublings(static_cast<double>(memory_pixels(scenario)), kSmallestMemoryPixels),
                  doublings(scenario.bus.width_bits, kPixelBits)}));
    cost.arbiter_mhz = mhz_of_period(
        value_of(synthesis::kArbiterPeriod, {1.0, static_cast<double>(arbiter_lines(scenario))}));
    return cost;
}

double MachineCost::weighted() const {
    double sum = 0.0;
    for (const CostItem& item : cost_items()) sum += item.weight * item.value(*this);
    return sum;
}

namespace {

template <auto Member>
CostItem item(const char* name, const char* unit, const char* meaning, double weight) {
    using Type = std::decay_t<decltype(std::declval<MachineCost>().*Member)>;
    return {name,    unit,
            meaning, [](const MachineCost& cost) { return static_cast<double>(cost.*Member); },
            weight,  std::is_integral_v<Type>};
}

}  // namespace

const std::vector<CostItem>& cost_items() {
    // The meanings say these numbers.
    static_assert(BusSideBand::kAllBits == 103 && BusSideBand::kHandshakesPerComposer == 2);
    static_assert(kPixelBits == 64 && kPixelBits + kPipelineSideBits == 70);
    static_assert(kMemoryMaskBits == 8 && kMemoryCommandBits == 3 && kPictureBits == 24);
    static_assert(kPictureBits + kDviSidePins == 28);
    static_assert(ColourTable::kBits == std::int64_t{3} * 256 * 8);
    static const std::vector<CostItem> items{
        item<&MachineCost::buffer_bits>(
            "buffer_bits", "bits",
            "composers times composer.buffer_pixels times 64; twice that where they "
            "smooth, since the FIFO's second read port has a copy of the memory",
            0.001),
        item<&MachineCost::input_framebuffer_bits>("input_framebuffer_bits", "bits",
                                                   "two images of 64-bit pixels for each renderer", 0.00005),
        item<&MachineCost::output_framebuffer_bits>(
            "output_framebuffer_bits", "bits", "two pictures of 24-bit pixels for each display", 0.00005),
        item<&MachineCost::correction_bits>(
            "correction_bits", "bits",
            "three tables of 256 values of 8 bits for each display that displays.correction names", 0.001),
        item<&MachineCost::bus_wires>(
            "bus_wires", "wires",
            "renderers times bus.width_bits, 103 wires besides the data and two handshakes a display", 1.0),
        item<&MachineCost::pipeline_wires>("pipeline_wires", "wires",
                                           "70 for each composer: a pixel and six besides it", 1.0),
        item<&MachineCost::memory_pins>(
            "memory_pins", "pins",
            "for each memory device 64 of data, a byte mask of 8, a command of 3, and the address", 1.0),
        item<&MachineCost::dvi_pins>("dvi_pins", "pins", "28 for each renderer's link and each display", 1.0),
        item<&MachineCost::memory_devices>(
            "memory_devices", "",
            "64 bits wide: memory.words_per_cycle for each renderer, twice as many with dual ports", 50.0),
        item<&MachineCost::memory_megabytes_per_second>(
            "memory_megabytes_per_second", "MB/s", "what all memory devices move at most at core_mhz", 0.0),
        item<&MachineCost::lookup_tables>("lookup_tables", "",
                                          "of all composers and arbiters on an FPGA, by synthesis", 0.01),
        item<&MachineCost::registers>("registers", "bits", "the same", 0.01),
        item<&MachineCost::block_rams>("block_rams", "", "of 36 Kbit, of all composers", 0.0),
        item<&MachineCost::multipliers>("multipliers", "", "of all composers", 1.0),
        item<&MachineCost::composer_mhz>(
            "composer_mhz", "MHz",
            "clock that the composer in SystemVerilog reaches in cells of 0.18 um, "
            "without wires",
            0.0),
        item<&MachineCost::arbiter_mhz>("arbiter_mhz", "MHz", "the same of the arbiter", 0.0),
    };
    return items;
}

}  // namespace metabuffer
