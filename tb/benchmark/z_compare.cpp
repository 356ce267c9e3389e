// How much of the machine's memory bandwidth the functional level uses for a Z compare of two frames. The yardstick is
// a bare loop over two frames of 1280x1024 pixels, colour and depth apart: it does nothing but read both frames and
// write the nearer pixels over one of them. It is compared with the functional compositor, which makes the picture of a
// display that two renderers cover wholly, one to one. There every pixel of the two frames goes through the same
// compare, and before that the pixels of one of them through the compare with the background.
//
// Both are counted alike: 1280x1024 pairs of pixels for each pass over both frames. The machine may be shared, so both
// take turns in one run, and the median counts. The ratio is the median of the ratios within a turn.
//
// usage: z_compare [TURNS]; prints one JSON object. It is what scripts/benchmark shows.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "formats/image.h"
#include "formats/pixel_planes.h"
#include "functional/functional_compositor.h"
#include "functional/vector_loop.h"
#include "scenario/scenario.h"

namespace metabuffer {
namespace {

constexpr int kWidth = 1280;
constexpr int kHeight = 1024;
constexpr std::size_t kPixels = static_cast<std::size_t>(kWidth) * kHeight;

/// The yardstick. The mask makes it store every pixel. A comparison may be compiled to stores that are left out where
/// the local pixel loses; when the same frames are compared again, it always loses.
struct KeepNearer {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict local_argb,
                                              const std::uint32_t* __restrict local_z,
                                              std::uint32_t* __restrict argb, std::uint32_t* __restrict z,
                                              std::size_t count) const {
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t near_argb = local_argb[i];
            const std::uint32_t near_z = local_z[i];
            const std::uint32_t far_argb = argb[i];
            const std::uint32_t far_z = z[i];
            const bool is_nearer = static_cast<std::int32_t>(near_z) < static_cast<std::int32_t>(far_z);
            const std::uint32_t mask = 0U - static_cast<std::uint32_t>(is_nearer);
            argb[i] = (near_argb & mask) | (far_argb & ~mask);
            z[i] = (near_z & mask) | (far_z & ~mask);
        }
    }
};

/// Writes the nearer pixel of each position over the frame.
void keep_nearer(const PixelPlanes& other, PixelPlanes& frame) {
    functional::run_loop(KeepNearer{}, other.argb.data(), other.z.data(), frame.argb.data(), frame.z.data(),
                         kPixels);
}

/// Pixels of any colour and depth, so that no order in them helps: each of two such frames wins half of the
/// compares. None is as far as the background.
PixelImage noise(std::uint64_t seed) {
    PixelImage image(kWidth, kHeight);
    std::uint64_t state = seed;
    for (Pixel& pixel : image.values) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        const auto z = static_cast<std::uint32_t>(state >> 40) & 0x7FFFU;
        pixel = Pixel(static_cast<std::uint8_t>(state >> 32), static_cast<std::uint8_t>(state >> 24),
                      static_cast<std::uint8_t>(state >> 16), 255, z);
    }
    return image;
}

PixelPlanes planes_of(const PixelImage& image) {
    PixelPlanes planes(image.width_pixels, image.height_pixels);
    for (std::size_t i = 0; i < image.values.size(); ++i) {
        planes.argb[i] = static_cast<std::uint32_t>(image.values[i].word());
        planes.z[i] = image.values[i].z();
    }
    return planes;
}

Scenario one_display() {
    Scenario scenario;
    scenario.displays.width_pixels = kWidth;
    scenario.displays.height_pixels = kHeight;
    return scenario;
}

ViewportTable whole_display() {
    ViewportRow row;
    row.dcomp = 1;
    row.sdx = kWidth;
    row.sdy = kHeight;
    row.dmultiple = 1;
    return {row};
}

template <typename Work>
double seconds_of(Work work) {
    const auto started = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - started;
    return taken.count();
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double gigapixels_per_second(const std::vector<double>& seconds) {
    return static_cast<double>(kPixels) / median(seconds) / 1e9;
}

/// Whether the picture shows the frame that the bare loop has made.
bool shows(const ColourImage& picture, const PixelPlanes& frame) {
    return std::equal(
        picture.values.begin(), picture.values.end(), frame.argb.begin(), frame.argb.end(),
        [](std::uint32_t colour, std::uint32_t argb) { return colour == (argb & kColourMask); });
}

int turns_of(int argc, char** argv) {
    if (argc < 2) return 101;
    char* end = nullptr;
    const long turns = std::strtol(argv[1], &end, 10);
    if (*end != '\0' || turns < 1 || turns > 100'000) {
        throw std::runtime_error(std::string(argv[1]) + ": use a whole number of turns from 1 to 100000");
    }
    return static_cast<int>(turns);
}

int main_program(int argc, char** argv) {
    const int turns = turns_of(argc, argv);
    const PixelImage first = noise(1);
    const PixelImage second = noise(2);
    PixelPlanes frame = planes_of(first);
    const PixelPlanes other = planes_of(second);

    const Scenario scenario = one_display();
    const std::vector<functional::Contribution> contributions = {{&first, whole_display()},
                                                                 {&second, whole_display()}};
    functional::Compositor compositor(scenario);
    compositor.begin_frame(contributions);

    // Each runs once before it is measured: then all memory is allocated, and the compositor has its planes.
    keep_nearer(other, frame);
    if (!shows(compositor.picture(1), frame)) {
        std::fputs("z_compare: the functional compositor and the bare loop differ\n", stderr);
        return 1;
    }

    const auto turn_count = static_cast<std::size_t>(turns);
    std::vector<double> bare(turn_count);
    std::vector<double> composited(turn_count);
    std::vector<double> converted(turn_count);
    std::vector<double> ratios(turn_count);
    for (std::size_t turn = 0; turn < turn_count; ++turn) {
        bare[turn] = seconds_of([&] { keep_nearer(other, frame); });
        composited[turn] = seconds_of([&] { compositor.picture(1); });
        ratios[turn] = bare[turn] / composited[turn];
    }
    // Measured after the others and not in turn with them: it asks for so much memory that theirs would then lie
    // elsewhere.
    for (double& seconds : converted) {
        seconds = seconds_of([&] { functional::composite_display(scenario, contributions, 1); });
    }
    std::printf("{\"width_pixels\": %d, \"height_pixels\": %d, \"turns\": %d, \"ratio\": %.3f,\n", kWidth,
                kHeight, turns, median(ratios));
    std::printf(" \"bare_loop_gigapixels_per_second\": %.3f,\n", gigapixels_per_second(bare));
    std::printf(" \"functional_gigapixels_per_second\": %.3f,\n", gigapixels_per_second(composited));
    std::printf(" \"functional_with_conversion_gigapixels_per_second\": %.3f}\n",
                gigapixels_per_second(converted));
    return 0;
}

}  // namespace
}  // namespace metabuffer

int main(int argc, char** argv) {
    try {
        return metabuffer::main_program(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "z_compare: %s\n", error.what());
        return 2;
    }
}
