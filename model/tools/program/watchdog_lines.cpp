#include "tools/program/watchdog_lines.h"

#include <iostream>

namespace metabuffer {

bool print_watchdog(const std::string& scenario_file, const RunReport& report) {
    if (report.watchdog.empty()) return false;
    std::cerr << scenario_file << ": the watchdog ended the run: nothing moves any more\n";
    for (const std::string& finding : report.watchdog) std::cerr << "  " << finding << '\n';
    return true;
}

}  // namespace metabuffer
