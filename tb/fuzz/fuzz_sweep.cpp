// libFuzzer: whatever a sweep file holds, reader and planner return a plan or say on one line what is wrong with it.
// scripts/fuzz runs it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "expectations.h"
#include "support/scratch_directory.h"
#include "tools/exploration/sweep_plan.h"

namespace {

using namespace metabuffer::exploration;

/// A folder with the scenarios that the seeds name. A plan reads no images.
class ScenarioFolder {
  public:
    ScenarioFolder() {
        const std::string rest =
            "displays: {width: 16, height: 8}\n"
            "renderers: [{frames: [{image: a.ppm, z: 0, viewport: {x: 0, y: 0}}]}]\n";
        scratch_.write("case.yaml", rest);
        scratch_.write("wide.yaml", "bus: {width_bits: 128}\n" + rest);
    }
    const std::filesystem::path& path() const { return scratch_.path(); }

  private:
    metabuffer::test::ScratchDirectory scratch_;
};

/// Large plans take long and show nothing new.
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
        if (!good) metabuffer::fuzz::fail("a point without its keys: " + canonical_text(point.settings));
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const ScenarioFolder folder;
    const std::string text(reinterpret_cast<const char*>(data), size);
    // A path that leaves the folder could name a device that never ends.
    if (text.find('/') != std::string::npos) return 0;
    try {
        const SweepDescription sweep = parse_sweep(text, "fuzz.yaml", folder.path());
        if (is_small(sweep)) check(make_plan(sweep));
    } catch (const metabuffer::InputError& error) {
        metabuffer::fuzz::expect_one_clear_line(error);
    }
    return 0;
}
