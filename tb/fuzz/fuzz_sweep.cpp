// libFuzzer: whatever a sweep file holds, reader and planner return a plan or say on one line what is wrong with it.
// scripts/test fuzz runs it.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "exploration/sweep_plan.h"

namespace {

using namespace metabuffer::exploration;

/// A folder with the scenarios that the seeds name. A plan reads no images.
std::filesystem::path scenario_folder() {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "fuzz_sweep";
    std::filesystem::create_directories(folder);
    const std::string rest =
        "displays: {width: 16, height: 8}\n"
        "renderers: [{frames: [{image: a.ppm, viewport: {x: 0, y: 0}}]}]\n";
    std::ofstream(folder / "case.yaml") << rest;
    std::ofstream(folder / "wide.yaml") << "bus: {width_bits: 128}\n" << rest;
    return folder;
}

/// Large plans are the same again and take long.
bool is_small(const SweepDescription& sweep) {
    constexpr std::size_t kMostPlanned = 200;
    std::size_t points = 1;
    for (const Axis& axis : sweep.axes) {
        points *= axis.values.front().size();
        if (points > kMostPlanned) return false;
    }
    return true;
}

void check(const SweepPlan& plan) {
    for (const Point& point : plan.points) {
        bool good = point.settings.size() == plan.keys.size();
        for (std::size_t i = 0; good && i < plan.keys.size(); ++i) {
            good = point.settings[i].key == plan.keys[i] &&
                   point.settings[i].value.find('\n') == std::string::npos;
        }
        if (good) continue;
        std::fprintf(stderr, "a point without its keys: %s\n", canonical_text(point.settings).c_str());
        std::abort();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path folder = scenario_folder();
    const std::string text(reinterpret_cast<const char*>(data), size);
    // A path that leaves the folder could name a device that never ends.
    if (text.find('/') != std::string::npos) return 0;
    try {
        const SweepDescription sweep = parse_sweep(text, "fuzz.yaml", folder);
        if (is_small(sweep)) check(make_plan(sweep));
    } catch (const metabuffer::InputError& error) {
        const std::string message = error.what();
        if (message.empty() || message.find('\n') != std::string::npos) {
            std::fprintf(stderr, "not one line: '%s'\n", message.c_str());
            std::abort();
        }
    }
    return 0;
}
