#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "datapath/arbitration/arbitration_policy.h"
#include "datapath/composition.h"
#include "datapath/link/pacing.h"
#include "formats/colour_table.h"
#include "formats/control_scanline.h"
#include "formats/dvi_timing.h"
#include "formats/image_files.h"
#include "formats/image_reading.h"
#include "formats/pixel.h"
#include "formats/smoothing.h"
#include "formats/stored_image.h"
#include "formats/tmds.h"
#include "formats/viewport_splitter.h"
#include "formats/viewport_table.h"
#include "scenario/live_pairs.h"

namespace metabuffer {

enum class StarvationMode : std::uint8_t { kGlitch, kStall };

/// How many sets of data pins an input framebuffer's memory has.
enum class MemoryPorts : std::uint8_t {
    kDual,    ///< two devices: the link writes one while the bus reads the other
    kShared,  ///< one device: the link's writes take clocks from the bus's reads
};

/// What a machine's DVI links are made of.
enum class LinkLayer : std::uint8_t {
    kPixel,  ///< pixels with DE, HSYNC and VSYNC, as receiver and transmitter chips have them
    kTmds,   ///< at level rtl three channels of characters, with an encoder and a decoder at the ends
};

/// Who makes the slot table of a frame.
enum class SlotTableMaker : std::uint8_t {
    kHost,   ///< the host, which sends it with the pair: it is there when the frame begins
    kBuilt,  ///< the arbiter, a slot a clock; the frame's first grant waits for it
};

/// What a scenario makes go wrong, on a renderer's link or inside the machine, to test how the machine reacts.
/// fault_kinds.h says of each kind what it is and which fields go with it.
enum class FaultKind : std::uint8_t {
    kMagic,
    kVersion,
    kKind,
    kCrc,
    kNumber,
    kShortLine,
    kLongLine,
    kShortFrame,
    kLongFrame,
    kMissing,
    kDelay,
    kRepeated,
    kOtherPair,
    kControlByte,
    kPixelBits,
    kDrift,
    kBusreadyLow,
    kPipereadyLow,
    kLostBeat,
    kRandomStalls,
    kReset,
    kTmdsBits,
    kTmdsSlip,
    kTmdsSkew,
    kTmdsNoise,
};

/// Which beats a kLostBeat loses.
enum class LostBeats : std::uint8_t {
    kPixels,  ///< of pixels for the composer
    kTable,   ///< frame starts and table rows, which are for all of a row
    kAny,     ///< whichever comes, pixels for others as well
};

/// Units and ranges of the members of this and the following structures are in the key tables (scenario_keys.h,
/// fault_keys.h).
struct Fault {
    int renderer = 0;  ///< index into Scenario::renderers
    std::uint32_t pair = 0;
    FaultKind kind = FaultKind::kCrc;
    FrameKind frame = FrameKind::kColour;
    int delay_pairs = 0;
    int lines = 1;
    int byte = 0;
    std::uint32_t bits = 0;
    int x = 0;
    int y = 0;
    int ppm = 0;
    int display = 0;  ///< from 1
    std::int64_t from_cycle = 0;
    std::optional<std::int64_t> cycles = std::nullopt;  ///< for ever if empty
    int beats = 1;
    LostBeats of = LostBeats::kPixels;
    int percent = 0;
    std::uint64_t seed = 1;
    TmdsChannel channel = TmdsChannel::kBlue;
    int at_line = 0;  ///< of the frame on the link, blanking included
    int at_clock = 0;
    int late_bits = 0;
    int late_characters = 0;
    int per_billion = 0;
    std::string where = std::string();  ///< "file.yaml:7: faults[1]", empty if it is not from a file

    /// For a fault that has from_cycle and cycles.
    bool lasts_at(std::int64_t core_cycle) const {
        return core_cycle >= from_cycle && (!cycles || core_cycle - from_cycle < *cycles);
    }
};

/// What a display's output framebuffer does to colours after the averaging: a table that the host makes from gains and
/// gamma, or reads from a file (section 2 of the paper).
struct DisplayCorrection {
    int display = 0;                                        ///< from 1
    double gain[ColourTable::kChannels] = {1.0, 1.0, 1.0};  ///< of R, G, B
    double gamma = 1.0;
    /// Instead of gain and gamma: the table and its file, which a table made in memory does not have.
    std::shared_ptr<const ColourTable> lut = nullptr;
    std::filesystem::path lut_file = std::filesystem::path();

