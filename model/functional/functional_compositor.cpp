#include "functional/functional_compositor.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace metabuffer::functional {

namespace {

/// A pixel as it is after the link: a depth frame has no room for the alpha of z24 nor for more than 16 bits
/// of Z in a8z16, so an image that holds more loses it here as it does in the machine.
Pixel after_link(Pixel pixel, DepthFormat format) {
    return format == DepthFormat::kA8Z16
               ? Pixel(pixel.r(), pixel.g(), pixel.b(), pixel.a(), pixel.z() & 0xFFFFU)
               : Pixel(pixel.r(), pixel.g(), pixel.b(), 255, pixel.z());
}

struct KeepNearest {
    Pixel operator()(Pixel local, Pixel upstream) const {
        return local.z() < upstream.z() ? local : upstream;
    }
};

struct KeepNearestUnlessClear {
    Pixel operator()(Pixel local, Pixel upstream) const {
        // Both conditions are evaluated so that the selection needs no branch.
        const bool local_wins = (local.z() < upstream.z()) & (local.a() != 0);
        return local_wins ? local : upstream;
    }
};

struct PremultipliedOver {
    /// front + back * (1 - front alpha) in steps of 1/255: the product is rounded to nearest by an exact
    /// division, halves cannot occur because 255 is odd.
    static std::uint8_t channel(unsigned front, unsigned back, unsigned front_alpha) {
        const unsigned product = back * (255U - front_alpha);
        const unsigned sum = front + (2U * product + 255U) / 510U;
        return static_cast<std::uint8_t>(std::min(sum, 255U));
    }

    Pixel operator()(Pixel local, Pixel upstream) const {
        const bool local_in_front = local.z() < upstream.z();
        const Pixel front = local_in_front ? local : upstream;
        const Pixel back = local_in_front ? upstream : local;
        const unsigned alpha = front.a();
        return {channel(front.r(), back.r(), alpha), channel(front.g(), back.g(), alpha),
                channel(front.b(), back.b(), alpha), channel(alpha, back.a(), alpha), front.z()};
    }
};

/// A half-open range of raster columns or rows.
struct Span {
    int begin = 0;
    int end = 0;
};

/// The raster positions that `count` source pixels from `start` on fill, clipped to 0..size.
Span clipped(int start, int count, int multiple, int size) {
    const Span span{std::max(start, 0), std::min(start + count * multiple, size)};
    return {span.begin, std::max(span.begin, span.end)};
}

/// Paints one segment: each source row is laid out once as the raster line it makes, replicated and clipped,
/// and that line is merged into each raster row that the source row fills.
template <typename Merge>
void paint_segment(PixelImage& raster, const PixelImage& image, const ViewportRow& row, DepthFormat format,
                   Merge merge) {
    const int multiple = row.dmultiple;
    const Span columns = clipped(row.dx, row.sdx, multiple, raster.width_pixels);
    std::vector<Pixel> line(static_cast<std::size_t>(columns.end - columns.begin));

    for (int j = 0; j < row.sdy; ++j) {
        const Span rows = clipped(row.dy + j * multiple, 1, multiple, raster.height_pixels);
        if (rows.begin == rows.end) continue;

        const Pixel* source = &image.values[image.index(row.sx, row.sy + j)];
        if (multiple == 1) {
            const Pixel* first = source + (columns.begin - row.dx);
            std::transform(first, first + line.size(), line.begin(),
                           [format](Pixel pixel) { return after_link(pixel, format); });
        } else {
            for (int i = 0; i < row.sdx; ++i) {
                const Span block = clipped(row.dx + i * multiple, 1, multiple, raster.width_pixels);
                std::fill(line.begin() + (block.begin - columns.begin),
                          line.begin() + (block.end - columns.begin), after_link(source[i], format));
            }
        }

        for (int y = rows.begin; y < rows.end; ++y) {
            Pixel* target = &raster.values[raster.index(columns.begin, y)];
            for (std::size_t n = 0; n < line.size(); ++n) target[n] = merge(line[n], target[n]);
        }
    }
}

/// Whether a pair with these faults never reaches the back bank in time. A link that is silent for some pair
/// times and then needs one more for the pair itself is late only past the timeout.
bool is_lost(const Scenario& scenario, int renderer, std::uint32_t pair) {
    std::int64_t pair_times = 1;
    for (const Fault& fault : scenario.faults) {
        if (fault.renderer != renderer || fault.pair != pair) continue;
        if (fault.kind != FaultKind::kDelay) return true;
        pair_times += fault.delay_pairs;
    }
    return pair_times > scenario.link_timeout_pairs;
}

}  // namespace

