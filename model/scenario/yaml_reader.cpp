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

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer::input {
namespace {

// Aliases are written out, so that a few lines could make an endless tree.
constexpr int kDeepestNesting = 64;
constexpr std::size_t kMostValues = 4'000'000;
constexpr std::size_t kMostTextBytes = std::size_t{512} << 20U;

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
            key_location.fail("", "is nested without end; use aliases only for what they do not contain");
        }
        if (node.IsScalar()) text_bytes_ += node.Scalar().size();
        if (text_bytes_ > kMostTextBytes) {
            key_location.fail("", "has more than " + std::to_string(kMostTextBytes >> 20U) +
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
            if (!key.IsScalar()) key_location.fail("", "a key is not plain text; use the name of a key");
            const std::string& name = key.Scalar();
            const bool merges = name == "<<" && key.Tag() != "!";
            const auto [earlier, is_new] = lines.emplace(name, key_location.line);
            if (!is_new) {
                const std::string where =
                    has_lines_ ? " on line " + std::to_string(earlier->second) : std::string(" already");
                key_location.fail(name, "is here twice, first" + where + "; use each key once in a map");
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
            map.location.fail("<<", "is " + described(map) +
                                        "; use a map with an anchor, such as *frame, or a list of them");
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
    if (path.empty() && value.kind == ValueKind::kNothing) value.location.fail(path, schema.empty_message());
    value.location.fail(path, "is " + described(value) + "; use " + use);
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
                    member.location.fail(member_path, unknown_key(schema, key, path, member.key));
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
    location.fail(
        "", text::quoted(path) +
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
            location.fail(found.path, "has nothing inside; use " + use);
        }
        if (is_map && (step.bracketed || !schema.is_key_of(found.pattern, step.word))) {
            location.fail(key_pattern(found.path, step.word),
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
            location.fail(found.path, text::quoted(step.word) + " is not an index; " + use);
        }
        found = {item_path(found.path, *index), found.pattern + "[]"};
        if (value == nullptr) continue;
        if (*index >= value->items.size()) location.fail(found.path, "is out of range; " + use);
        value = &value->items[*index];
    }
    return found;
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
    const bool is_number = text::decimal_number(value.text).has_value();
    return (is_number ? !value.quoted : is_plain(value.text)) ? value.text : quoted_scalar(value.text);
}

}  // namespace

std::string SourceLocation::describe() const {
    return line > 0 ? *origin + ":" + std::to_string(line) : *origin;
}

void SourceLocation::fail(const std::string& path, const std::string& message) const {
    throw InputError(text::located(describe(), text::located(path, message)));
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
            builder.location(*second).fail(
                "",
                "text goes on after the end of the YAML document; use one document, without '---' or a stray "
                "',' between its parts");
        }
        return builder.build(YAML::Load(text), start, 0);
    } catch (const YAML::Exception& error) {
        builder.location(error.mark)
            .fail("", "not valid YAML: " + error.msg +
                          "; look for the indentation, colon, quotation mark or bracket that is wrong here "
                          "or above");
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

}  // namespace metabuffer::input
