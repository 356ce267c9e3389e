#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datapath/arbitration/arbitration_policy.h"
#include "datapath/composition.h"
#include "datapath/link/pacing.h"
#include "formats/control_scanline.h"
#include "formats/dvi_timing.h"
#include "formats/image.h"
#include "formats/pixel.h"
#include "formats/viewport_splitter.h"
#include "formats/viewport_table.h"

namespace metabuffer {

enum class StarvationMode : std::uint8_t { kGlitch, kStall };

/// What can be told to go wrong, on a renderer's link or inside the machine, to see the machine cope. fault_keys.h
/// tells which fields go with which kind.
enum class FaultKind : std::uint8_t {
    kMagic,        ///< the control scanline's magic is not MBUF
    kVersion,      ///< its version is not 1
    kKind,         ///< its kind is neither 0 nor 1 (and its CRC holds)
    kCrc,          ///< its CRC-32 does not match
    kNumber,       ///< its frame number is one more than the pair's (and its CRC holds)
    kShortLine,    ///< the last image scanline is a pixel short
    kLongLine,     ///< the last image scanline is a pixel long
    kShortFrame,   ///< the last `lines` image scanlines are missing
    kLongFrame,    ///< there are `lines` image scanlines too many
    kMissing,      ///< the frame is not sent
    kDelay,        ///< the link is silent for delay_pairs pair times before the frame
    kRepeated,     ///< the frame is sent twice
    kOtherPair,    ///< the frame is that of the next pair: number, table and image
    kControlByte,  ///< one byte of the control scanline is changed by `bits`
    kPixelBits,    ///< `bits` of the image pixel at (x, y) are flipped on the link
    kDrift,        ///< from the pair on, the link's clock runs `ppm` millionths fast; level rtl only
    // Inside the machine, at level rtl only, from core clock from_cycle on:
    kBusreadyLow,   ///< BUSREADY of a composer is low for `cycles`
    kPipereadyLow,  ///< PIPEREADY of a composer is low for `cycles`
    kLostBeat,      ///< the bus loses its next `beats` beats of kind `of` on their way to one composer
    kRandomStalls,  ///< each handshake of the renderer's row is held back in `percent` of the clocks, for `cycles`
};

/// Which beats a kLostBeat loses.
enum class LostBeats : std::uint8_t {
    kPixels,  ///< of pixels for the composer
    kTable,   ///< frame starts and table rows, which are for all of a row
    kAny,     ///< whichever comes, pixels for others as well
};

struct Fault {
    int renderer = 0;        ///< index into Scenario::renderers
    std::uint32_t pair = 0;  ///< the pair's number, from 0
    FaultKind kind = FaultKind::kCrc;
    FrameKind frame = FrameKind::kColour;  ///< which frame of the pair
    int delay_pairs = 0;                   ///< kDelay only: pair times, >= 1
    int lines = 1;                         ///< kShortFrame, kLongFrame: missing or added, 1..image lines
    int byte = 0;                          ///< kControlByte: of the control scanline, from 0
    std::uint32_t bits = 0;                ///< kControlByte: 1..255; kPixelBits: 1..0xFFFFFF
    int x = 0;                             ///< kPixelBits: within the image
    int y = 0;
    int ppm = 0;                                        ///< kDrift: -100000..100000
    int display = 0;                                    ///< kBusreadyLow, kPipereadyLow, kLostBeat: from 1
    std::int64_t from_cycle = 0;                        ///< faults inside the machine: core clock
    std::optional<std::int64_t> cycles = std::nullopt;  ///< how long, >= 1; for ever if empty
    int beats = 1;                                      ///< kLostBeat: >= 1
    LostBeats of = LostBeats::kPixels;                  ///< kLostBeat
    int percent = 0;                                    ///< kRandomStalls: 1..99
    std::uint64_t seed = 1;                             ///< kRandomStalls
    std::string where = std::string();  ///< "file.yaml:7: faults[1]", empty if it is not from a file
};

struct DisplayConfig {
    int columns = 1;       ///< 1..64
    int rows = 1;          ///< 1..64
    int width_pixels = 0;  ///< of one display, 1..4096
    int height_pixels = 0;
    int supersample = 1;  ///< 1, 2 or 4 per axis
    std::uint8_t background[3] = {0, 0, 0};

