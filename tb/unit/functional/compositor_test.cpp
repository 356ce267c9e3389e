#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "functional/functional_compositor.h"
#include "support/colour_tables.h"
#include "support/images.h"
#include "support/naive_pixels.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

// The functional compositor goes through the source pixels. The reference in this file goes through the raster: it
// looks up which source pixel shows at each position, and blends in floating point.

using namespace metabuffer;
using functional::composite_display;
using functional::composite_raster;
using functional::Contribution;
using test::naive_after_link;
using test::naive_blend;

namespace {

int floor_div(int dividend, int divisor) {
    return static_cast<int>(std::floor(static_cast<double>(dividend) / divisor));
}

/// The renderer's pixel at a raster position, if it shows there.
bool find_source(const Contribution& contribution, int display, int x, int y, DepthFormat format,
                 Pixel& pixel) {
    if (contribution.image == nullptr) return false;
    for (const ViewportRow& row : contribution.rows) {
        if (row.dcomp != display) continue;
        const int i = floor_div(x - row.dx, row.dmultiple);
        const int j = floor_div(y - row.dy, row.dmultiple);
        if (i < 0 || i >= row.sdx || j < 0 || j >= row.sdy) return false;
        pixel = naive_after_link(contribution.image->at(row.sx + i, row.sy + j), format);
        return true;
    }
    return false;
}

PixelImage naive_raster(const Scenario& scenario, const std::vector<Contribution>& contributions,
                        int display) {
    PixelImage raster(scenario.displays.raster_width_pixels(), scenario.displays.raster_height_pixels());
    for (int y = 0; y < raster.height_pixels; ++y) {
        for (int x = 0; x < raster.width_pixels; ++x) {
            Pixel result = scenario.background_pixel();
            for (const Contribution& contribution : contributions) {
                Pixel local;
                if (find_source(contribution, display, x, y, scenario.depth_format, local)) {
                    result = naive_blend(scenario.composition, local, result);
                }
            }
            raster.at(x, y) = result;
        }
    }
    return raster;
}

ColourImage naive_average(const PixelImage& raster, int s) {
    ColourImage picture(raster.width_pixels / s, raster.height_pixels / s);
    for (int y = 0; y < picture.height_pixels; ++y) {
        for (int x = 0; x < picture.width_pixels; ++x) {
            double sums[3] = {0.0, 0.0, 0.0};
            for (int n = 0; n < s * s; ++n) {
                const Pixel sample = raster.at(x * s + n % s, y * s + n / s);
                sums[0] += sample.r();
                sums[1] += sample.g();
                sums[2] += sample.b();
            }
            std::uint32_t colour = 0;
            for (const double sum : sums) {
                colour = colour * 256 + static_cast<std::uint32_t>(std::floor(sum / (s * s) + 0.5));
            }
            picture.at(x, y) = colour;
        }
    }
    return picture;
}

Scenario one_display(int width, int height, Composition composition = Composition::kZ) {
    Scenario scenario = test::small_scenario(width, height);
    scenario.displays.background[0] = 1;
    scenario.displays.background[1] = 2;
    scenario.displays.background[2] = 3;
    scenario.composition = composition;
    return scenario;
}

ViewportRow whole(const PixelImage& image, int display = 1, int x = 0, int y = 0, int multiple = 1) {
    return test::segment_row({image.width_pixels, image.height_pixels}, {x, y}, multiple, display);
}

ViewportRow random_row(test::Random& random, const Scenario& scenario, const PixelImage& image, int display) {
    const int multiple = random.one_in(2) ? 1 : random.between(2, 7);
    return test::random_row(
        random, {image.width_pixels, image.height_pixels},
        {scenario.displays.raster_width_pixels(), scenario.displays.raster_height_pixels()}, display,
        multiple);
}

Scenario random_machine(test::Random& random) {
    const int supersamples[] = {1, 2, 4};
    Scenario scenario;
    scenario.displays.columns = random.between(1, 3);
    scenario.displays.rows = random.between(1, 3);
    scenario.displays.width_pixels = random.between(1, 20);
    scenario.displays.height_pixels = random.between(1, 20);
    scenario.displays.supersample = supersamples[random.between(0, 2)];
    for (auto& channel : scenario.displays.background) {
        channel = static_cast<std::uint8_t>(random.between(0, 255));
    }
    scenario.composition = test::one_of(random, kCompositionTable).value;
    scenario.depth_format = test::one_of(random, kDepthFormatTable).value;
    return scenario;
}

/// A viewport that touches the wall or lies around it.
Viewport random_viewport(test::Random& random, const Scenario& scenario, const PixelImage& image) {
    Viewport viewport;
    viewport.multiple = random.between(1, 4);
    const DisplayWall wall = scenario.displays.wall();
    viewport.x =
        random.between(-image.width_pixels * viewport.multiple, wall.columns * wall.raster_width_pixels);
    viewport.y =
        random.between(-image.height_pixels * viewport.multiple, wall.rows * wall.raster_height_pixels);
    return viewport;
}

}  // namespace

