#include "naive_pipeline.h"

#include <array>
#include <utility>
#include <vector>

#include "formats/image_difference.h"
#include "functional/functional_compositor.h"
#include "monitors/picture_reference.h"
#include "support/colour_tables.h"

namespace metabuffer::test {

ColourImage picture_without_glitches(const MachineRun& run, int frame, int display) {
    const Scenario& scenario = run.scenario();
    const auto contributions =
        functional::contributions_of(scenario, run.report().frames.at(static_cast<std::size_t>(frame)).pairs);
    const int s = scenario.displays.supersample;
    const int shift = s == 1 ? 0 : (s == 2 ? 2 : 4);
    const monitors::PictureReference reference(scenario);
    std::vector<int> missing;
    const auto bottom_of_pipeline = [&](int x, int y) {
        missing.clear();
        for (int r = 0; r < static_cast<int>(contributions.size()); ++r) {
            if (run.has_starved_pixel(r + 1, display, {frame, x, y})) missing.push_back(r);
        }
        return reference.column(contributions, display, x, y, missing).bottom();
    };

    ColourImage picture(scenario.displays.width_pixels, scenario.displays.height_pixels);
    for (int y = 0; y < picture.height_pixels; ++y) {
        for (int x = 0; x < picture.width_pixels; ++x) {
            std::array<int, 3> sum{};
            for (int sample = 0; sample < s * s; ++sample) {
                const Pixel pixel = bottom_of_pipeline(x * s + sample % s, y * s + sample / s);
                sum[0] += pixel.r();
                sum[1] += pixel.g();
                sum[2] += pixel.b();
            }
            std::uint32_t colour = 0;
            for (const int channel : sum) {
                colour = (colour << 8) | static_cast<std::uint32_t>((channel + s * s / 2) >> shift);
            }
            picture.at(x, y) = colour;
        }
    }
    const auto table = scenario.displays.colour_table_of(display);
    return table == nullptr ? picture : naive_correction(*table, std::move(picture));
}

std::int64_t differing_pixels(const ColourImage* shown, const ColourImage& expected) {
    if (shown == nullptr || shown->values.size() != expected.values.size() ||
        shown->width_pixels != expected.width_pixels) {
        return static_cast<std::int64_t>(expected.values.size());
    }
    const auto difference = image_difference(*shown, expected);
    return difference ? difference->pixels : 0;
}

}  // namespace metabuffer::test
