#pragma once

#include <string>

#include "report/report.h"

namespace metabuffer {

/// That the watchdog ended the run, and what waited for what, a line each. Empty: it did not end it.
std::string watchdog_lines(const std::string& scenario_file, const RunReport& report);

}  // namespace metabuffer