TEST_CASE("random machines agree with a per-pixel inverse mapping", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260101);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);

    int painted = 0;
    for (int trial = 0; trial < 400; ++trial) {
        INFO("trial " << trial);
        const Scenario scenario = random_machine(random);
        std::vector<PixelImage> images;
        for (int n = random.between(1, 5); n > 0; --n) {
            images.push_back(test::corner_image(random, random.between(1, 24), random.between(1, 24)));
        }
        std::vector<Contribution> contributions;
        for (const PixelImage& image : images) {
            Contribution contribution;
            if (!random.one_in(8)) contribution.image = &image;
            if (random.one_in(2)) {
                contribution.rows =
                    split_viewport(random_viewport(random, scenario, image), image.width_pixels,
                                   image.height_pixels, scenario.displays.wall());
            } else {
                for (int display = scenario.displays.count(); display >= 1; --display) {
                    if (!random.one_in(3)) {
                        contribution.rows.push_back(random_row(random, scenario, image, display));
                    }
                }
            }
            contributions.push_back(contribution);
        }

        for (int display = 1; display <= scenario.displays.count(); ++display) {
            INFO("display " << display);
            const PixelImage expected = naive_raster(scenario, contributions, display);
            painted += static_cast<int>(expected.values.size()) -
                       static_cast<int>(std::count(expected.values.begin(), expected.values.end(),
                                                   scenario.background_pixel()));
            REQUIRE(composite_raster(scenario, contributions, display) == expected);
            REQUIRE(composite_display(scenario, contributions, display) ==
                    naive_average(expected, scenario.displays.supersample));
        }
    }
    CHECK(painted > 10000);  // the machines drawn do show something
}

TEST_CASE(
    "colours are corrected behind the averaging, the background's too, and only of displays with a table",
    "[functional]") {
    test::Random random(7);
    for (const int supersample : {1, 2, 4}) {
        Scenario scenario = random_machine(random);
        scenario.displays.columns = 3;
        scenario.displays.supersample = supersample;
        DisplayCorrection by_formula;
        by_formula.display = 3;
        by_formula.gain[1] = 0.5;
        by_formula.gamma = 2.2;
        DisplayCorrection by_table;
        by_table.display = 1;
        by_table.lut = std::make_shared<const ColourTable>(test::random_colour_table(random));
        scenario.displays.correction = {by_formula, by_table};
        const PixelImage image = test::corner_image(random, 9, 7);
        const std::vector<Contribution> contributions{
            {&image, {whole(image, 1, 1, 1), whole(image, 2, 0, 0), whole(image, 3, 2, 0)}}};
        for (int display = 1; display <= scenario.displays.count(); ++display) {
            INFO("supersample " << supersample << ", display " << display);
            const PixelImage raster = naive_raster(scenario, contributions, display);
            const ColourImage plain = naive_average(raster, supersample);
            const ColourImage picture = composite_display(scenario, contributions, display);
            CHECK(composite_raster(scenario, contributions, display) == raster);
            if (display == 1) {
                CHECK(picture == test::naive_correction(*by_table.lut, plain));
            } else if (display == 3) {
                for (std::size_t n = 0; n < plain.values.size(); ++n) {
                    const std::uint32_t before = plain.values[n];
                    const std::uint32_t after = picture.values[n];
                    REQUIRE(test::may_show(before >> 16, 1.0, 2.2, after >> 16));
                    REQUIRE(test::may_show((before >> 8) & 255, 0.5, 2.2, (after >> 8) & 255));
                    REQUIRE(test::may_show(before & 255, 1.0, 2.2, after & 255));
                }
            } else {
                CHECK(picture == plain);
            }
        }
    }
}

