#include "scenario/yaml_reader.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <unordered_map>
#include <utility>

namespace metabuffer::input {
namespace {

// Aliases are written out, so that a few lines could make an endless tree.
constexpr int kDeepestNesting = 64;
constexpr std::size_t kMostValues = 4'000'000;
constexpr std::size_t kMostTextBytes = std::size_t{512} << 20U;

[[noreturn]] void fail_at(const SourceLocation& location, const std::string& path,
                          const std::string& message) {
    throw InputError(text::located(location.describe(), text::located(path, message)));
}

std::string item_path(const std::string& list_path, std::size_t index) {
    return list_path + "[" + std::to_string(index) + "]";
}

/// Copies yaml-cpp's nodes into values.
class TreeBuilder {
  public:
    TreeBuilder(std::shared_ptr<const std::string> origin, bool has_lines)
        : origin_(std::move(origin)), has_lines_(has_lines) {}

    SourceLocation location(const YAML::Mark& mark) const {
        return {origin_, has_lines_ ? std::max(mark.line, 0) + 1 : 0};
    }

    Value build(const YAML::Node& node, const SourceLocation& key_location, int depth) {
        if (depth > kDeepestNesting || ++values_ > kMostValues) {
            fail_at(key_location, "", "is nested without end; use aliases only for what they do not contain");
        }
        if (node.IsScalar()) text_bytes_ += node.Scalar().size();
        if (text_bytes_ > kMostTextBytes) {
            fail_at(key_location, "",
                    "has more than " + std::to_string(kMostTextBytes >> 20U) +
                        " MiB of text, aliases written out; use shorter texts");
        }
        Value value;
        value.location = key_location;
        switch (node.Type()) {
            case YAML::NodeType::Undefined:
            case YAML::NodeType::Null:
                break;
            case YAML::NodeType::Scalar:
                value.kind = ValueKind::kScalar;
                value.location = location(node.Mark());
                value.text = node.Scalar();
                value.quoted = node.Tag() == "!";
                break;
            case YAML::NodeType::Sequence:
                value.kind = ValueKind::kList;
                for (const YAML::Node& item : node) {
                    value.items.push_back(build(item, location(item.Mark()), depth + 1));
                }
                break;
            case YAML::NodeType::Map:
                value.kind = ValueKind::kMap;
                add_members(value, node, depth);
                break;
        }
        return value;
    }

  private:
    void add_members(Value& map, const YAML::Node& node, int depth) {
        std::unordered_map<std::string, int> lines;  ///< of the keys so far
        std::vector<Member> merged;
        for (const auto& member : node) {
            const YAML::Node& key = member.first;
            const SourceLocation key_location = location(key.Mark());
            if (!key.IsScalar()) fail_at(key_location, "", "a key is not plain text; use the name of a key");
            const std::string& name = key.Scalar();
            const bool merges = name == "<<" && key.Tag() != "!";
            const auto [earlier, is_new] = lines.emplace(name, key_location.line);
            if (!is_new) {
                const std::string where =
                    has_lines_ ? " on line " + std::to_string(earlier->second) : std::string(" already");
                fail_at(key_location, name, "is here twice, first" + where + "; use each key once in a map");
            }
            Value value = build(member.second, key_location, depth + 1);
            if (merges) {
                add_merged(merged, std::move(value));
            } else {
                map.members.push_back({key_location, name, std::move(value)});
            }
        }
        // What the map has itself comes first, then what earlier maps have.
        for (Member& member : merged) {
            if (lines.emplace(member.key, member.location.line).second)
                map.members.push_back(std::move(member));
        }
    }
    /// Of a merge key, `<<`: members of the map, or of each map of the list.
    static void add_merged(std::vector<Member>& members, Value value) {
        if (value.kind == ValueKind::kList) {
            for (Value& map : value.items) add_map(members, std::move(map));
        } else {
            add_map(members, std::move(value));
        }
    }
    static void add_map(std::vector<Member>& members, Value map) {
        if (map.kind != ValueKind::kMap) {
            fail_at(map.location, "<<",
                    "is " + described(map) + "; use a map with an anchor, such as *frame, or a list of them");
        }
        std::move(map.members.begin(), map.members.end(), std::back_inserter(members));
    }