    bool has_lut() const { return lut != nullptr || !lut_file.empty(); }
    /// Throws std::logic_error if its file has not been read: a display is corrected by all of its table or not at all.
    ColourTable table() const {
        if (has_lut() && lut == nullptr) throw std::logic_error("a colour table that has not been read");
        return lut != nullptr ? *lut : colour_table(gain, gamma);
    }
};

/// What the frames of neighbouring displays hide of the joint display space.
struct DisplayGap {
    int x_raster_pixels = 0;  ///< between columns of displays
    int y_raster_pixels = 0;  ///< between rows
};

struct DisplayConfig {
    int columns = 1;
    int rows = 1;
    DisplayGap gap{};
    int width_pixels = 0;  ///< of one display
    int height_pixels = 0;
    int supersample = 1;  ///< per axis
    std::uint8_t background[3] = {0, 0, 0};
    std::vector<DisplayCorrection> correction{};  ///< at most one for each display

    int count() const { return columns * rows; }
    /// Pixels of one display.
    std::int64_t pixels() const { return std::int64_t{width_pixels} * height_pixels; }
    int raster_width_pixels() const { return width_pixels * supersample; }
    int raster_height_pixels() const { return height_pixels * supersample; }
    /// The mode of each display.
    DviTiming timing() const { return {width_pixels, height_pixels}; }
    DisplayWall wall() const {
        return {columns,
                rows,
                raster_width_pixels(),
                raster_height_pixels(),
                gap.x_raster_pixels,
                gap.y_raster_pixels};
    }
    /// The displays (from 1, ascending) whose colours are corrected.
    std::vector<int> corrected() const {
        std::vector<int> displays;
        for (const DisplayCorrection& each : correction) displays.push_back(each.display);
        std::sort(displays.begin(), displays.end());
        return displays;
    }
    /// The table of a display (from 1), null if its colours are not corrected.
    std::shared_ptr<const ColourTable> colour_table_of(int display) const {
        for (const DisplayCorrection& each : correction) {
            if (each.display == display) return std::make_shared<const ColourTable>(each.table());
        }
        return nullptr;
    }
};

struct ClockConfig {
    double core_mhz = 100.0;
    double dvi_in_mhz = 100.0;
    double dvi_out_mhz = 100.0;
    /// As the scenario gives them, together with or instead of dvi_in_mhz and dvi_out_mhz.
    std::optional<double> given_dvi_in_refresh_hz = std::nullopt;
    std::optional<double> given_dvi_out_refresh_hz = std::nullopt;

    /// False until images are read, if a refresh rate gives the clock.
    bool dvi_in_is_known() const { return !given_dvi_in_refresh_hz || dvi_in_mhz > 0.0; }
};

/// The pixel clock at which a mode has `refresh_hz` frames a second.
constexpr double mhz_of_refresh(double refresh_hz, const DviTiming& timing) {
    return refresh_hz * static_cast<double>(timing.frame_clocks()) / 1.0e6;
}

/// A clock's period in whole picoseconds, rounded to nearest. All code that turns MHz into time calls it.
constexpr std::int64_t clock_period_picoseconds(double mhz) {
    // NOLINTNEXTLINE(bugprone-incorrect-roundings): positive, and lround is not constexpr
    return static_cast<std::int64_t>(1.0e6 / mhz + 0.5);
}

struct MemoryConfig {
    int page_words = 512;
    int banks = 1;             ///< page p lies in bank p mod banks; each bank has its own open page
    int precharge_cycles = 0;  ///< to close a bank's page
    int page_miss_cycles =
        6;  ///< to close a page and to open another; less precharge_cycles in a closed bank
    int words_per_cycle = 1;
    int read_latency_cycles = 0;      ///< from a read to its words; a read may follow in each clock
    int refresh_interval_cycles = 0;  ///< from one refresh's beginning to the next one's; 0: none
    int refresh_cycles = 0;           ///< of a refresh: every bank is closed, and none can be opened
    MemoryPorts ports = MemoryPorts::kDual;
    int write_block_words = 64;  ///< with shared ports: words of the link that are written together
    /// As the scenario gives it, together with or instead of page_miss_cycles.
    std::optional<int> given_activate_cycles;

