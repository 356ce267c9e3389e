#include "icet_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "formats/depth_format.h"
#include "scenario/scenario_loader.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "support/scenarios.h"

namespace metabuffer::icet {
namespace {

constexpr float kFarDepth = 1.0F;
constexpr int kDepthBits = 24;

float depth_of(std::uint32_t z, std::uint32_t far) {
    return z == far ? kFarDepth : std::ldexp(static_cast<float>(z), -kDepthBits);
}

/// The corners of a segment's rectangle on the wall.
struct Area {
    int left = 0, top = 0, right = 0, bottom = 0;
};

/// The part of a row's segment that its display's raster has.
Area shown_area(const ViewportRow& row, const DisplayConfig& displays) {
    return {std::max<int>(row.dx, 0), std::max<int>(row.dy, 0),
            std::min(row.dx + row.sdx * row.dmultiple, displays.raster_width_pixels()),
            std::min(row.dy + row.sdy * row.dmultiple, displays.raster_height_pixels())};
}

PixelImage random_image(test::Random& random, int width, int height, std::uint32_t far,
                        std::uint32_t renderer, std::uint32_t renderers) {
    PixelImage image(width, height);
    const std::uint32_t steps = (far - 1 - renderer) / renderers;
    for (Pixel& pixel : image.values) {
        const std::uint64_t bits = random.bits();
        const auto byte = [bits](int from) { return static_cast<std::uint8_t>(bits >> from); };
        const std::uint32_t step = random.one_in(8) ? (random.one_in(2) ? 0 : steps)
                                                    : static_cast<std::uint32_t>(random.bits() % (steps + 1));
        const std::uint32_t z = random.one_in(10) ? far : step * renderers + renderer;
        pixel = Pixel(byte(0), byte(8), byte(16), byte(24), z);
    }
    return image;
}

}  // namespace

WallSize wall_size(const DisplayConfig& displays) {
    return {displays.columns * displays.raster_width_pixels(),
            displays.rows * displays.raster_height_pixels()};
}

WallImage placed(const Scene& scene, std::size_t renderer) {
    const Scenario& scenario = *scene.scenario;
    const DisplayConfig& displays = scenario.displays;
    const WallSize wall = wall_size(displays);
    const std::uint32_t far = far_z(scenario.depth_format);
    WallImage image;
    image.rgba.resize(4 * wall.pixels());
    image.depths.assign(wall.pixels(), kFarDepth);
    Area used{wall.width_pixels, wall.height_pixels, 0, 0};
    const functional::Contribution& contribution = scene.contributions[renderer];
    if (contribution.image == nullptr) return image;
    for (const ViewportRow& row : contribution.rows) {
        const int column = (row.dcomp - 1) % displays.columns * displays.raster_width_pixels();
        const int line = (row.dcomp - 1) / displays.columns * displays.raster_height_pixels();
        const Area area = shown_area(row, displays);
        for (int y = area.top; y < area.bottom; ++y) {
            for (int x = area.left; x < area.right; ++x) {
                const Pixel source = contribution.image->at(row.sx + (x - row.dx) / row.dmultiple,
                                                            row.sy + (y - row.dy) / row.dmultiple);
                const Pixel pixel =
                    with_depth_half(Pixel(source.rgb()), depth_link_bits(source, scenario.depth_format),
                                    scenario.depth_format);
                const std::size_t n =
                    static_cast<std::size_t>(line + y) * static_cast<std::size_t>(wall.width_pixels) +
                    static_cast<std::size_t>(column + x);
                const std::array<std::uint8_t, 4> bytes{pixel.r(), pixel.g(), pixel.b(), pixel.a()};
                std::copy(bytes.begin(), bytes.end(),
                          image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * n));
                image.depths[n] = depth_of(pixel.z(), far);
            }
        }
        used = {std::min(used.left, column + area.left), std::min(used.top, line + area.top),
                std::max(used.right, column + area.right), std::max(used.bottom, line + area.bottom)};
    }
    if (used.left < used.right && used.top < used.bottom) {
        const std::array<int, 4> viewport{used.left, used.top, used.right - used.left,
                                          used.bottom - used.top};
        std::copy(viewport.begin(), viewport.end(), std::begin(image.viewport));
    }
    return image;
}

std::uint32_t z_of(float depth, std::uint32_t far) {
    return depth >= kFarDepth ? far : static_cast<std::uint32_t>(std::ldexp(depth, kDepthBits));
}

Scenario scenario_of(const std::vector<WallImage>& images, const Scenario& of) {
    const WallSize wall = wall_size(of.displays);
    const std::uint32_t far = far_z(of.depth_format);
    Scenario scenario;
    scenario.name = of.name;
    scenario.displays = of.displays;
    scenario.depth_format = of.depth_format;
    for (const WallImage& image : images) {
        PixelImage pixels(wall.width_pixels, wall.height_pixels);
        for (std::size_t n = 0; n < pixels.values.size(); ++n) {
            const std::uint8_t* const bytes = &image.rgba[4 * n];
            pixels.values[n] = Pixel(bytes[0], bytes[1], bytes[2], bytes[3], z_of(image.depths[n], far));
        }
        test::add_renderer(
            scenario, test::renderer_of({std::move(pixels)}, {Viewport{0, 0, 1}}, scenario.displays.wall()));
    }
    return scenario;
}

Scenario random_wall(std::uint64_t seed, std::size_t renderers) {
    test::Random random(seed);
    Scenario scenario =
        test::small_scenario(random.between(1, 60), random.between(1, 50), random.between(1, 3));
    scenario.name = "random " + std::to_string(seed);
    scenario.displays.rows = random.between(1, 3);
    scenario.displays.supersample = test::one_of(random, std::array<int, 4>{1, 1, 2, 4});
    for (std::uint8_t& channel : scenario.displays.background) {
        channel = static_cast<std::uint8_t>(random.between(0, 255));
    }
    scenario.depth_format = test::one_of(random, kDepthFormatTable).value;
    // Replicated rows of any width fit.
    scenario.composer.buffer_pixels = 4096;
    for (std::size_t r = 0; r < renderers; ++r) {
        const int width = std::max(random.between(4, 200), test::width_for_rows(9));
        const int height = random.between(2, 100);
        Renderer renderer = test::renderer_with(
            {random_image(random, width, height, far_z(scenario.depth_format), static_cast<std::uint32_t>(r),
                          static_cast<std::uint32_t>(renderers))});
        RendererFrame& frame = renderer.frames.emplace_back();
        for (int display = 1; display <= scenario.displays.count(); ++display) {
            if (random.one_in(4)) continue;
            const int multiple = random.one_in(2) ? 1 : random.between(2, 9);
            frame.table.push_back(test::random_row(
                random, {width, height},
                {scenario.displays.raster_width_pixels(), scenario.displays.raster_height_pixels()}, display,
                multiple));
        }
        test::add_renderer(scenario, std::move(renderer));
    }
    check_scenario(scenario);
    return scenario;
}

}  // namespace metabuffer::icet
