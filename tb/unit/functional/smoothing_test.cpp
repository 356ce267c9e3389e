#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <vector>

#include "functional/functional_compositor.h"
#include "support/images.h"
#include "support/naive_pixels.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "support/scenarios.h"

// Bilinear smoothing (composer.smoothing) of the functional level. The judge is written from the formulas of
// docs/design.md, raster pixel by raster pixel; it shares nothing with any level.

using namespace metabuffer;
using functional::composite_display;
using functional::composite_raster;
using functional::Contribution;

namespace {

Scenario smoothing_scenario(int width, int height, int columns = 1, int rows = 1) {
    Scenario scenario = test::small_scenario(width, height, columns);
    scenario.displays.rows = rows;
    scenario.composer.smoothing = Smoothing::kBilinear;
    return scenario;
}

/// One axis at a raster line of a segment.
struct JudgedAxis {
    int own = 0;
    int other = 0;
    int weight = 0;

    JudgedAxis(int position, int destination, int count, int m) {
        own = static_cast<int>(std::floor((position - destination) / static_cast<double>(m)));
        const int i = position - destination - own * m;
        other = own;
        if (2 * i + 1 < m) other = own - 1;
        if (2 * i + 1 > m) other = own + 1;
        if (other < 0 || other >= count) other = own;
        weight = static_cast<int>(std::floor(256.0 * std::fabs(2.0 * i + 1 - m) / (2.0 * m)));
    }
};

/// The smoothed pixel of a row at a raster position that it covers.
Pixel judged_local(const Scenario& scenario, const PixelImage& image, const ViewportRow& row, int x, int y) {
    const JudgedAxis across(x, row.dx, row.sdx, row.dmultiple);
    const JudgedAxis down(y, row.dy, row.sdy, row.dmultiple);
    const auto source = [&](int column, int line) {
        return test::naive_after_link(image.at(row.sx + column, row.sy + line), scenario.depth_format);
    };
    const Pixel own = source(across.own, down.own);
    const bool key = scenario.composition == Composition::kZAlphaKey;
    if (row.dmultiple == 1 || (key && own.a() == 0)) return own;
    const auto seen = [&](Pixel pixel) {
        return pixel.z() == far_z(scenario.depth_format) || (key && pixel.a() == 0) ? own : pixel;
    };
    const std::array<Pixel, 4> pixels{own, seen(source(across.other, down.own)),
                                      seen(source(across.own, down.other)),
                                      seen(source(across.other, down.other))};
    const std::array<int, 4> weights{(256 - across.weight) * (256 - down.weight),
                                     across.weight * (256 - down.weight), (256 - across.weight) * down.weight,
                                     across.weight * down.weight};
    std::array<double, 4> sums{};
    for (std::size_t n = 0; n < pixels.size(); ++n) {
        sums[0] += pixels[n].r() * weights[n];
        sums[1] += pixels[n].g() * weights[n];
        sums[2] += pixels[n].b() * weights[n];
        sums[3] += pixels[n].a() * weights[n];
    }
    const auto channel = [&](std::size_t n) {
        return static_cast<std::uint8_t>(std::floor((sums[n] + 32768.0) / 65536.0));
    };
    return {channel(0), channel(1), channel(2), channel(3), own.z()};
}

PixelImage judged_raster(const Scenario& scenario, const std::vector<Contribution>& contributions,
                         int display) {
    PixelImage raster(scenario.displays.raster_width_pixels(), scenario.displays.raster_height_pixels());
    for (int y = 0; y < raster.height_pixels; ++y) {
        for (int x = 0; x < raster.width_pixels; ++x) {
            Pixel result = scenario.background_pixel();
            for (const Contribution& contribution : contributions) {
                for (const ViewportRow& row : contribution.rows) {
                    const bool covers = row.dcomp == display && x >= row.dx && y >= row.dy &&
                                        x < row.dx + row.sdx * row.dmultiple &&
                                        y < row.dy + row.sdy * row.dmultiple;
                    if (!covers) continue;
                    const Pixel local = judged_local(scenario, *contribution.image, row, x, y);
                    result = test::naive_blend(scenario.composition, local, result);
                }
            }
            raster.at(x, y) = result;
        }
    }
    return raster;
}

ViewportLimits limits_of(const Scenario& scenario, const PixelImage& image) {
    Renderer renderer;
    renderer.image_width_pixels = image.width_pixels;
    renderer.image_height_pixels = image.height_pixels;
    ViewportLimits limits = scenario.limits(renderer);
    limits.buffer_pixels = 1 << 20;
    return limits;
}

/// Any valid row for the display, often with outermost lines beside the raster.
ViewportRow random_smoothed_row(test::Random& random, const ViewportLimits& limits, int display) {
    for (;;) {
        const int m = random.one_in(6) ? random.between(1, 60) : random.between(1, 7);
        const int width = random.between(1, limits.image_width_pixels);
        const int height = random.between(1, limits.image_height_pixels);
        const ViewportRow row = test::table_row(display,
                                                {random.between(0, limits.image_width_pixels - width),
                                                 random.between(0, limits.image_height_pixels - height)},
                                                {width, height},
                                                {random.between(-2 * m, limits.raster_width_pixels),
                                                 random.between(-2 * m, limits.raster_height_pixels)},
                                                m);
        if (row_defect(row, limits) == RowDefect::kNone) return row;
    }
}

std::string first_difference(const PixelImage& shown, const PixelImage& wanted) {
    for (int y = 0; y < wanted.height_pixels; ++y) {
        for (int x = 0; x < wanted.width_pixels; ++x) {
            if (shown.at(x, y) != wanted.at(x, y)) {
                return "pixel " + std::to_string(x) + ", " + std::to_string(y) + ": " +
                       std::to_string(shown.at(x, y).word()) + " instead of " +
                       std::to_string(wanted.at(x, y).word());
            }
        }
    }
    return {};
}

}  // namespace