    std::shared_ptr<const std::string> origin_;
    bool has_lines_;
    std::size_t values_ = 0;
    std::size_t text_bytes_ = 0;
};

/// Notes where a document starts and ignores everything else.
class DocumentStarts final : public YAML::EventHandler {
  public:
    void OnDocumentStart(const YAML::Mark& mark) override { last_ = mark; }
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
    void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
    void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  const std::string& /*value*/) override {}
    void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                         YAML::EmitterStyle::value /*style*/) override {}
    void OnSequenceEnd() override {}
    void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                    YAML::EmitterStyle::value /*style*/) override {}
    void OnMapEnd() override {}

    const YAML::Mark& last() const { return last_; }

  private:
    YAML::Mark last_;
};

/// Where a second document starts, if there is one. YAML::LoadAll never returns from a stray comma: the
/// parser makes one empty document after another of it.
std::optional<YAML::Mark> second_document(const std::string& text) {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    DocumentStarts starts;
    if (!parser.HandleNextDocument(starts) || !parser.HandleNextDocument(starts)) return std::nullopt;
    return starts.last();
}

/// One step of a key path as it is written: `frames`, `0` or `[0]`.
struct Step {
    std::string word;
    bool bracketed = false;
};

/// The steps of "renderers[0].frames.1.image"; nothing if the brackets do not match or a step is empty.
std::optional<std::vector<Step>> split_path(const std::string& path) {
    std::vector<Step> steps;
    std::size_t at = 0;
    while (at <= path.size()) {
        const bool bracketed = at < path.size() && path[at] == '[';
        std::size_t end = 0;
        if (bracketed) {
            end = path.find(']', ++at);
            if (end == std::string::npos || steps.empty()) return std::nullopt;
        } else {
            end = std::min(path.find_first_of(".[", at), path.size());
        }
        if (end == at) return std::nullopt;
        steps.push_back({path.substr(at, end - at), bracketed});
        at = bracketed ? end + 1 : end;
        if (at == path.size()) return steps;
        if (path[at] == '.') {
            ++at;
        } else if (path[at] != '[') {
            return std::nullopt;
        }
    }
    return std::nullopt;
}

std::optional<std::size_t> index_of(const std::string& word) {
    std::size_t index = 0;
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, index);
    if (error != std::errc() || stop != end) return std::nullopt;
    return index;
}

[[noreturn]] void fail_shape(const Schema& schema, const Value& value, const std::string& path,
                             const SchemaKey& key) {
    std::string use = key.meaning;
    if (key.shape == KeyShape::kMap) {
        use += " with the keys " + text::joined(schema.keys_of(key.pattern), "and");
    }
    if (path.empty() && value.kind == ValueKind::kNothing)
        fail_at(value.location, path, schema.empty_message());
    fail_at(value.location, path, "is " + described(value) + "; use " + use);
}

std::string unknown_key(const Schema& schema, const SchemaKey& map, const std::string& map_path,
                        const std::string& key) {
    return "is not a known key; the nearest is " + schema.nearest_key(map.pattern, map_path, key);
}

void check_structure_of(const Schema& schema, const Value& value, const std::string& pattern,
                        const std::string& path) {
    const SchemaKey& key = *schema.find(pattern);
    switch (key.shape) {
        case KeyShape::kScalar:
        case KeyShape::kAny:
            break;  // the reader of the value reports better what it should be
        case KeyShape::kMap:
        case KeyShape::kFreeMap: {
            if (value.kind != ValueKind::kMap) fail_shape(schema, value, path, key);
            const bool is_free = key.shape == KeyShape::kFreeMap;
            for (const Member& member : value.members) {
                const std::string member_path = key_pattern(path, member.key);
                if (!is_free && !schema.is_key_of(pattern, member.key)) {
                    fail_at(member.location, member_path, unknown_key(schema, key, path, member.key));
                }
                check_structure_of(schema, member.value,
                                   is_free ? pattern + "[]" : key_pattern(pattern, member.key), member_path);
            }
            break;
        }
        case KeyShape::kList:
            if (key.may_be_one && value.kind == ValueKind::kScalar) break;
            if (value.kind != ValueKind::kList) fail_shape(schema, value, path, key);
            for (std::size_t i = 0; i < value.items.size(); ++i) {
                check_structure_of(schema, value.items[i], pattern + "[]", item_path(path, i));
            }
            break;
    }
}

/// The value of a map's key, which is made if it is not there.
Value& member_of(Value& map, const std::string& key, const SourceLocation& location) {
    map.kind = ValueKind::kMap;
    for (Member& member : map.members) {
        if (member.key == key) return member.value;
    }
    map.members.push_back({location, key, {}});
    map.members.back().value.location = location;
    return map.members.back().value;
}

