#include "tools/exploration/value.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <memory>
#include <system_error>

#include "host/text.h"
#include "scenario/yaml_reader.h"

namespace metabuffer::exploration {

Value value_of(std::string_view text) {
    if (text.empty()) return {};
    const char* const end = text.data() + text.size();
    std::int64_t whole = 0;
    const auto whole_end = std::from_chars(text.data(), end, whole);
    if (whole_end.ec == std::errc() && whole_end.ptr == end) return whole;
    // Words that stand for numbers, "inf" and "nan", are texts here.
    const bool is_word = std::isalpha(static_cast<unsigned char>(text.front())) != 0;
    double number = 0.0;
    const auto number_end = std::from_chars(text.data(), end, number);
    if (!is_word && number_end.ec == std::errc() && number_end.ptr == end && std::isfinite(number))
        return number;
    return std::string(text);
}

Value value_of_setting(const std::string& flow) {
    const bool is_quoted = !flow.empty() && (flow.front() == '\'' || flow.front() == '"');
    if (is_quoted) {
        const input::Value scalar =
            input::parse_yaml(flow, std::make_shared<const std::string>("a setting"), false);
        return scalar.text;
    }
    const bool has_plus =
        flow.size() > 1 && flow.front() == '+' && std::isdigit(static_cast<unsigned char>(flow[1])) != 0;
    return value_of(has_plus ? std::string_view(flow).substr(1) : std::string_view(flow));
}

std::string text_of(const Value& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
    if (const auto* number = std::get_if<double>(&value)) return text::number(*number);
    if (const auto* words = std::get_if<std::string>(&value)) return *words;
    return {};
}

}  // namespace metabuffer::exploration