TEST_CASE("smoothing: random rows and images agree with the formulas", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20261110);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    int smoothed = 0;
    for (int trial = 0; trial < 400; ++trial) {
        INFO("trial " << trial);
        Scenario scenario =
            smoothing_scenario(random.between(1, 40), random.between(1, 20), random.between(1, 2));
        scenario.composition = test::one_of(random, kCompositionTable).value;
        scenario.depth_format = test::one_of(random, kDepthFormatTable).value;
        std::vector<PixelImage> images;
        for (int n = random.between(1, 3); n > 0; --n) {
            images.push_back(test::corner_image(random, random.between(1, 16), random.between(1, 12)));
        }
        std::vector<Contribution> contributions;
        for (const PixelImage& image : images) {
            Contribution& contribution = contributions.emplace_back();
            contribution.image = &image;
            for (int display = 1; display <= scenario.displays.count(); ++display) {
                contribution.rows.push_back(random_smoothed_row(random, limits_of(scenario, image), display));
                smoothed += contribution.rows.back().dmultiple > 1 ? 1 : 0;
            }
        }
        for (int display = 1; display <= scenario.displays.count(); ++display) {
            INFO("display " << display);
            REQUIRE(first_difference(composite_raster(scenario, contributions, display),
                                     judged_raster(scenario, contributions, display)) == "");
        }
    }
    CHECK(smoothed > 500);
}

TEST_CASE("smoothing: a wall shows to the bit what one large display shows", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20261111);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    int seams = 0;
    for (int trial = 0; trial < 400; ++trial) {
        INFO("trial " << trial);
        const int columns = random.between(1, 3);
        const int rows = random.between(1, 3);
        const int width = random.between(1, 24);
        const int height = random.between(1, 16);
        Scenario wall = smoothing_scenario(width, height, columns, rows);
        wall.composition = test::one_of(random, kCompositionTable).value;
        Scenario large = smoothing_scenario(columns * width, rows * height);
        large.composition = wall.composition;
        const PixelImage image = test::corner_image(random, random.between(1, 16), random.between(1, 12));
        Viewport viewport;
        viewport.multiple = random.one_in(6) ? random.between(1, 50) : random.between(1, 6);
        viewport.x = random.between(-image.width_pixels * viewport.multiple, columns * width);
        viewport.y = random.between(-image.height_pixels * viewport.multiple, rows * height);
        const auto contribution = [&](const Scenario& scenario) {
            Contribution result;
            result.image = &image;
            result.rows = split_viewport(viewport, image.width_pixels, image.height_pixels,
                                         scenario.displays.wall(), Smoothing::kBilinear);
            REQUIRE(validate_table(result.rows, limits_of(scenario, image)).rejected.empty());
            return result;
        };
        const Contribution of_wall = contribution(wall);
        seams += of_wall.rows.size() > 1 ? 1 : 0;
        const PixelImage wanted = composite_raster(large, {contribution(large)}, 1);
        for (int display = 1; display <= wall.displays.count(); ++display) {
            INFO("display " << display);
            const PixelImage shown = composite_raster(wall, {of_wall}, display);
            PixelImage part(width, height);
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    part.at(x, y) =
                        wanted.at((display - 1) % columns * width + x, (display - 1) / columns * height + y);
                }
            }
            REQUIRE(first_difference(shown, part) == "");
        }
    }
    CHECK(seams > 100);
}