    int count() const { return columns * rows; }
    int raster_width_pixels() const { return width_pixels * supersample; }
    int raster_height_pixels() const { return height_pixels * supersample; }
    DisplayWall wall() const { return {columns, rows, raster_width_pixels(), raster_height_pixels()}; }
};

struct ClockConfig {
    double core_mhz = 100.0;  ///< 0.001..10000, as the others
    double dvi_in_mhz = 100.0;
    double dvi_out_mhz = 100.0;
};

/// A clock's period in whole picoseconds, rounded to nearest: the one place where MHz become time.
constexpr std::int64_t clock_period_picoseconds(double mhz) {
    // NOLINTNEXTLINE(bugprone-incorrect-roundings): positive, and lround is not constexpr
    return static_cast<std::int64_t>(1.0e6 / mhz + 0.5);
}

struct MemoryConfig {
    int page_words = 512;      ///< >= 1
    int page_miss_cycles = 6;  ///< >= 0
    int words_per_cycle = 1;   ///< 1..8
};

struct BusConfig {
    int width_bits = 64;    ///< 16, 32, 64, 128, 256 or 512
    int burst_pixels = 32;  ///< 1..65535
    Arbitration arbitration = Arbitration::kIrsa;
};

struct ComposerConfig {
    int buffer_pixels = 1024;     ///< 1..2^24
    int ready_space_pixels = 32;  ///< default: one burst, but at least what can be in flight
    StarvationMode on_starvation = StarvationMode::kGlitch;
};

/// Pixels that the bus moves in one beat: the lesser of bus and memory, at least one.
constexpr int pixels_per_beat(const BusConfig& bus, const MemoryConfig& memory) {
    const int bus_pixels = bus.width_bits < kPixelBits ? 1 : bus.width_bits / kPixelBits;
    return bus_pixels < memory.words_per_cycle ? bus_pixels : memory.words_per_cycle;
}
/// Core clocks that one beat takes: more than one on a bus narrower than a pixel.
constexpr int cycles_per_beat(const BusConfig& bus) {
    return bus.width_bits < kPixelBits ? kPixelBits / bus.width_bits : 1;
}
/// Beats that may be on their way when a composer drops BUSREADY: the one it has not seen yet and the one
/// that goes out before the input framebuffer has read the drop.
constexpr int kBeatsInFlight = 2;
/// The least legal ready space.
constexpr int in_flight_pixels(const BusConfig& bus, const MemoryConfig& memory) {
    return kBeatsInFlight * pixels_per_beat(bus, memory);
}

/// One entry of a renderer's list: the image, and the table its control scanline carries.
struct RendererFrame {
    std::size_t image = 0;  ///< index into Renderer::images
    ViewportTable table;    ///< from the viewport (split by the host side) or as the scenario gives it
    std::optional<Viewport> viewport;
    int table_line = 0;  ///< line of the scenario file, 0 if there is none
};

struct Renderer {
    std::string name;
    int image_width_pixels = 0;
    int image_height_pixels = 0;
    /// Each different image once, converted to pixels. Renderers that name the same files share them.
    std::vector<std::shared_ptr<const PixelImage>> images;
    std::vector<RendererFrame> frames;  ///< at least one; the last repeats

    const RendererFrame& frame_of_pair(std::uint32_t pair) const {
        return frames[std::min<std::size_t>(pair, frames.size() - 1)];
    }
    const PixelImage& image_of_pair(std::uint32_t pair) const { return *images[frame_of_pair(pair).image]; }
    DviTiming timing() const { return renderer_dvi_timing(image_width_pixels, image_height_pixels); }
};

/// A scenario with every default filled in, every key checked and every image read. Levels are built from it.
struct Scenario {
    std::string name;
    DisplayConfig displays;
    Composition composition = Composition::kZ;
    DepthFormat depth_format = DepthFormat::kA8Z16;
    double depth_near = 0.0;
    double depth_far = 100.0;
    ClockConfig clocks;
    MemoryConfig memory;
    BusConfig bus;
    ComposerConfig composer;
    Pacing pacing = Pacing::kLockstep;
    int link_timeout_pairs = 2;        ///< >= 1
    std::int64_t watchdog_cycles = 0;  ///< 0: the machine derives a safe value from the scenario
    int frames = 1;                    ///< composited frames to show
    std::vector<Renderer> renderers;   ///< at least one
    std::vector<Fault> faults;

    Pixel background_pixel() const {
        return {displays.background[0], displays.background[1], displays.background[2], 0,
                far_z(depth_format)};
    }
    ViewportLimits limits(const Renderer& renderer) const {
        return {displays.count(),
                renderer.image_width_pixels,
                renderer.image_height_pixels,
                displays.raster_width_pixels(),
                displays.raster_height_pixels(),
                composer.buffer_pixels,
                composer.ready_space_pixels};
    }
};

}  // namespace metabuffer
