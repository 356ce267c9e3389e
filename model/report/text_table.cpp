#include "report/text_table.h"

#include <algorithm>

namespace metabuffer {

std::size_t screen_width(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char byte) {
        return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
    }));
}

std::string TextTable::text() const {
    std::vector<std::size_t> widths;
    for (const auto& row : rows_) {
        widths.resize(std::max(widths.size(), row.size()));
        for (std::size_t n = 0; n < row.size(); ++n) widths[n] = std::max(widths[n], screen_width(row[n]));
    }
    std::string result;
    for (const auto& row : rows_) {
        std::string line;
        for (std::size_t n = 0; n < row.size(); ++n) {
            const std::string padding(widths[n] - screen_width(row[n]), ' ');
            const bool is_left =
                std::find(left_columns_.begin(), left_columns_.end(), n) != left_columns_.end();
            line += "  ";
            line += is_left ? row[n] + padding : padding + row[n];
        }
        line.erase(line.find_last_not_of(' ') + 1);
        result += line + '\n';
    }
    return result;
}

}  // namespace metabuffer
