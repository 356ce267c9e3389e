#pragma once

#include "coverage.h"
#include "report/report.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

/// Counts what the scenario and the report of a run at level rtl, which has ended, tell of it: modes, clocks, tables
/// and segments of the frames composited, pacing, faults. What only its wires tell is MachineCoverage's.
void cover_run(Coverage& coverage, const Scenario& scenario, const RunReport& report);

}  // namespace metabuffer::coverage
