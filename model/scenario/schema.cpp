#include "scenario/schema.h"

#include <algorithm>
#include <utility>

#include "host/text.h"

namespace metabuffer {
namespace {

bool ends_with(std::string_view text, std::string_view end) {
    return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

/// The last key of a pattern, empty for a list's entry.
std::string_view last_key(std::string_view pattern) {
    if (ends_with(pattern, "[]")) return {};
    const std::size_t dot = pattern.rfind('.');
    return dot == std::string_view::npos ? pattern : pattern.substr(dot + 1);
}

/// The map that a pattern's key is in: "" for the keys at the top.
std::string_view enclosing_map(std::string_view pattern) {
    const std::size_t dot = pattern.rfind('.');
    return dot == std::string_view::npos ? std::string_view() : pattern.substr(0, dot);
}

}  // namespace

std::string value_text(const KeyValue& value) {
    struct Text {
        std::string operator()(std::int64_t number) const { return std::to_string(number); }
        std::string operator()(double number) const { return text::number(number); }
        std::string operator()(const std::string& words) const { return words; }
        std::string operator()(const std::vector<double>& numbers) const {
            std::string list;
            for (const double number : numbers) list += (list.empty() ? "" : ", ") + text::number(number);
            return "[" + list + "]";
        }
    };
    return std::visit(Text{}, value);
}

ValueRule ValueRule::whole_numbers(const IntegerRange& range) {
    ValueRule rule;
    rule.type = Type::kWholeNumber;
    rule.whole = range;
    return rule;
}

ValueRule ValueRule::one_of(std::vector<std::int64_t> values, const char* what) {
    ValueRule rule = whole_numbers({values.front(), values.back()});
    rule.only = std::move(values);
    rule.what = what;
    return rule;
}

ValueRule ValueRule::numbers(const NumberRange& range) {
    ValueRule rule;
    rule.type = Type::kNumber;
    rule.number = range;
    return rule;
}

std::string ValueRule::allowed() const {
    switch (type) {
        case Type::kAny:
        case Type::kText:
            break;
        case Type::kWholeNumber: {
            if (only.empty()) return text::range(whole);
            std::vector<std::string> names;
            for (const std::int64_t value : only) names.push_back(std::to_string(value));
            return text::joined(names, "or");
        }
        case Type::kNumber:
            return text::range(number);
        case Type::kChoice:
            return text::joined(choices, "or");
    }
    return "";
}

std::string ValueRule::complaint(const KeyValue& value) const {
    switch (type) {
        case Type::kAny:
        case Type::kText:
        case Type::kChoice:  // an enumerator cannot be wrong
            break;
        case Type::kWholeNumber: {
            const auto whole_number = std::get<std::int64_t>(value);
            if (only.empty()) {
                return whole.contains(whole_number) ? "" : text::out_of_range(whole_number, whole);
            }
            if (std::find(only.begin(), only.end(), whole_number) != only.end()) return "";
            return std::to_string(whole_number) + " is not " + what + "; use " + allowed();
        }
        case Type::kNumber: {
            const auto any_number = std::get<double>(value);
            return number.contains(any_number) ? "" : text::out_of_range(any_number, number);
        }
    }
    return "";
}

Schema::Schema(std::string empty_message, std::vector<SchemaKey> keys)
    : empty_message_(std::move(empty_message)), keys_(std::move(keys)) {
    for (std::size_t i = 0; i < keys_.size(); ++i) index_.emplace(keys_[i].pattern, i);
}

const SchemaKey* Schema::find(std::string_view pattern) const {
    const auto found = index_.find(pattern);
    return found == index_.end() ? nullptr : &keys_[found->second];
}

bool Schema::is_key_of(std::string_view map_pattern, std::string_view key) const {
    // A key with a dot in it would otherwise be taken for a path.
    return !key.empty() && key.find_first_of(".[]") == std::string_view::npos &&
           find(key_pattern(map_pattern, key)) != nullptr;
}

std::vector<std::string> Schema::keys_of(std::string_view map_pattern) const {
    std::vector<std::string> keys;
    for (const SchemaKey& key : keys_) {
        const std::string_view pattern = key.pattern;
        if (!last_key(pattern).empty() && enclosing_map(pattern) == map_pattern) {
            keys.emplace_back(last_key(pattern));
        }
    }
    return keys;
}

std::vector<std::string> Schema::paths() const {
    std::vector<std::string> paths;
    for (const SchemaKey& key : keys_) {
        if (!last_key(key.pattern).empty()) paths.emplace_back(key.pattern);
    }
    return paths;
}

std::string Schema::nearest_key(std::string_view map_pattern, std::string_view map_path,
                                std::string_view key) const {
    constexpr int kSlip = 2;  // edits that still count as a typing error
    const std::string sibling = text::nearest(key.substr(0, key.find('.')), keys_of(map_pattern));
    if (text::edit_distance(key, sibling) > kSlip && !key.empty()) {
        for (const SchemaKey& elsewhere : keys_) {
            if (last_key(elsewhere.pattern) == key) return elsewhere.pattern;
        }
    }
    return key_pattern(map_path, sibling);
}

std::string key_pattern(std::string_view map_pattern, std::string_view key) {
    return map_pattern.empty() ? std::string(key) : std::string(map_pattern) + "." + std::string(key);
}

std::string item_path(const std::string& list_path, std::size_t index) {
    return list_path + "[" + std::to_string(index) + "]";
}

}  // namespace metabuffer
