#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/control_scanline.h"
#include "formats/image.h"
#include "formats/viewport_splitter.h"
#include "scenario/scenario.h"
#include "scenario/scenario_loader.h"
#include "support/rows.h"

/// The parts of the tests' scenarios. A test starts from these and changes the members it is about.
namespace metabuffer::test {

/// Displays of the given size side by side, every other value at its default, no renderer yet.
inline Scenario small_scenario(int width, int height, int displays = 1) {
    Scenario scenario;
    scenario.name = "testbench";
    scenario.displays.columns = displays;
    scenario.displays.width_pixels = width;
    scenario.displays.height_pixels = height;
    return scenario;
}

/// The narrowest image whose control scanline has room for so many rows.
inline int width_for_rows(std::size_t rows) {
    ControlScanline content;
    content.table.resize(rows);
    return static_cast<int>((control_scanline_bytes(content) + kLinkBytesPerPixel - 1) / kLinkBytesPerPixel);
}

/// A renderer of these images, all of one size, without frames yet.
inline Renderer renderer_with(const std::vector<PixelImage>& images) {
    Renderer renderer;
    renderer.name = "renderer";
    renderer.image_width_pixels = images.front().width_pixels;
    renderer.image_height_pixels = images.front().height_pixels;
    for (const PixelImage& image : images)
        renderer.images.push_back(std::make_shared<const StoredImage>(image));
    return renderer;
}

/// A renderer that sends these images in turn, all of one size, each with the same table.
inline Renderer renderer_of(const std::vector<PixelImage>& images, const ViewportTable& table = {}) {
    Renderer renderer = renderer_with(images);
    for (std::size_t i = 0; i < images.size(); ++i) renderer.frames.push_back({i, table, std::nullopt, 0});
    return renderer;
}

/// A renderer that sends a frame for each viewport: the images in turn, the last one again when there is no other.
inline Renderer renderer_of(const std::vector<PixelImage>& images, const std::vector<Viewport>& viewports,
                            const DisplayWall& wall) {
    Renderer renderer = renderer_with(images);
    for (const Viewport& viewport : viewports) {
        RendererFrame frame;
        frame.image = std::min(renderer.frames.size(), images.size() - 1);
        frame.viewport = viewport;
        frame.table =
            split_viewport(viewport, renderer.image_width_pixels, renderer.image_height_pixels, wall);
        renderer.frames.push_back(std::move(frame));
    }
    return renderer;
}

/// Gives the scenario one more renderer, named by its number from 1.
inline void add_renderer(Scenario& scenario, Renderer renderer) {
    renderer.name = "renderer_" + std::to_string(scenario.renderers.size() + 1);
    scenario.renderers.push_back(std::move(renderer));
}

inline Scenario with_renderer(Scenario scenario, Renderer renderer) {
    scenario.renderers.push_back(std::move(renderer));
    return scenario;
}

/// Throws InputError if the scenario breaks a rule with the fault.
inline Scenario with_fault(Scenario scenario, const Fault& fault) {
    scenario.faults.push_back(fault);
    check_scenario(scenario);
    return scenario;
}

/// Clocks at which the composers of a renderer are held back at random.
inline Fault random_stalls(int renderer, int percent, std::int64_t from_cycle = 0,
                           std::optional<std::int64_t> cycles = std::nullopt) {
    Fault fault;
    fault.kind = FaultKind::kRandomStalls;
    fault.renderer = renderer;
    fault.percent = percent;
    fault.from_cycle = from_cycle;
    fault.cycles = cycles;
    return fault;
}

/// Composers that smooth. Viewports are split again, for the aprons, and rows of other tables get lines beside the raster
/// where the image has them.
inline void smooth_tables(Random& random, Scenario& scenario) {
    scenario.composer.smoothing = Smoothing::kBilinear;
    for (Renderer& renderer : scenario.renderers) {
        for (RendererFrame& entry : renderer.frames) {
            if (entry.viewport) {
                entry.table = scenario.table_for(*entry.viewport, renderer);
                continue;
            }
            for (ViewportRow& row : entry.table) {
                if (row.dmultiple < 2 || row.dmultiple > kMaximumMultiple) continue;
                if (row.sx > 0 && row.dx > -row.dmultiple && random.one_in(2)) {
                    --row.sx;
                    ++row.sdx;
                    row.dx = static_cast<std::int16_t>(row.dx - row.dmultiple);
                }
                if (row.sy > 0 && row.dy > -row.dmultiple && random.one_in(2)) {
                    --row.sy;
                    ++row.sdy;
                    row.dy = static_cast<std::int16_t>(row.dy - row.dmultiple);
                }
                if (row.sx + row.sdx < renderer.image_width_pixels && random.one_in(2)) ++row.sdx;
                if (row.sy + row.sdy < renderer.image_height_pixels && random.one_in(2)) ++row.sdy;
            }
        }
    }
}

}  // namespace metabuffer::test
