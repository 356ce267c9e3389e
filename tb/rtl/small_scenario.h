#pragma once

#include <memory>

#include "formats/image.h"
#include "scenario/scenario.h"

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

/// A renderer that sends these images in turn, all of one size, each with the same table.
inline Renderer renderer_of(const std::vector<PixelImage>& images, const ViewportTable& table = {}) {
    Renderer renderer;
    renderer.name = "renderer";
    renderer.image_width_pixels = images.front().width_pixels;
    renderer.image_height_pixels = images.front().height_pixels;
    for (std::size_t i = 0; i < images.size(); ++i) {
        renderer.images.push_back(std::make_shared<const PixelImage>(images[i]));
        RendererFrame frame;
        frame.image = i;
        frame.table = table;
        renderer.frames.push_back(frame);
    }
    return renderer;
}

struct Place {
    int x = 0;
    int y = 0;
};
struct Size {
    int width = 0;
    int height = 0;
};

/// A table row: `size` source pixels from `source`, to `destination` on the raster of display `dcomp`.
inline ViewportRow table_row(int dcomp, Place source, Size size, Place destination, int multiple = 1) {
    ViewportRow row;
    row.dcomp = static_cast<std::uint16_t>(dcomp);
    row.sx = static_cast<std::uint16_t>(source.x);
    row.sy = static_cast<std::uint16_t>(source.y);
    row.sdx = static_cast<std::uint16_t>(size.width);
    row.sdy = static_cast<std::uint16_t>(size.height);
    row.dx = static_cast<std::int16_t>(destination.x);
    row.dy = static_cast<std::int16_t>(destination.y);
    row.dmultiple = static_cast<std::uint16_t>(multiple);
    return row;
}

}  // namespace metabuffer::test
