#pragma once

#include "host/range.h"

namespace metabuffer {

/// What the options of several commands take, for whoever reads them.
constexpr NumberRange kFrameRatesHz{1e-3, 1e9};
constexpr NumberRange kTimeLimitSeconds{1e-3, 1e9};
/// Simulations at once.
constexpr IntegerRange kProcesses{1, 4096};
/// Further values that a search looks at.
constexpr IntegerRange kChecks{0, 1'000'000};

}  // namespace metabuffer
