#include "functional/wrong_pixels.h"

#include <catch2/catch.hpp>

#include "support/scenarios.h"

namespace metabuffer::functional {
namespace {

TEST_CASE("wrong pixels: those that differ from the picture of the same pairs, frame by frame") {
    PixelImage first(16, 8);
    PixelImage second(16, 8);
    for (Pixel& pixel : first.values) pixel = {10, 20, 30, 255, 5};
    for (Pixel& pixel : second.values) pixel = {40, 50, 60, 255, 5};
    Scenario scenario = test::small_scenario(16, 8, 2);
    scenario.frames = 2;
    test::add_renderer(scenario,
                       test::renderer_of({first, second}, {{0, 0, 1}, {16, 0, 1}}, scenario.displays.wall()));
    WrongPixels wrong(scenario);
    const ColourImage of_first = composite_display(scenario, contributions_of(scenario, {0}), 1);
    const ColourImage of_second = composite_display(scenario, contributions_of(scenario, {1}), 2);
    CHECK(wrong.find(0, 1, of_first, {0}).empty());
    ColourImage corrupt = of_first;
    corrupt.at(3, 4) ^= 1U;
    corrupt.at(15, 7) ^= 0x800000U;
    CHECK(wrong.find(0, 1, corrupt, {0}) == std::vector<std::size_t>{4 * 16 + 3, 7 * 16 + 15});
    CHECK(wrong.find(0, 2, of_first, {0}).size() == 16 * 8);  // the image is on display 1
    // The second frame is judged by its own pair, which may be the first one again.
    CHECK(wrong.find(1, 2, of_second, {1}).empty());
    CHECK(wrong.find(2, 1, of_first, {0}).empty());
    // After a reset a frame may come again, of other pairs.
    CHECK(wrong.find(2, 1, of_first, {1}).size() == 16 * 8);
    CHECK(wrong.find(3, 1, of_first, {-1}).size() == 16 * 8);
}

}  // namespace
}  // namespace metabuffer::functional
