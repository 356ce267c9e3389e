#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "formats/image.h"

namespace metabuffer {

/// A composited frame that a display has shown in full for the first time.
struct DisplayedFrame {
    int frame = 0;    ///< from 0
    int display = 0;  ///< from 1
    const ColourImage& picture;
    const std::vector<int>& pairs;    ///< that renderers contributed, -1: none
    std::int64_t starved_pixels = 0;  ///< of the display's raster, over its composers
    bool kept = false;                ///< pixels of it were lost: the picture is that of an earlier frame
};

using FrameShown = std::function<void(const DisplayedFrame&)>;

}  // namespace metabuffer
