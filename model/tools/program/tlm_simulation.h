#pragma once

#include "tools/exploration/run_process.h"

namespace metabuffer {

/// A run at level tlm as explorations want it. Throws std::runtime_error, one line, if the model is at fault.
exploration::Simulation simulate_by_transactions(const Scenario& scenario, bool pictures);

}  // namespace metabuffer