TEST_CASE("smoothing: one opaque renderer's image is OpenImageIO's resize with a triangle filter",
          "[functional]") {
    const std::uint64_t seed = test::random_seed(20261112);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int m = 2; m <= 12; ++m) {
        INFO("multiple " << m);
        const PixelImage image = test::opaque_noise_image(random, 17, 11);
        Scenario scenario = smoothing_scenario(image.width_pixels * m, image.height_pixels * m);
        Contribution contribution;
        contribution.image = &image;
        contribution.rows = {test::segment_row({image.width_pixels, image.height_pixels}, {0, 0}, m)};
        const ColourImage picture = composite_display(scenario, {contribution}, 1);

        OIIO::ImageBuf source(
            OIIO::ImageSpec(image.width_pixels, image.height_pixels, 3, OIIO::TypeDesc::FLOAT));
        for (int y = 0; y < image.height_pixels; ++y) {
            for (int x = 0; x < image.width_pixels; ++x) {
                const Pixel pixel = image.at(x, y);
                const std::array<float, 3> rgb{static_cast<float>(pixel.r()), static_cast<float>(pixel.g()),
                                               static_cast<float>(pixel.b())};
                source.setpixel(x, y, rgb.data());
            }
        }
        const OIIO::ImageBuf resized = OIIO::ImageBufAlgo::resize(
            source, "triangle", 0.0F,
            OIIO::ROI(0, picture.width_pixels, 0, picture.height_pixels, 0, 1, 0, 3));
        REQUIRE_FALSE(resized.has_error());
        // Each axis' weight is rounded down to a 256th, and the sum to a whole number.
        const double most = 2 * 255.0 / 256.0 + 0.5 + 0.01;
        double largest = 0.0;
        for (int y = 0; y < picture.height_pixels; ++y) {
            for (int x = 0; x < picture.width_pixels; ++x) {
                std::array<float, 3> rgb{};
                resized.getpixel(x, y, rgb.data());
                for (int channel = 0; channel < 3; ++channel) {
                    const auto shown = static_cast<int>((picture.at(x, y) >> (16 - 8 * channel)) & 0xFFU);
                    largest = std::max(
                        largest,
                        std::fabs(shown - static_cast<double>(rgb[static_cast<std::size_t>(channel)])));
                }
            }
        }
        CHECK(largest <= most);
    }
}

TEST_CASE("smoothing: what a viewer does not see is not mixed in, and a key hides what it hid",
          "[functional]") {
    constexpr std::uint32_t kFar = 0xFFFF;
    for (const CompositionRow& composition : kCompositionTable) {
        INFO(composition.name);
        Scenario scenario = smoothing_scenario(8, 4);
        scenario.composition = composition.value;
        PixelImage image(2, 1);
        image.values = {Pixel(200, 100, 40, 255, 5), Pixel(0, 0, 0, 255, kFar)};
        Contribution contribution;
        contribution.image = &image;
        contribution.rows = {test::segment_row({2, 1}, {0, 0}, 4)};
        // Its neighbour is far away, so the near pixel keeps its colour up to its edge.
        const PixelImage edge = composite_raster(scenario, {contribution}, 1);
        for (int x = 0; x < 4; ++x) CHECK(edge.at(x, 0) == Pixel(200, 100, 40, 255, 5));
        image.values[1] = Pixel(0, 0, 0, 0, 5);
        const PixelImage clear = composite_raster(scenario, {contribution}, 1);
        if (composition.value == Composition::kZAlphaKey) {
            CHECK(clear.at(3, 0) == Pixel(200, 100, 40, 255, 5));
            CHECK(clear.at(4, 0) == scenario.background_pixel());
        } else {
            CHECK(clear.at(2, 0).r() == 175);  // one eighth of the neighbour, which is black
            CHECK(clear.at(3, 0).r() == 125);
        }
    }
}
