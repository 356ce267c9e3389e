#include "naive_pipeline.h"

#include <algorithm>
#include <array>
#include <optional>

#include "functional/functional_compositor.h"

namespace metabuffer::test {
namespace {

/// A pixel with a number a field.
struct Fields {
    std::array<int, 4> rgba{};
    std::uint32_t z = 0;
};

int div255(int t) { return (t + 128 + ((t + 128) >> 8)) >> 8; }

Fields merge(Composition composition, const Fields& local, const Fields& upstream) {
    const bool nearer = local.z < upstream.z;
    if (composition == Composition::kZ) {
        return nearer ? local : upstream;
    }
    if (composition == Composition::kZAlphaKey) {
        return nearer && local.rgba[3] != 0 ? local : upstream;
    }
    const Fields& front = nearer ? local : upstream;
    const Fields& back = nearer ? upstream : local;
    Fields out = front;
    for (std::size_t c = 0; c < out.rgba.size(); ++c) {
        out.rgba[c] = std::min(255, front.rgba[c] + div255(back.rgba[c] * (255 - front.rgba[3])));
    }
    return out;
}

/// What a depth frame leaves of a source pixel.
Fields over_the_link(Pixel pixel, DepthFormat format) {
    if (format == DepthFormat::kZ24) {
        return {{pixel.r(), pixel.g(), pixel.b(), 255}, pixel.z()};
    }
    return {{pixel.r(), pixel.g(), pixel.b(), pixel.a()}, pixel.z() & 0xFFFFU};
}

/// The source pixel that a row puts on a raster position, if any.
std::optional<Pixel> local_pixel(const ViewportRow& row, const PixelImage& image, int x, int y) {
    const int m = row.dmultiple;
    const bool inside = x >= row.dx && x < row.dx + row.sdx * m && y >= row.dy && y < row.dy + row.sdy * m;
    if (!inside) {
        return std::nullopt;
    }
    return image.at(row.sx + (x - row.dx) / m, row.sy + (y - row.dy) / m);
}

}  // namespace

ColourImage picture_without_glitches(const MachineRun& run, int frame, int display) {
    const Scenario& scenario = run.scenario();
    const auto contributions =
        functional::contributions_of(scenario, run.report().frames.at(static_cast<std::size_t>(frame)).pairs);
    const int s = scenario.displays.supersample;
    const int shift = s == 1 ? 0 : (s == 2 ? 2 : 4);
    const Fields top{{scenario.displays.background[0], scenario.displays.background[1],
                      scenario.displays.background[2], 0},
                     far_z(scenario.depth_format)};

    const auto bottom_of_pipeline = [&](int x, int y) {
        Fields pixel = top;
        for (std::size_t r = 0; r < contributions.size(); ++r) {
            for (const ViewportRow& row : contributions[r].rows) {
                if (row.dcomp != display) continue;
                const std::optional<Pixel> local = local_pixel(row, *contributions[r].image, x, y);
                const bool starved = run.has_glitch(static_cast<int>(r) + 1, display, {frame, x, y});
                if (local && !starved) {
                    pixel = merge(scenario.composition, over_the_link(*local, scenario.depth_format), pixel);
                }
            }
        }
        return pixel;
    };

    ColourImage picture(scenario.displays.width_pixels, scenario.displays.height_pixels);
    for (int y = 0; y < picture.height_pixels; ++y) {
        for (int x = 0; x < picture.width_pixels; ++x) {
            std::array<int, 3> sum{};
            for (int sample = 0; sample < s * s; ++sample) {
                const Fields pixel = bottom_of_pipeline(x * s + sample % s, y * s + sample / s);
                for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += pixel.rgba[c];
            }
            std::uint32_t colour = 0;
            for (const int channel : sum) {
                colour = (colour << 8) | static_cast<std::uint32_t>((channel + s * s / 2) >> shift);
            }
            picture.at(x, y) = colour;
        }
    }
    return picture;
}

std::int64_t differing_pixels(const ColourImage* shown, const ColourImage& expected) {
    if (shown == nullptr || shown->values.size() != expected.values.size() ||
        shown->width_pixels != expected.width_pixels) {
        return static_cast<std::int64_t>(expected.values.size());
    }
    std::int64_t count = 0;
    for (std::size_t i = 0; i < expected.values.size(); ++i) {
        count += shown->values[i] != expected.values[i] ? 1 : 0;
    }
    return count;
}

}  // namespace metabuffer::test
