#pragma once

#include <string>

#include "report/report.h"

namespace metabuffer {

/// Says on standard error that the watchdog ended the run, and what waited for what. False: it did not end it.
bool print_watchdog(const std::string& scenario_file, const RunReport& report);

}  // namespace metabuffer
