// libFuzzer: whatever a scenario file holds, the reader returns a scenario or says on one line what is wrong
// with it. scripts/test fuzz runs it.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "scenario/scenario_loader.h"

namespace {

/// A folder for the scenarios' images, with tiny ones in it, so that what comes after the images is reached,
/// and quickly.
std::filesystem::path image_folder() {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "fuzz_scenario";
    std::filesystem::create_directories(folder);
    constexpr int kPixels = 20 * 3;
    std::ofstream colour(folder / "a.ppm");
    std::ofstream depth(folder / "z.pgm");
    colour << "P3 20 3 255\n";
    depth << "P2 20 3 255\n";
    for (int i = 0; i < kPixels; ++i) {
        colour << i << ' ' << 2 * i << ' ' << 3 * i << '\n';
        depth << 4 * i << '\n';
    }
    return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path folder = image_folder();
    const std::string text(reinterpret_cast<const char*>(data), size);
    // A path that leaves the folder could name a device that never ends.
    if (text.find('/') != std::string::npos) return 0;
    try {
        metabuffer::parse_scenario(text, "fuzz.yaml", folder);
    } catch (const metabuffer::InputError& error) {
        const std::string message = error.what();
        if (message.empty() || message.find('\n') != std::string::npos) {
            std::fprintf(stderr, "not one line: '%s'\n", message.c_str());
            std::abort();
        }
    }
    return 0;
}
