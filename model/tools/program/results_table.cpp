#include "tools/program/results_table.h"

#include <vector>

#include "tools/exploration/expression.h"

namespace metabuffer {

exploration::ResultsReader::Table results_table(const exploration::ResultsReader& reader,
                                                const std::string& where, const std::string& columns) {
    // Checked here for the sake of the option's name in the message.
    if (!where.empty()) exploration::sql_expression(where, reader.columns(), "--where");
    if (columns.empty()) return reader.results(where);
    const std::vector<std::string> expressions = exploration::split_expressions(columns);
    for (const std::string& expression : expressions) {
        exploration::sql_expression(expression, reader.columns(), "--columns");
    }
    return reader.results(expressions, where);
}

}  // namespace metabuffer