TEST_CASE("wide rasters, any multiple and rows far over every edge agree too", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260102);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);

    int painted = 0;
    for (int trial = 0; trial < 60; ++trial) {
        INFO("trial " << trial);
        Scenario scenario = random_machine(random);
        scenario.displays.columns = 1;
        scenario.displays.rows = 1;
        scenario.displays.width_pixels = random.between(200, 800);
        scenario.displays.height_pixels = random.between(1, 6);
        const int width = scenario.displays.raster_width_pixels();
        const int height = scenario.displays.raster_height_pixels();

        std::vector<PixelImage> images;
        for (int n = random.between(1, 4); n > 0; --n) {
            images.push_back(test::corner_image(random, random.between(1, 900), random.between(1, 10)));
        }
        std::vector<Contribution> contributions;
        for (const PixelImage& image : images) {
            const int multiples[] = {1, 1, 2, 3, 4, 5, 8, 16, 31, 255};
            const int multiple = multiples[random.between(0, 9)];
            // No valid row leaves the raster by more than a source pixel, but the clipping does not rely on
            // it.
            const int x = random.between(std::max(-image.width_pixels * multiple, -2 * width), width);
            const int y = random.between(std::max(-image.height_pixels * multiple, -2 * height), height);
            contributions.push_back({&image, {whole(image, 1, x, y, multiple)}});
        }

        const PixelImage expected = naive_raster(scenario, contributions, 1);
        painted += static_cast<int>(expected.values.size()) -
                   static_cast<int>(std::count(expected.values.begin(), expected.values.end(),
                                               scenario.background_pixel()));
        REQUIRE(composite_raster(scenario, contributions, 1) == expected);
        REQUIRE(composite_display(scenario, contributions, 1) ==
                naive_average(expected, scenario.displays.supersample));
    }
    CHECK(painted > 10000);
}

TEST_CASE(
    "a compositor kept for a run shows what a new one would, and forgets images that a frame has not used",
    "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260103);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);

    for (int trial = 0; trial < 30; ++trial) {
        INFO("trial " << trial);
        const Scenario scenario = random_machine(random);
        std::vector<PixelImage> images(5);
        for (PixelImage& image : images) {
            image = test::corner_image(random, random.between(1, 24), random.between(1, 24));
        }
        functional::Compositor compositor(scenario);
        for (int frame = 0; frame < 6; ++frame) {
            INFO("frame " << frame);
            std::vector<Contribution> contributions(3);
            for (Contribution& contribution : contributions) {
                if (random.one_in(8)) continue;
                // Now and then two renderers show the same image, and images come again later.
                contribution.image = &images[static_cast<std::size_t>(random.between(0, 4))];
                for (int display = 1; display <= scenario.displays.count(); ++display) {
                    contribution.rows.push_back(random_row(random, scenario, *contribution.image, display));
                }
            }
            compositor.begin_frame(contributions);
            for (int display = 1; display <= scenario.displays.count(); ++display) {
                INFO("display " << display);
                REQUIRE(compositor.raster(display) == composite_raster(scenario, contributions, display));
                REQUIRE(compositor.picture(display) == composite_display(scenario, contributions, display));
            }
        }
    }
    const Scenario scenario = one_display(2, 2);
    const PixelImage other(3, 1, Pixel(1, 1, 1, 255, 1));
    PixelImage image(2, 2, Pixel(9, 9, 9, 255, 0));
    functional::Compositor compositor(scenario);

    compositor.begin_frame({{&image, {whole(image)}}});
    CHECK(compositor.raster(1) == image);
    compositor.begin_frame({{&other, {whole(other)}}});
    CHECK(compositor.picture(1).at(1, 0) == 0x010101);
    CHECK(compositor.picture(1).at(1, 1) == 0x010203);

    image = PixelImage(2, 2, Pixel(8, 8, 8, 255, 0));
    compositor.begin_frame({{&image, {whole(image)}}});
    CHECK(compositor.raster(1) == image);
}

TEST_CASE("the nearer pixel wins and a tie keeps the upstream one", "[functional]") {
    const Scenario scenario = one_display(4, 4);
    const Pixel first(10, 11, 12, 200, 100);
    PixelImage top(4, 4, first);
    PixelImage bottom(4, 4, Pixel(20, 21, 22, 0, 100));
    bottom.at(1, 2) = Pixel(30, 31, 32, 0, 99);   // nearer by one
    bottom.at(2, 2) = Pixel(40, 41, 42, 0, 101);  // farther by one
    top.at(3, 3) = Pixel(50, 51, 52, 255, 0xFFFF);
    bottom.at(3, 3) = Pixel(60, 61, 62, 255, 0xFFFF);  // both as far as the background: a tie with it

    const PixelImage raster =
        composite_raster(scenario, {{&top, {whole(top)}}, {&bottom, {whole(bottom)}}}, 1);

    PixelImage expected(4, 4, first);
    expected.at(1, 2) = Pixel(30, 31, 32, 0, 99);
    expected.at(3, 3) = Pixel(1, 2, 3, 0, 0xFFFF);
    CHECK(raster == expected);
}