std::vector<Step> steps_of(const std::string& path, const SourceLocation& location) {
    std::optional<std::vector<Step>> steps = split_path(path);
    if (steps.has_value()) return *std::move(steps);
    fail_at(location, "",
            text::quoted(path) +
                " is not a key path; use keys and indices with dots, like renderers.0.frames.1.viewport.x");
}

/// Follows a key path down the schema. `value` is null, or for an override the root of its tree: it then becomes what
/// the path names, and maps on the way are made. Errors begin with the location.
KeyPath follow(const std::vector<Step>& steps, const Schema& schema, const SourceLocation& location,
               Value*& value) {
    KeyPath found;
    for (const Step& step : steps) {
        const SchemaKey& key = *schema.find(found.pattern);
        const bool is_map = key.shape == KeyShape::kMap;
        if (!is_map && key.shape != KeyShape::kList) {
            const std::string use = value == nullptr ? found.path : "--set " + found.path + "=VALUE";
            fail_at(location, found.path, "has nothing inside; use " + use);
        }
        if (is_map && (step.bracketed || !schema.is_key_of(found.pattern, step.word))) {
            fail_at(location, key_pattern(found.path, step.word),
                    unknown_key(schema, key, found.path, step.word));
        }
        if (value != nullptr && value->kind != ValueKind::kNothing &&
            value->kind != (is_map ? ValueKind::kMap : ValueKind::kList)) {
            fail_shape(schema, *value, found.path, key);
        }
        if (is_map) {
            if (value != nullptr) value = &member_of(*value, step.word, location);
            found = {key_pattern(found.path, step.word), key_pattern(found.pattern, step.word)};
            continue;
        }
        std::string use = "use an index of " + found.path + ", ";
        if (value == nullptr) {
            use += "from 0";
        } else if (value->items.empty()) {
            use = found.path + " has no entries to override; use the whole list as the value";
        } else {
            use += "0 to " + std::to_string(value->items.size() - 1);
        }
        const std::optional<std::size_t> index = index_of(step.word);
        if (!index.has_value()) {
            fail_at(location, found.path, text::quoted(step.word) + " is not an index; " + use);
        }
        found = {item_path(found.path, *index), found.pattern + "[]"};
        if (value == nullptr) continue;
        if (*index >= value->items.size()) fail_at(location, found.path, "is out of range; " + use);
        value = &value->items[*index];
    }
    return found;
}

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

/// from_chars accepts no plus sign.
const char* after_plus(const std::string& text) { return text.data() + (text[0] == '+' ? 1 : 0); }

/// A decimal number, also `.5`, `5.` and `1e3`; not hexadecimal, not inf or nan.
std::optional<double> decimal_number(const std::string& text) {
    const bool allowed = !text.empty() && std::all_of(text.begin(), text.end(), [](char character) {
        return text::is_digit(character) ||
               std::string_view("+-.eE").find(character) != std::string_view::npos;
    });
    if (!allowed) return std::nullopt;
    const char* begin = after_plus(text);
    const char* end = text.data() + text.size();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(begin, end, value);
    const bool signs_twice = begin != text.data() && begin != end && *begin == '-';
    if (stop != end || signs_twice || error != std::errc()) return std::nullopt;
    return value;
}

bool is_letter(char character) {
    return (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z');
}

/// Whether the text means just itself in YAML wherever it stands. May be false for some texts that do.
bool is_plain(const std::string& text) {
    const bool simple = !text.empty() && std::all_of(text.begin(), text.end(), [](char character) {
        return is_letter(character) || text::is_digit(character) ||
               std::string_view("_-+./").find(character) != std::string_view::npos;
    });
    const std::size_t first = simple && (text[0] == '-' || text[0] == '+') ? 1 : 0;
    if (!simple || first == text.size()) return false;
    const bool is_path = text[0] == '.' && text.find('/') != std::string::npos;
    return (is_path || is_letter(text[first]) || text::is_digit(text[first])) && text != "null" &&
           text != "Null" && text != "NULL";
}

/// A scalar in flow style. A text that is not a number only because of its quotation marks keeps them.
std::string scalar_text(const Value& value) {
    const bool is_number = decimal_number(value.text).has_value();
    return (is_number ? !value.quoted : is_plain(value.text)) ? value.text : quoted_scalar(value.text);
}

}  // namespace

std::string SourceLocation::describe() const {
    return line > 0 ? *origin + ":" + std::to_string(line) : *origin;
}

