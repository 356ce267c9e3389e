#pragma once

#include <string>
#include <vector>

#include "tools/exploration/results_database.h"

namespace metabuffer {

/// The columns of a table of results: what they are called, and the expressions that they hold.
struct TableColumns {
    std::vector<std::string> names;
    std::vector<std::string> expressions;
};

/// What `metabuffer export` makes of results. where: an expression, empty for all points; columns: expressions with
/// commas in between, empty for all columns, without those that depend on when and where a point ran unless
/// `bookkeeping` wants them. Throws InputError, which begins with the option's name.
TableColumns table_columns(const exploration::ResultsReader& reader, const std::string& where,
                           const std::string& columns, bool bookkeeping);

/// The table itself, bookkeeping included.
exploration::ResultsReader::Table results_table(const exploration::ResultsReader& reader,
                                                const std::string& where, const std::string& columns);

}  // namespace metabuffer
