#include "tools/exploration/table_text.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>
#include <variant>

#include "host/text.h"
#include "tools/exploration/value_json.h"

namespace metabuffer::exploration {

namespace {

using OrderedJson = nlohmann::ordered_json;

std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    return text::literal(text, '"');
}

/// A text that no spreadsheet takes for a formula to run.
std::string harmless(const std::string& text) {
    constexpr std::string_view kBeginFormulas = "=+-@\t\r";
    const bool is_formula = !text.empty() && kBeginFormulas.find(text.front()) != std::string_view::npos;
    return is_formula ? "'" + text : text;
}

/// Numbers keep their signs: only texts are made harmless.
std::string csv_value(const Value& value) {
    return std::holds_alternative<std::string>(value) ? harmless(text_of(value)) : text_of(value);
}

std::string csv_line(const std::vector<std::string>& texts) {
    // An empty line would not be a row.
    if (texts.size() == 1 && texts.front().empty()) return "\"\"\r\n";
    std::string line;
    for (std::size_t n = 0; n < texts.size(); ++n) line += (n == 0 ? "" : ",") + csv_field(texts[n]);
    return line + "\r\n";
}

}  // namespace

TableText::TableText(TableFormat format, std::vector<std::string> columns, Sink sink)
    : format_(format), columns_(std::move(columns)), sink_(std::move(sink)) {
    if (format_ == TableFormat::kJson) {
        sink_("[");
        return;
    }
    std::vector<std::string> names(columns_.size());
    std::transform(columns_.begin(), columns_.end(), names.begin(), harmless);
    sink_(csv_line(names));
}

void TableText::add(const std::vector<Value>& row) {
    if (format_ == TableFormat::kCsv) {
        std::vector<std::string> texts(row.size());
        std::transform(row.begin(), row.end(), texts.begin(), csv_value);
        sink_(csv_line(texts));
        return;
    }
    OrderedJson object = OrderedJson::object();
    for (std::size_t n = 0; n < row.size(); ++n) object[columns_[n]] = json_of<OrderedJson>(row[n]);
    sink_((has_rows_ ? ",\n" : "\n") + object.dump(-1, ' ', false, OrderedJson::error_handler_t::replace));
    has_rows_ = true;
}

void TableText::end() {
    if (format_ == TableFormat::kJson) sink_("\n]\n");
}

}  // namespace metabuffer::exploration
