#pragma once

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// The value in a column; bytes become a text.
inline Value value_of(const SQLite::Column& column) {
    if (column.isNull()) return {};
    if (column.isInteger()) return column.getInt64();
    if (column.isFloat()) return column.getDouble();
    return column.getString();
}

/// Binds a copy of a value to a parameter; the first has number 1.
inline void bind_value(SQLite::Statement& statement, int parameter, const Value& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) {
        statement.bind(parameter, *whole);
    } else if (const auto* number = std::get_if<double>(&value)) {
        statement.bind(parameter, *number);
    } else if (const auto* words = std::get_if<std::string>(&value)) {
        statement.bind(parameter, *words);
    } else {
        statement.bind(parameter);
    }
}

/// Resets a statement when its use ends, however it ends.
class StatementReset {
  public:
    explicit StatementReset(SQLite::Statement& statement) : statement_(statement) {}
    StatementReset(const StatementReset&) = delete;
    StatementReset& operator=(const StatementReset&) = delete;
    ~StatementReset() { statement_.tryReset(); }

  private:
    SQLite::Statement& statement_;
};

}  // namespace metabuffer::exploration