PixelImage composite_raster(const Scenario& scenario, const std::vector<Contribution>& contributions,
                            int display) {
    PixelImage raster(scenario.displays.raster_width_pixels(), scenario.displays.raster_height_pixels(),
                      scenario.background_pixel());
    for (const Contribution& contribution : contributions) {
        if (contribution.image == nullptr) continue;
        const auto row =
            std::find_if(contribution.rows.begin(), contribution.rows.end(),
                         [display](const ViewportRow& candidate) { return candidate.dcomp == display; });
        if (row == contribution.rows.end()) continue;

        const PixelImage& image = *contribution.image;
        const DepthFormat format = scenario.depth_format;
        switch (scenario.composition) {
            case Composition::kZ:
                paint_segment(raster, image, *row, format, KeepNearest{});
                break;
            case Composition::kZAlphaKey:
                paint_segment(raster, image, *row, format, KeepNearestUnlessClear{});
                break;
            case Composition::kOver:
                paint_segment(raster, image, *row, format, PremultipliedOver{});
                break;
        }
    }
    return raster;
}

ColourImage average_raster(const PixelImage& raster, int supersample) {
    ColourImage picture(raster.width_pixels / supersample, raster.height_pixels / supersample);
    const unsigned samples = static_cast<unsigned>(supersample) * static_cast<unsigned>(supersample);
    const auto mean = [samples](unsigned sum) { return (sum + samples / 2) / samples; };

    for (int y = 0; y < picture.height_pixels; ++y) {
        for (int x = 0; x < picture.width_pixels; ++x) {
            unsigned red = 0;
            unsigned green = 0;
            unsigned blue = 0;
            for (int j = 0; j < supersample; ++j) {
                const Pixel* sample = &raster.values[raster.index(x * supersample, y * supersample + j)];
                for (int i = 0; i < supersample; ++i) {
                    red += sample[i].r();
                    green += sample[i].g();
                    blue += sample[i].b();
                }
            }
            picture.at(x, y) = (mean(red) << 16) | (mean(green) << 8) | mean(blue);
        }
    }
    return picture;
}

ColourImage composite_display(const Scenario& scenario, const std::vector<Contribution>& contributions,
                              int display) {
    return average_raster(composite_raster(scenario, contributions, display), scenario.displays.supersample);
}

// With free-running pacing it is time that decides which pair a frame shows, and there is none here: the same
// rule stands in for it. The clocked model's report tells which pairs were shown (FrameRecord::pairs);
// contributions_of takes those as well as the ones made here.
std::vector<std::vector<int>> pairs_without_time(const Scenario& scenario) {
    std::vector<int> last_good(scenario.renderers.size(), -1);
    std::vector<std::vector<int>> result;
    for (int frame = 0; frame < scenario.frames; ++frame) {
        for (std::size_t renderer = 0; renderer < last_good.size(); ++renderer) {
            if (!is_lost(scenario, static_cast<int>(renderer), static_cast<std::uint32_t>(frame))) {
                last_good[renderer] = frame;
            }
        }
        result.push_back(last_good);
    }
    return result;
}

std::vector<Contribution> contributions_of(const Scenario& scenario, const std::vector<int>& pairs) {
    std::vector<Contribution> contributions(scenario.renderers.size());
    for (std::size_t index = 0; index < contributions.size(); ++index) {
        if (pairs.at(index) < 0) continue;
        const Renderer& renderer = scenario.renderers[index];
        const auto pair = static_cast<std::uint32_t>(pairs[index]);
        contributions[index] = {
            &renderer.image_of_pair(pair),
            validate_table(renderer.frame_of_pair(pair).table, scenario.limits(renderer)).rows};
    }
    return contributions;
}

}  // namespace metabuffer::functional
