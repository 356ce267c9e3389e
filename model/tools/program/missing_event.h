#pragma once

#include <string>

#include "scenario/scenario.h"
#include "simulation/trace_window.h"

namespace metabuffer {

/// Why a window's event does not happen in a run that came to its end, and with which setting it does, as far as a run of
/// level tlm has shown. Call it before this process elaborates anything.
std::string missing_event_text(const Scenario& scenario, const TraceWindow& window);

}  // namespace metabuffer