    constexpr int activate_cycles() const { return page_miss_cycles - precharge_cycles; }
    /// The memory keeps the times from precharge to activate and from activate to read or write, bank by bank. Without
    /// precharge_cycles a page miss is only a delay, and a page counts as open from its activate on.
    constexpr bool times_banks() const { return precharge_cycles > 0; }
    constexpr bool refreshes() const { return refresh_cycles > 0; }
    constexpr bool shared() const { return ports == MemoryPorts::kShared; }
    /// With shared ports: words of the pages that an image takes. After them the other image's pages begin.
    constexpr std::int64_t device_words(std::int64_t image_words) const {
        return (image_words + page_words - 1) / page_words * page_words;
    }
    /// Words of the memory of one image; with shared ports, of both.
    constexpr std::int64_t memory_words(std::int64_t image_words) const {
        return shared() ? device_words(image_words) + image_words : image_words;
    }
    /// Clocks that `words` words of the link take on the data pins.
    constexpr int write_cycles(int words) const { return (words + words_per_cycle - 1) / words_per_cycle; }
    /// Clocks until a page that is not open can be read.
    constexpr int opening_cycles(bool another_is_open) const {
        return another_is_open ? page_miss_cycles : activate_cycles();
    }
};

struct BusConfig {
    int width_bits = 64;
    int burst_pixels = 32;
    Arbitration arbitration = Arbitration::kIrsa;
    int grant_cycles = 0;  ///< from the requests that an arbiter samples to its answer
    SlotTableMaker slot_table = SlotTableMaker::kHost;
    int register_stages = 0;  ///< registers on the way to the composers, and as many on the way back

    /// Clocks that building a table of `slots` slots takes, from the one in which the frame's rows are known.
    constexpr int build_cycles(std::size_t slots) const {
        return slot_table == SlotTableMaker::kBuilt ? static_cast<int>(slots) : 0;
    }
};

struct LinkConfig {
    LinkLayer layer = LinkLayer::kPixel;

    constexpr bool tmds() const { return layer == LinkLayer::kTmds; }
    /// Clocks of a link from a pixel at the sender's end to that pixel at the receiver's end.
    constexpr int latency_clocks() const { return tmds() ? kTmdsLinkClocks : 0; }
};

struct ComposerConfig {
    int buffer_pixels = 1024;
    int ready_space_pixels = 32;
    StarvationMode on_starvation = StarvationMode::kGlitch;
    Smoothing smoothing = Smoothing::kReplicate;

    /// A column may stand still; nothing ever raises COLUMNSTALL in `glitch` mode.
    bool may_stall() const { return on_starvation == StarvationMode::kStall; }
    /// Source rows in the window.
    int window_rows() const { return row_of(kSmoothingTable, smoothing).window_rows; }
};

/// Pixels that the bus moves in one beat: the lesser of bus and memory, at least one.
constexpr int pixels_per_beat(const BusConfig& bus, const MemoryConfig& memory) {
    const int bus_pixels = bus.width_bits < kPixelBits ? 1 : bus.width_bits / kPixelBits;
    return bus_pixels < memory.words_per_cycle ? bus_pixels : memory.words_per_cycle;
}
/// Bits of the bus that its memory, which gives so many words in a cycle, never fills.
constexpr int idle_bus_bits(int width_bits, int words_per_cycle) {
    return std::max(0, width_bits - kPixelBits * words_per_cycle);
}
/// Core clocks that one beat takes: more than one on a bus narrower than a pixel.
constexpr int cycles_per_beat(const BusConfig& bus) {
    return bus.width_bits < kPixelBits ? kPixelBits / bus.width_bits : 1;
}
/// Core clocks that read latency and registers add to the way of a beat to the composers.
constexpr int bus_delay_cycles(const BusConfig& bus, const MemoryConfig& memory) {
    return memory.read_latency_cycles + bus.register_stages;
}
/// Core clocks that they add to the loop from a beat to its composer's answer, read by the input framebuffer.
constexpr int bus_loop_cycles(const BusConfig& bus, const MemoryConfig& memory) {
    return bus_delay_cycles(bus, memory) + bus.register_stages;
}
/// Core clocks from the fall of BUSREADY that ends a burst to the last beat that may still come of the burst.
constexpr int busready_cut_cycles(const BusConfig& bus, const MemoryConfig& memory) {
    return 1 + bus_loop_cycles(bus, memory);
}
/// Beats that may be on their way when a composer drops BUSREADY: the one it has not seen yet, the one that goes
/// out before the input framebuffer has read the drop, and those that read latency and registers hold.
constexpr int beats_in_flight(const BusConfig& bus, const MemoryConfig& memory) {
    return 2 + bus_loop_cycles(bus, memory) / cycles_per_beat(bus);
}
/// Pixels of those beats, and so the least legal ready space.
constexpr int in_flight_pixels(const BusConfig& bus, const MemoryConfig& memory) {
    return beats_in_flight(bus, memory) * pixels_per_beat(bus, memory);
}
/// The ready space if none is given: one burst, at least in_flight_pixels().
constexpr int default_ready_space_pixels(const BusConfig& bus, const MemoryConfig& memory) {
    return std::max(bus.burst_pixels, in_flight_pixels(bus, memory));
}

/// One entry of a renderer's list: the image, and the table its control scanline carries.
struct RendererFrame {
    std::size_t image = 0;  ///< index into Renderer::images
    ViewportTable table;    ///< from the viewport (split by the host side) or as the scenario gives it
    std::optional<Viewport> viewport;
    int table_line = 0;  ///< line of the scenario file, 0 if there is none
    /// The slot table that the host sends, by display; computed unless it is given.
    std::optional<std::vector<int>> slots{};
    /// The control scanlines as an application has written them, if they are not those that a host makes of the rest.
    std::optional<SentControls> controls{};
};

inline bool has_same_tables(const RendererFrame& a, const RendererFrame& b) {
    return a.table == b.table && a.slots == b.slots &&
           (a.controls ? a.controls->payload : std::vector<std::uint8_t>()) ==
               (b.controls ? b.controls->payload : std::vector<std::uint8_t>());
}

struct Renderer {
    std::string name;
    int image_width_pixels = 0;
    int image_height_pixels = 0;
    /// Each different image once. Renderers that name the same files share them.
    std::vector<std::shared_ptr<const StoredImage>> images;
    std::vector<RendererFrame> frames;  ///< at least one; the last repeats
    /// Its pairs come from an application (Scenario::live_pairs): the frames so far, and before the first pair an empty
    /// one.
    bool is_live = false;

