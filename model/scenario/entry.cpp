#include "scenario/entry.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "host/text.h"

namespace metabuffer::input {
namespace {

/// Whether the text is a sign and decimal digits and nothing else.
bool looks_whole(const std::string& text) {
    const std::size_t first = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
    return first < text.size() &&
           std::all_of(text.begin() + static_cast<std::ptrdiff_t>(first), text.end(), text::is_digit);
}

bool has_leading_zero(const std::string& text) {
    const std::size_t first = text[0] == '-' || text[0] == '+' ? 1 : 0;
    return text.size() > first + 1 && text[first] == '0';
}

}  // namespace

Entry Entry::child(const std::string& key) const {
    std::string pattern = key_pattern(pattern_, key);
    if (schema_->find(pattern) == nullptr) throw std::logic_error("no such key: " + pattern);
    const Value* value = value_ == nullptr ? nullptr : value_->find(key);
    return {schema_, value, key_pattern(path_, key), std::move(pattern),
            value == nullptr ? location_ : value->location};
}

Entry Entry::at(std::string_view path) const {
    const std::size_t dot = path.find('.');
    const Entry inner = child(std::string(path.substr(0, dot)));
    return dot == std::string_view::npos ? inner : inner.at(path.substr(dot + 1));
}

std::vector<Entry> Entry::items() const {
    std::vector<Entry> entries;
    if (value_ == nullptr) return entries;
    if (value_->kind == ValueKind::kScalar && schema_->find(pattern_)->may_be_one) {
        return {Entry(schema_, value_, path_, pattern_ + "[]", location_)};
    }
    entries.reserve(value_->items.size());
    for (std::size_t i = 0; i < value_->items.size(); ++i) {
        const Value& item = value_->items[i];
        entries.push_back(Entry(schema_, &item, item_path(path_, i), pattern_ + "[]", item.location));
    }
    return entries;
}

std::vector<std::pair<std::string, Entry>> Entry::members() const {
    std::vector<std::pair<std::string, Entry>> entries;
    if (value_ == nullptr) return entries;
    entries.reserve(value_->members.size());
    for (const Member& member : value_->members) {
        entries.emplace_back(member.key, Entry(schema_, &member.value, key_pattern(path_, member.key),
                                               pattern_ + "[]", member.location));
    }
    return entries;
}

std::string Entry::where() const {
    return text::one_line(location_.describe() + (path_.empty() ? "" : ": " + path_));
}

void Entry::fail(const std::string& message) const { location_.fail(path_, message); }

const std::string& Entry::scalar(const std::string& use) const {
    if (value_ == nullptr) fail("is missing; use " + use);
    if (value_->kind != ValueKind::kScalar) fail("is " + described(*value_) + "; use " + use);
    return value_->text;
}

std::int64_t Entry::whole_number(const std::string& use) const {
    const std::string& digits = scalar(use);
    if (!looks_whole(digits) || value_->quoted) {
        const char* without = value_->quoted && looks_whole(digits) ? " without quotation marks" : "";
        fail(described(*value_) + " is not a whole number; use " + use + without);
    }
    if (has_leading_zero(digits)) {
        fail(described(*value_) + " has a leading zero; use " + use + ", in decimal digits");
    }
    std::int64_t value = 0;
    const auto [stop, error] =
        std::from_chars(text::after_plus(digits), digits.data() + digits.size(), value);
    if (error != std::errc()) fail(text::one_line(digits) + " is out of range; use " + use);
    return value;
}

std::int64_t Entry::integer(const IntegerRange& allowed) const {
    return std::get<std::int64_t>(value(ValueRule::whole_numbers(allowed)));
}

double Entry::number(const NumberRange& allowed) const {
    const std::string use = text::range(allowed);
    const std::string& digits = scalar(use);
    const std::optional<double> value = text::decimal_number(digits);
    if (!value.has_value() || value_->quoted) {
        fail(described(*value_) + " is not a finite decimal number; use " + use);
    }
    if (!allowed.contains(*value)) fail(text::one_line(digits) + " is out of range; use " + use);
    return *value;
}

std::string Entry::name() const {
    const std::string use = std::string(schema_->find(pattern_)->meaning) + ", on one line";
    const std::string& words = scalar(use);
    if (words.empty()) fail("is empty; use " + use);
    if (text::has_control(words)) fail(described(*value_) + " has control characters; use " + use);
    return words;
}

std::string Entry::line() const {
    const std::string use = schema_->find(pattern_)->meaning;
    std::string words = text::one_line(scalar(use));
    if (words.empty()) fail("is empty; use " + use);
    return words;
}

bool Entry::boolean() const { return choice({"true", "false"}, "true or false") == "true"; }

std::string Entry::flow() const {
    if (value_ == nullptr || value_->kind == ValueKind::kNothing) {
        fail(std::string("is ") + (value_ == nullptr ? "missing" : "nothing") + "; use " +
             schema_->find(pattern_)->meaning);
    }
    return flow_text(*value_);
}

KeyValue Entry::value() const {
    const SchemaKey& key = *schema_->find(pattern_);
    return key.length > 0 ? KeyValue(numbers(key)) : value(key.rule);
}

std::vector<double> Entry::numbers(const SchemaKey& key) const {
    const std::vector<Entry> entries = items();
    if (entries.size() != key.length) {
        const std::string_view list = "a list of ";
        fail("has " + std::to_string(entries.size()) + " entries; use " + (key.meaning + list.size()));
    }
    std::vector<double> values;
    for (const Entry& entry : entries) {
        const KeyValue value = entry.value();
        const auto* const whole = std::get_if<std::int64_t>(&value);
        values.push_back(whole != nullptr ? static_cast<double>(*whole) : std::get<double>(value));
    }
    return values;
}

KeyValue Entry::value(const ValueRule& rule) const {
    switch (rule.type) {
        case ValueRule::Type::kAny:
            break;
        case ValueRule::Type::kWholeNumber: {
            const std::int64_t value = whole_number(rule.allowed());
            if (const std::string complaint = rule.complaint(value); !complaint.empty()) fail(complaint);
            return value;
        }
        case ValueRule::Type::kNumber:
            return number(rule.number);
        case ValueRule::Type::kChoice:
            return choice(rule.choices, rule.what);
        case ValueRule::Type::kText:
            return name();
    }
    throw std::logic_error("no rule for the values of " + pattern_);
}

std::string Entry::choice(const std::vector<std::string>& allowed, const std::string& what) const {
    const std::string use = text::joined(allowed, "or");
    const std::string& word = scalar(use);
    if (std::find(allowed.begin(), allowed.end(), word) == allowed.end()) {
        fail(described(*value_) + " is not " + what + "; use " + use);
    }
    return word;
}

}  // namespace metabuffer::input
