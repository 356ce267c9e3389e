#pragma once

#include <functional>

#include "formats/image.h"

namespace metabuffer {

/// Called when a composited frame (from 0) has been shown in full for the first time on a display (from 1).
using FrameShown = std::function<void(int frame, int display, const ColourImage&)>;

}  // namespace metabuffer
