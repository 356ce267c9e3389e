#pragma once

#include <string>

#include "tools/exploration/results_database.h"

namespace metabuffer {

/// What `metabuffer export` makes of results. where: an expression, empty for all points; columns: expressions with
/// commas in between, empty for all columns. Throws InputError, which begins with the option's name.
exploration::ResultsReader::Table results_table(const exploration::ResultsReader& reader,
                                                const std::string& where, const std::string& columns);

}  // namespace metabuffer
