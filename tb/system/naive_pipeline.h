#pragma once

#include "machine_run.h"

namespace metabuffer::test {

/// What a display (from 1) must show of a frame (from 0), pixel by pixel down the pipeline. It uses the pairs that the
/// run reports, without the local pixels that the run located as glitches. The monitors' reference computes it, which
/// is written apart from both the clocked model and the functional one.
ColourImage picture_without_glitches(const MachineRun& run, int frame, int display);

/// Pixels in which two pictures differ; all of them if a picture is missing or has another size.
std::int64_t differing_pixels(const ColourImage* shown, const ColourImage& expected);

}  // namespace metabuffer::test