    const RendererFrame& frame_of_pair(std::uint32_t pair) const {
        return frames[std::min<std::size_t>(pair, frames.size() - 1)];
    }
    /// The frame number that the link's pair carries; none if its control scanlines are no pair's.
    std::optional<std::uint32_t> number_of_pair(std::uint32_t pair) const {
        const std::optional<SentControls>& controls = frame_of_pair(pair).controls;
        return controls ? controls->number : pair;
    }
    /// The newest pair that carries the number.
    std::uint32_t pair_of_number(std::uint32_t number) const {
        if (!frame_of_pair(number).controls) return number;
        const auto has_number = [number](const RendererFrame& frame) {
            return frame.controls && frame.controls->number == number;
        };
        const auto found = std::find_if(frames.rbegin(), frames.rend(), has_number);
        return found == frames.rend() ? number : static_cast<std::uint32_t>(frames.rend() - found - 1);
    }
    /// Throws what StoredImage::pixels() throws.
    const PixelImage& image_of_pair(std::uint32_t pair) const {
        return images[frame_of_pair(pair).image]->pixels();
    }
    /// One word for each pixel.
    std::int64_t image_words() const { return std::int64_t{image_width_pixels} * image_height_pixels; }
    DviTiming timing() const { return renderer_dvi_timing(image_width_pixels, image_height_pixels); }
};

/// A scenario with every default filled in, every key checked and the size of every image known.
/// Levels are built from it.
struct Scenario {
    std::string name;
    DisplayConfig displays;
    Composition composition = Composition::kZ;
    DepthFormat depth_format = DepthFormat::kA8Z16;
    ImageReading image_reading{0.0, 100.0};
    ClockConfig clocks;
    MemoryConfig memory;
    BusConfig bus;
    ComposerConfig composer;
    LinkConfig links;
    Pacing pacing = Pacing::kLockstep;
    int link_timeout_pairs = 2;
    std::int64_t watchdog_cycles = 0;  ///< 0: the machine derives a safe value from the scenario
    int frames = 1;                    ///< composited frames to show
    std::vector<Renderer> renderers;   ///< at least one
    std::vector<Fault> faults;
    /// The files of the images that were read from files.
    std::map<const StoredImage*, ImageFiles> image_files;
    std::shared_ptr<LivePairs> live_pairs;  ///< of live renderers, once applications may come

    Pixel background_pixel() const {
        return {displays.background[0], displays.background[1], displays.background[2], 0,
                far_z(depth_format)};
    }
    /// The table that the host makes for an image of the renderer at that viewport. Throws what split_viewport throws.
    ViewportTable table_for(const Viewport& viewport, const Renderer& renderer) const {
        return split_viewport(viewport, renderer.image_width_pixels, renderer.image_height_pixels,
                              displays.wall(), composer.smoothing);
    }
    ViewportLimits limits(const Renderer& renderer) const {
        return {displays.count(),
                renderer.image_width_pixels,
                renderer.image_height_pixels,
                displays.raster_width_pixels(),
                displays.raster_height_pixels(),
                composer.buffer_pixels,
                composer.ready_space_pixels,
                composer.smoothing};
    }
};

}  // namespace metabuffer
