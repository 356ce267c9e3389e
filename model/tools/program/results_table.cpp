#include "tools/program/results_table.h"

#include <algorithm>
#include <iterator>

#include "tools/exploration/expression.h"

namespace metabuffer {

TableColumns table_columns(const exploration::ResultsReader& reader, const std::string& where,
                           const std::string& columns, bool bookkeeping) {
    // Checked here so that the message names the option.
    if (!where.empty()) exploration::sql_expression(where, reader.columns(), "--where");
    TableColumns table;
    if (columns.empty()) {
        table.names = bookkeeping ? reader.columns() : reader.lasting_columns();
        std::transform(table.names.begin(), table.names.end(), std::back_inserter(table.expressions),
                       exploration::quoted_name);
        return table;
    }
    table.names = exploration::split_expressions(columns);
    for (const std::string& expression : table.names) {
        exploration::sql_expression(expression, reader.columns(), "--columns");
    }
    table.expressions = table.names;
    return table;
}

exploration::ResultsReader::Table results_table(const exploration::ResultsReader& reader,
                                                const std::string& where, const std::string& columns) {
    TableColumns table = table_columns(reader, where, columns, true);
    return {std::move(table.names), reader.results(table.expressions, where).rows};
}

}  // namespace metabuffer
