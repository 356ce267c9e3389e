#include "tools/program/watchdog_lines.h"

namespace metabuffer {

std::string watchdog_lines(const std::string& scenario_file, const RunReport& report) {
    if (report.watchdog.empty()) return "";
    std::string text = scenario_file + ": the watchdog ended the run: nothing moves any more\n";
    for (const std::string& finding : report.watchdog) text += "  " + finding + '\n';
    return text;
}

}  // namespace metabuffer