TEST_CASE("alpha key: a clear pixel never wins, any other alpha does", "[functional]") {
    const Scenario scenario = one_display(4, 4, Composition::kZAlphaKey);
    PixelImage image(4, 4, Pixel(10, 11, 12, 0, 5));
    image.at(0, 0) = Pixel(20, 21, 22, 1, 5);
    image.at(3, 1) = Pixel(30, 31, 32, 255, 5);
    image.at(3, 2) = Pixel(30, 31, 32, 255, 0xFFFF);

    const PixelImage raster = composite_raster(scenario, {{&image, {whole(image)}}}, 1);

    PixelImage expected(4, 4, Pixel(1, 2, 3, 0, 0xFFFF));
    expected.at(0, 0) = Pixel(20, 21, 22, 1, 5);
    expected.at(3, 1) = Pixel(30, 31, 32, 255, 5);
    CHECK(raster == expected);
}

TEST_CASE("over: the front's colour plus what shows through it", "[functional]") {
    Scenario scenario = one_display(2, 2, Composition::kOver);
    PixelImage top(2, 2, Pixel(100, 50, 0, 128, 10));
    PixelImage bottom(2, 2, Pixel(200, 255, 1, 255, 20));  // behind
    bottom.at(1, 0) = Pixel(200, 255, 1, 255, 5);          // opaque and in front
    bottom.at(0, 1) = Pixel(10, 20, 30, 40, 10);           // tie: the upstream pixel is the front
    bottom.at(1, 1) = Pixel(255, 255, 255, 0, 5);          // clear but bright, in front: saturates

    const PixelImage raster =
        composite_raster(scenario, {{&top, {whole(top)}}, {&bottom, {whole(bottom)}}}, 1);

    // Over the background (1, 2, 3, A 0) the upstream pixel becomes (100, 51, 1, 128): 1, 2, 3 times 127/255
    // are 0.498, 0.996 and 1.494.
    CHECK(raster.at(0, 0) ==
          Pixel(200, 178, 1, 255, 10));  // 200, 255, 1, 255 times 127/255: 99.6, 127, .5-, 127
    CHECK(raster.at(1, 0) == Pixel(200, 255, 1, 255, 5));
    CHECK(raster.at(0, 1) ==
          Pixel(105, 61, 16, 148, 10));  // 10, 20, 30, 40 times 127/255: 4.98 9.96 14.9 19.9
    CHECK(raster.at(1, 1) == Pixel(255, 255, 255, 128, 5));
}

TEST_CASE("over rounds every product of a channel and an alpha as the datapath does", "[functional]") {
    const Scenario scenario = one_display(256, 256, Composition::kOver);
    PixelImage back(256, 256);
    PixelImage front(256, 256);
    for (int alpha = 0; alpha < 256; ++alpha) {
        for (int channel = 0; channel < 256; ++channel) {
            const auto value = static_cast<std::uint8_t>(channel);
            back.at(channel, alpha) = Pixel(value, value, value, 255, 2);
            front.at(channel, alpha) = Pixel(0, 200, 255, static_cast<std::uint8_t>(alpha), 1);
        }
    }

    const PixelImage raster =
        composite_raster(scenario, {{&back, {whole(back)}}, {&front, {whole(front)}}}, 1);

    int differences = 0;
    for (int alpha = 0; alpha < 256; ++alpha) {
        for (int channel = 0; channel < 256; ++channel) {
            const std::uint32_t product = static_cast<std::uint32_t>(channel * (255 - alpha));
            const std::uint32_t through = div255(product);
            const Pixel expected(static_cast<std::uint8_t>(through),
                                 static_cast<std::uint8_t>(std::min(255U, 200U + through)), 255, 255, 1);
            const auto nearest = static_cast<std::uint32_t>(std::lround(product / 255.0));
            if (raster.at(channel, alpha) != expected || through != nearest) ++differences;
        }
    }
    CHECK(differences == 0);
}

