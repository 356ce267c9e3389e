#pragma once

#include "tools/exploration/run_process.h"
#include "tools/program/timed_level.h"

namespace metabuffer {

/// A run at this level, for explorations. It throws std::runtime_error, with one line, if the model is at fault.
exploration::Simulate simulation_at(TimedLevel level);

}  // namespace metabuffer
