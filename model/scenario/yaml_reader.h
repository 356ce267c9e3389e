#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scenario/schema.h"

/// YAML as a tree in which every value says where the file has it.
namespace metabuffer::input {

/// Where a value comes from: a line of a file, or an override.
struct SourceLocation {
    std::shared_ptr<const std::string> origin;
    int line = 0;  ///< from 1; 0 for an override

    std::string describe() const;
    /// Throws InputError: "file.yaml:3: bus.width_bits: message", without the path if that is empty.
    [[noreturn]] void fail(const std::string& path, const std::string& message) const;
};

enum class ValueKind : std::uint8_t { kNothing, kScalar, kList, kMap };

struct Member;

/// One value, aliases written out.
struct Value {
    SourceLocation location;  ///< of a scalar its own, otherwise its key's
    ValueKind kind = ValueKind::kNothing;
    std::string text;     ///< scalar
    bool quoted = false;  ///< scalar
    std::vector<Value> items;
    std::vector<Member> members;

    const Value* find(const std::string& key) const;
};

struct Member {
    SourceLocation location;
    std::string key;
    Value value;
};

/// "'abc'", "a list", "a map" or "nothing".
std::string described(const Value& value);

/// A text as a scalar in quotation marks, on one line: reads back as just that text.
std::string quoted_scalar(const std::string& words);

/// The value in flow style on one line, as an override accepts it: reads back as the same.
std::string flow_text(const Value& value);

/// Parses text that is in a file (lines count) or in an override (they do not). Throws InputError on what is not YAML,
/// on a second document, on a key twice in a map and on endless nesting.
Value parse_yaml(const std::string& text, const std::shared_ptr<const std::string>& origin, bool has_lines);

/// Puts a value, YAML as --set has it, at a path of keys and indices. Throws InputError.
void apply_override(Value& root, const Schema& schema, const std::string& path, const std::string& value);

/// A path of keys and indices as overrides have it.
struct KeyPath {
    std::string path;     ///< in one notation: "renderers[0].frames[1].viewport.x"
    std::string pattern;  ///< "renderers[].frames[].viewport.x"
};

/// Looks up a path in either notation, with any indices. Throws InputError, which begins with `where` and names the
/// nearest known key.
KeyPath find_key_path(const Schema& schema, const std::string& path, const std::string& where);

/// Throws InputError at the first unknown key and at the first value that is a map, a list or a scalar where
/// it should be something else.
void check_structure(const Value& root, const Schema& schema);

/// Where the tree has what the path names ("renderers[0].frames[1].table"), or the innermost value around it.
SourceLocation find_location(const Value& root, const std::string& path);

}  // namespace metabuffer::input
