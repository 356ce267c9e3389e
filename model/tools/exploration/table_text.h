#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/exploration/value.h"

namespace metabuffer::exploration {

enum class TableFormat {
    kCsv,   ///< RFC 4180, with the columns' names first; nothing is an empty field
    kJson,  ///< an array with an object for each row; nothing is null; bytes that are not UTF-8 are replaced
};

/// Writes a table row by row.
class TableText {
  public:
    using Sink = std::function<void(std::string_view)>;

    /// Begins the table.
    TableText(TableFormat format, std::vector<std::string> columns, Sink sink);
    void add(const std::vector<Value>& row);
    /// After the last row.
    void end();

  private:
    TableFormat format_;
    std::vector<std::string> columns_;
    Sink sink_;
    bool has_rows_ = false;
};

}  // namespace metabuffer::exploration
