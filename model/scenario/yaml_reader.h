#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/errors.h"
#include "host/range.h"
#include "host/text.h"
#include "scenario/names.h"
#include "scenario/schema.h"

/// YAML as a tree in which every value says where the file has it, and typed reading of it by a schema.
namespace metabuffer::input {

/// Where a value comes from: a line of a file, or an override.
struct SourceLocation {
    std::shared_ptr<const std::string> origin;
    int line = 0;  ///< from 1; 0 for an override

    std::string describe() const;
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

/// A key or a list entry of a file while it is read: the value there, if any, and the key path for messages.
class Entry {
  public:
    /// Both must outlive the entry.
    Entry(const Value& root, const Schema& schema)
        : schema_(&schema), value_(&root), location_(root.location) {}

    bool present() const { return value_ != nullptr; }
    const SourceLocation& location() const { return location_; }
    const std::string& path() const { return path_; }

    /// The entry at a path of keys below it: "bus.width_bits".
    Entry at(std::string_view path) const;
    /// The key of a map. Asking for a key that the schema does not have is a programming error.
    Entry child(const std::string& key) const;
    /// A list's entries, none if there is no list.
    std::vector<Entry> items() const;
    /// The keys of a map that may hold any, and their values.
    std::vector<std::pair<std::string, Entry>> members() const;

    /// "file.yaml:3: bus.width_bits", which begins messages.
    std::string where() const;
    /// Throws InputError: where, message.
    [[noreturn]] void fail(const std::string& message) const;

    /// The value by the key's own rule, which must not be kAny; or by another rule of the same type.
    KeyValue value() const;
    KeyValue value(const ValueRule& rule) const;
    /// A whole number by the key's own rule.
    int integer() const { return static_cast<int>(std::get<std::int64_t>(value())); }
    std::int64_t integer(const IntegerRange& allowed) const;
    double number(const NumberRange& allowed) const;
    std::string name() const;
    /// A scalar whose line breaks become spaces, not empty.
    std::string line() const;
    bool boolean() const;
    /// A scalar as it is, empty if there is none.
    std::string text() const { return value_ == nullptr ? std::string() : value_->text; }
    /// Whatever it is, in flow style; fails if there is nothing.
    std::string flow() const;
    template <typename Enum>
    Enum choice() const {
        const std::vector<std::string> names = enum_names<Enum>();
        return *from_name<Enum>(choice(names, EnumNames<Enum>::kWhat));
    }
    std::string choice(const std::vector<std::string>& allowed, const std::string& what) const;

  private:
    Entry(const Schema* schema, const Value* value, std::string path, std::string pattern,
          SourceLocation location)
        : schema_(schema),
          value_(value),
          path_(std::move(path)),
          pattern_(std::move(pattern)),
          location_(std::move(location)) {}

    /// The scalar's text; fails if there is none. `use` is what would be right.
    const std::string& scalar(const std::string& use) const;
    std::int64_t whole_number(const std::string& use) const;
    std::vector<double> numbers(const SchemaKey& key) const;

    const Schema* schema_;
    const Value* value_;
    std::string path_;
    std::string pattern_;
    SourceLocation location_;
};

}  // namespace metabuffer::input
