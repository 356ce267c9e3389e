#include "formats/image_difference.h"

namespace metabuffer {

std::optional<ImageDifference> image_difference(const ColourImage& left, const ColourImage& right) {
    std::optional<ImageDifference> difference;
    for (std::size_t i = 0; i < left.values.size(); ++i) {
        if (left.values[i] == right.values[i]) {
            continue;
        }
        if (!difference) {
            const auto width = static_cast<std::size_t>(left.width_pixels);
            difference = ImageDifference{0, static_cast<int>(i % width), static_cast<int>(i / width),
                                         left.values[i], right.values[i]};
        }
        ++difference->pixels;
    }
    return difference;
}

}  // namespace metabuffer