TEST_CASE("pixels are replicated and clipped at every edge of the raster", "[functional]") {
    const Scenario scenario = one_display(4, 4);
    const Pixel background(1, 2, 3, 0, 0xFFFF);
    const Pixel a(10, 0, 0, 255, 0);
    const Pixel b(20, 0, 0, 255, 0);
    const Pixel c(30, 0, 0, 255, 0);
    const Pixel d(40, 0, 0, 255, 0);
    PixelImage image(2, 2);
    image.values = {a, b, c, d};

    SECTION("past the top left") {
        PixelImage expected(4, 4, background);
        expected.values = {a,          b,          b,          background,  //
                           c,          d,          d,          background,  //
                           c,          d,          d,          background,  //
                           background, background, background, background};
        CHECK(composite_raster(scenario, {{&image, {whole(image, 1, -1, -1, 2)}}}, 1) == expected);
    }
    SECTION("past the bottom right") {
        PixelImage expected(4, 4, background);
        expected.values = {background, background, background, background,  //
                           background, a,          a,          a,           //
                           background, a,          a,          a,           //
                           background, a,          a,          a};
        ViewportRow row = whole(image, 1, 1, 1, 255);
        row.sdx = 1;
        row.sdy = 1;
        CHECK(composite_raster(scenario, {{&image, {row}}}, 1) == expected);
    }
    SECTION("past the top left, one to one") {
        // No valid row lies so (its first source pixel would not show), but the clipping does not rely on
        // that.
        PixelImage expected(4, 4, background);
        expected.at(0, 0) = d;
        CHECK(composite_raster(scenario, {{&image, {whole(image, 1, -1, -1)}}}, 1) == expected);
    }
    SECTION("a part of the source, one to one") {
        PixelImage expected(4, 4, background);
        expected.at(3, 2) = d;
        ViewportRow row = whole(image, 1, 3, 2);
        row.sx = 1;
        row.sy = 1;
        row.sdx = 1;
        row.sdy = 1;
        CHECK(composite_raster(scenario, {{&image, {row}}}, 1) == expected);
    }
}

TEST_CASE("only a row for the display and a renderer with a good pair contribute", "[functional]") {
    Scenario scenario = one_display(2, 1);
    scenario.displays.columns = 2;
    const PixelImage background(2, 1, Pixel(1, 2, 3, 0, 0xFFFF));
    const PixelImage image(2, 1, Pixel(9, 9, 9, 255, 0));

    CHECK(composite_raster(scenario, {{&image, {whole(image, 2)}}}, 1) == background);
    CHECK(composite_raster(scenario, {{&image, {whole(image, 2)}}}, 2) == image);
    CHECK(composite_raster(scenario, {{nullptr, {whole(image, 2)}}}, 2) == background);
    CHECK(composite_raster(scenario, {{&image, {}}}, 2) == background);
}

TEST_CASE("what the link does not carry of an image is lost", "[functional]") {
    Scenario scenario = one_display(1, 1);
    const PixelImage image(1, 1, Pixel(9, 8, 7, 0, 0x12'3456));

    scenario.depth_format = DepthFormat::kA8Z16;
    CHECK(composite_raster(scenario, {{&image, {whole(image)}}}, 1).at(0, 0) == Pixel(9, 8, 7, 0, 0x3456));
    scenario.depth_format = DepthFormat::kZ24;
    CHECK(composite_raster(scenario, {{&image, {whole(image)}}}, 1).at(0, 0) ==
          Pixel(9, 8, 7, 255, 0x12'3456));
}

TEST_CASE("averaging leaves out what does not fill a square", "[functional]") {
    PixelImage raster(601, 5, Pixel(7, 7, 7, 255, 0));
    raster.at(600, 4) = Pixel(255, 255, 255, 255, 0);
    for (const int s : {1, 2, 4}) {
        INFO("supersample " << s);
        CHECK(functional::average_raster(raster, s) == naive_average(raster, s));
    }
}

TEST_CASE("averaging rounds halves up, each channel alone", "[functional]") {
    PixelImage raster(4, 2, Pixel(0, 255, 7, 0, 0));
    raster.at(0, 0) = Pixel(1, 255, 8, 0, 0);
    raster.at(1, 1) = Pixel(1, 255, 7, 0, 0);  // left block: red 2/4, green full, blue 29/4
    raster.at(3, 0) = Pixel(1, 254, 9, 0, 0);  // right block: red 1/4, green 1019/4, blue 30/4

    const ColourImage picture = functional::average_raster(raster, 2);
    REQUIRE(picture.width_pixels == 2);
    REQUIRE(picture.height_pixels == 1);
    CHECK(picture.at(0, 0) == 0x01FF07);
    CHECK(picture.at(1, 0) == 0x00FF08);

    const ColourImage same = functional::average_raster(raster, 1);
    CHECK(same.at(3, 0) == 0x01FE09);
    CHECK(same.at(2, 1) == 0x00FF07);
}
