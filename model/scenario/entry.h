#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/range.h"
#include "scenario/names.h"
#include "scenario/schema.h"
#include "scenario/yaml_reader.h"

namespace metabuffer::input {

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