const Value* Value::find(const std::string& key) const {
    const auto found = std::find_if(members.begin(), members.end(),
                                    [&key](const Member& member) { return member.key == key; });
    return found == members.end() ? nullptr : &found->value;
}

std::string described(const Value& value) {
    switch (value.kind) {
        case ValueKind::kNothing:
            return "nothing";
        case ValueKind::kScalar:
            return text::quoted(value.text);
        case ValueKind::kList:
            return "a list";
        case ValueKind::kMap:
            return "a map";
    }
    return "";
}

std::string quoted_scalar(const std::string& words) {
    // In single quotes nothing is special except for the quote. YAML::Emitter would lose bytes that are not UTF-8, as
    // names of files may have.
    if (!text::has_control(words)) return text::literal(words, '\'');
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    std::string result = "\"";
    for (const char character : words) {
        if (text::is_control(character)) {
            const auto code = static_cast<unsigned char>(character);
            result += std::string("\\x") + kDigits[code >> 4U] + kDigits[code & 0xFU];
        } else {
            if (character == '"' || character == '\\') result += '\\';
            result += character;
        }
    }
    return result + "\"";
}

std::string flow_text(const Value& value) {
    std::string text;
    switch (value.kind) {
        case ValueKind::kNothing:
            return "~";
        case ValueKind::kScalar:
            return scalar_text(value);
        case ValueKind::kList:
            for (const Value& item : value.items) text += (text.empty() ? "" : ", ") + flow_text(item);
            return "[" + text + "]";
        case ValueKind::kMap:
            for (const Member& member : value.members) {
                Value key;
                key.kind = ValueKind::kScalar;
                key.text = member.key;
                text += (text.empty() ? "" : ", ") + scalar_text(key) + ": " + flow_text(member.value);
            }
            return "{" + text + "}";
    }
    return text;
}

Value parse_yaml(const std::string& text, const std::shared_ptr<const std::string>& origin, bool has_lines) {
    TreeBuilder builder(origin, has_lines);
    const SourceLocation start = builder.location(YAML::Mark());
    try {
        if (const std::optional<YAML::Mark> second = second_document(text); second.has_value()) {
            fail_at(
                builder.location(*second), "",
                "text goes on after the end of the YAML document; use one document, without '---' or a stray "
                "',' between its parts");
        }
        return builder.build(YAML::Load(text), start, 0);
    } catch (const YAML::Exception& error) {
        fail_at(
            builder.location(error.mark), "",
            "not valid YAML: " + error.msg +
                "; look for the indentation, colon, quotation mark or bracket that is wrong here or above");
    }
}

void apply_override(Value& root, const Schema& schema, const std::string& path, const std::string& value) {
    const SourceLocation location{
        std::make_shared<const std::string>(text::one_line("--set " + path + "=" + value)), 0};
    const std::vector<Step> steps = steps_of(path, location);
    Value parsed = parse_yaml(value, location.origin, false);
    Value* target = &root;
    follow(steps, schema, location, target);
    *target = std::move(parsed);
}

KeyPath find_key_path(const Schema& schema, const std::string& path, const std::string& where) {
    const SourceLocation location{std::make_shared<const std::string>(where), 0};
    Value* none = nullptr;
    return follow(steps_of(path, location), schema, location, none);
}

void check_structure(const Value& root, const Schema& schema) { check_structure_of(schema, root, "", ""); }

SourceLocation find_location(const Value& root, const std::string& path) {
    const Value* value = &root;
    const std::optional<std::vector<Step>> steps = split_path(path);
    if (!steps.has_value()) return root.location;
    for (const Step& step : *steps) {
        const Value* inner = nullptr;
        if (!step.bracketed) {
            inner = value->find(step.word);
        } else if (const auto index = index_of(step.word);
                   index.has_value() && *index < value->items.size()) {
            inner = &value->items[*index];
        }
        if (inner == nullptr) break;
        value = inner;
    }
    return value->location;
}

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

void Entry::fail(const std::string& message) const { fail_at(location_, path_, message); }

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
    const auto [stop, error] = std::from_chars(after_plus(digits), digits.data() + digits.size(), value);
    if (error != std::errc()) fail(text::one_line(digits) + " is out of range; use " + use);
    return value;
}

std::int64_t Entry::integer(const IntegerRange& allowed) const {
    return std::get<std::int64_t>(value(ValueRule::whole_numbers(allowed)));
}

double Entry::number(const NumberRange& allowed) const {
    const std::string use = text::range(allowed);
    const std::string& digits = scalar(use);
    const std::optional<double> value = decimal_number(digits);
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
