#include "monitors/picture_reference.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/image_difference.h"
#include "monitors/reference_composition.h"

namespace metabuffer::monitors {

std::string colour_text(std::uint32_t rgb) { return fmt::format("#{:06x}", rgb & kColourMask); }

functional::Contribution PictureReference::contribution(std::size_t renderer, int pair) const {
    std::vector<int> pairs(scenario_.renderers.size(), -1);
    pairs[renderer] = pair;
    return functional::contributions_of(scenario_, pairs)[renderer];
}

Pixel PictureReference::over_the_link(Pixel pixel) const {
    const Pixel colour(pixel.rgb());
    return with_depth_half(colour, depth_link_bits(pixel, scenario_.depth_format), scenario_.depth_format);
}

std::optional<PictureReference::Local> PictureReference::local(const functional::Contribution& contribution,
                                                               int display, int x, int y) const {
    if (contribution.image == nullptr) return std::nullopt;
    for (const ViewportRow& row : contribution.rows) {
        if (row.dcomp != display || x < row.dx || y < row.dy) continue;
        const int column = (x - row.dx) / row.dmultiple;
        const int line = (y - row.dy) / row.dmultiple;
        if (column >= row.sdx || line >= row.sdy) continue;
        const int source_x = row.sx + column;
        const int source_y = row.sy + line;
        Local local{source_x, source_y, over_the_link(contribution.image->at(source_x, source_y))};
        if (scenario_.composer.smoothing == Smoothing::kBilinear && row.dmultiple > 1) {
            local.pixel = smoothed(*contribution.image, row, x, y);
        }
        return local;
    }
    return std::nullopt;
}

Pixel PictureReference::smoothed(const PixelImage& image, const ViewportRow& row, int x, int y) const {
    const ReferenceLines columns = reference_lines(x - row.dx, row.sdx, row.dmultiple);
    const ReferenceLines lines = reference_lines(y - row.dy, row.sdy, row.dmultiple);
    const auto pixel = [&](int column, int line) {
        return over_the_link(image.at(row.sx + column, row.sy + line));
    };
    return reference_smoothing(
        {pixel(columns.own, lines.own), pixel(columns.other, lines.own), pixel(columns.own, lines.other),
         pixel(columns.other, lines.other), columns.weight, lines.weight},
        scenario_.composition, far_z(scenario_.depth_format));
}

PictureReference::Column PictureReference::column(const std::vector<functional::Contribution>& contributions,
                                                  int display, int x, int y,
                                                  const std::vector<int>& missing) const {
    Column column;
    Pixel pixel = scenario_.background_pixel();
    for (std::size_t r = 0; r < contributions.size(); ++r) {
        const bool starved = std::find(missing.begin(), missing.end(), static_cast<int>(r)) != missing.end();
        const std::optional<Local> own = local(contributions[r], display, x, y);
        if (own && !starved) {
            const Pixel out = reference_composition(scenario_.composition, own->pixel, pixel);
            if (out != pixel) {
                column.winner = static_cast<int>(r);
                column.winning = own;
            }
            pixel = out;
        }
        column.stages.push_back(pixel);
    }
    return column;
}

std::optional<std::string> picture_fault(const ColourImage& seen, const ColourImage& expected) {
    if (seen.width_pixels != expected.width_pixels || seen.height_pixels != expected.height_pixels) {
        return "it has " + std::to_string(seen.width_pixels) + "x" + std::to_string(seen.height_pixels) +
               " pixels instead of " + std::to_string(expected.width_pixels) + "x" +
               std::to_string(expected.height_pixels);
    }
    const std::optional<ImageDifference> difference = image_difference(seen, expected);
    if (!difference) return std::nullopt;
    return "pixel " + std::to_string(difference->x) + "," + std::to_string(difference->y) + ": " +
           colour_text(difference->left) + " instead of " + colour_text(difference->right) + ", " +
           std::to_string(difference->pixels) +
           (difference->pixels == 1 ? " pixel differs" : " pixels differ");
}

}  // namespace metabuffer::monitors
