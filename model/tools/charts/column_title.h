#pragma once

#include <string>

#include "tools/exploration/results_database.h"

namespace metabuffer::charts {

/// The title that a chart gives to a column of the results, or to an expression over them. It has the unit, unless the
/// name says it: "latency cycles (clocks)", "frames per second", "smallest composer.buffer_pixels". Settings keep their
/// keys.
std::string column_title(const std::string& expression, const exploration::ResultsIdentity& identity);

/// The unit of a column of the results, as figure_kinds() has it: "clocks"; empty if it has none.
std::string column_unit(const std::string& column);

/// Whether a column or an expression is a share, which charts show in percent.
bool is_share(const std::string& expression);

}  // namespace metabuffer::charts
