#pragma once

#include "tools/exploration/run_process.h"
#include "tools/program/timed_level.h"

namespace metabuffer {

/// A run at this level, for explorations. It throws std::runtime_error, with one line, if the model is at fault.
exploration::Simulate simulation_at(TimedLevel level);

/// Whether the level needs the images' pixels in a run without pictures, too: they are on the links of level rtl.
constexpr bool always_needs_pixels(TimedLevel level) { return level == TimedLevel::kRtl; }

}  // namespace metabuffer
