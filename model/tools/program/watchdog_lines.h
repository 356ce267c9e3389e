#pragma once

#include <string>

#include "report/report.h"

namespace metabuffer {

/// A line that says that the watchdog ended the run, and lines that say what waited for what. Empty if it did not end
/// the run.
std::string watchdog_lines(const std::string& scenario_file, const RunReport& report);

}  // namespace metabuffer
