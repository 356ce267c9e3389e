#include "functional/wrong_pixels.h"

#include <functional>
#include <numeric>

namespace metabuffer::functional {

std::int64_t WrongPixels::count(int frame, int display, const ColourImage& picture,
                                const std::vector<int>& pairs) {
    if (frame_ != frame || pairs_ != pairs) {
        compositor_.begin_frame(contributions_of(scenario_, pairs));
        frame_ = frame;
        pairs_ = pairs;
    }
    const ColourImage right = compositor_.picture(display);
    return std::transform_reduce(
        picture.values.begin(), picture.values.end(), right.values.begin(), std::int64_t{0}, std::plus<>(),
        [](std::uint32_t shown, std::uint32_t wanted) { return shown != wanted ? 1 : 0; });
}

}  // namespace metabuffer::functional
