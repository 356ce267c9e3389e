#pragma once

#include <string>
#include <vector>

#include "tools/exploration/results_database.h"

namespace metabuffer {

/// The columns of a table of results: their names and their expressions.
struct TableColumns {
    std::vector<std::string> names;
    std::vector<std::string> expressions;
};

/// The columns that `metabuffer export` writes. `where`: an expression, empty for all points. `columns`: expressions
/// with commas in between, or empty for all columns. Among these are those that depend on when and where a point ran
/// only if `bookkeeping` is true. Throws InputError, which begins with the option's name.
TableColumns table_columns(const exploration::ResultsReader& reader, const std::string& where,
                           const std::string& columns, bool bookkeeping);

/// The table itself, with all columns if `columns` is empty.
exploration::ResultsReader::Table results_table(const exploration::ResultsReader& reader,
                                                const std::string& where, const std::string& columns);

}  // namespace metabuffer
