#include "functional/wrong_pixels.h"

namespace metabuffer::functional {

std::vector<std::size_t> WrongPixels::find(int frame, int display, const ColourImage& picture,
                                           const std::vector<int>& pairs) {
    if (frame_ != frame || pairs_ != pairs) {
        compositor_.begin_frame(contributions_of(scenario_, pairs));
        frame_ = frame;
        pairs_ = pairs;
    }
    const ColourImage right = compositor_.picture(display);
    std::vector<std::size_t> wrong;
    for (std::size_t i = 0; i < picture.values.size(); ++i) {
        if (picture.values[i] != right.values[i]) wrong.push_back(i);
    }
    return wrong;
}

}  // namespace metabuffer::functional
