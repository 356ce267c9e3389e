#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace metabuffer {

/// Characters that a UTF-8 text needs on the screen: its bytes without those that continue a character.
std::size_t screen_width(const std::string& text);

/// Text in columns as wide as their widest cell, for a terminal. Numbers are aligned to the right.
class TextTable {
  public:
    /// Which columns are aligned to the left; the others are aligned to the right.
    explicit TextTable(std::vector<std::size_t> left_columns = {0})
        : left_columns_(std::move(left_columns)) {}

    void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
    bool empty() const { return rows_.empty(); }
    /// Its lines, two spaces before each column.
    std::string text() const;

  private:
    std::vector<std::size_t> left_columns_;
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace metabuffer
