#pragma once

#include "host/range.h"

namespace metabuffer {

/// The ranges of options. Commands and the Python module share them.
constexpr NumberRange kFrameRatesHz{1e-3, 1e9};
constexpr NumberRange kTimeLimitSeconds{1e-3, 1e9};
/// Simulations at once.
constexpr IntegerRange kProcesses{1, 4096};
/// Further values that a search tries.
constexpr IntegerRange kChecks{0, 1'000'000};

}  // namespace metabuffer
