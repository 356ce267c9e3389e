#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

#include "host/range.h"
#include "scenario/names.h"

namespace metabuffer {

enum class KeyShape : std::uint8_t {
    kScalar,
    kMap,      ///< of the schema's keys
    kList,     ///< its entries are the key "[]"
    kFreeMap,  ///< a map that may hold any key; its values are the key "[]"
    kAny,      ///< the schema says nothing about it
};

/// A key's value. An enumerator is its name; the numbers are those of a list of fixed length.
using KeyValue = std::variant<std::int64_t, double, std::string, std::vector<double>>;

/// As files write it, without quotation marks.
std::string value_text(const KeyValue& value);

/// The values that a key accepts.
struct ValueRule {
    enum class Type : std::uint8_t {
        kAny,  ///< the reader of the key decides
        kWholeNumber,
        kNumber,
        kChoice,
        kText,
    };
    Type type = Type::kAny;
    IntegerRange whole;
    NumberRange number;
    std::vector<std::int64_t> only;    ///< whole numbers, ascending, if not all of the range is allowed
    std::vector<std::string> choices;  ///< the names
    const char* what = "";             ///< what one of `only` or `choices` is called: "a bus width"

    static ValueRule whole_numbers(const IntegerRange& range);
    static ValueRule one_of(std::vector<std::int64_t> values, const char* what);
    static ValueRule numbers(const NumberRange& range);
    template <typename Enum>
    static ValueRule choice_of() {
        ValueRule rule;
        rule.type = Type::kChoice;
        rule.choices = enum_names<Enum>();
        rule.what = EnumNames<Enum>::kWhat;
        return rule;
    }

    /// "1 to 64", "16, 32 or 64", "glitch or stall"; empty if it accepts anything.
    std::string allowed() const;
    /// What is wrong with the value and what would be right, empty if nothing is. The value must be of the rule's type.
    std::string complaint(const KeyValue& value) const;
};

/// One key of a file. A list's entries are written "[]": `renderers[].frames[].viewport.x`.
struct SchemaKey {
    const char* pattern = "";
    KeyShape shape = KeyShape::kScalar;
    const char* meaning = "";  ///< completes "use ..."
    ValueRule rule = {};
    const char* unit = "";
    std::string fallback = {};  ///< what holds if it is not given, in words: "64", "required"
    std::size_t length = 0;     ///< of a list that always has that many numbers
    bool may_be_one = false;    ///< of a list: a single entry may stand without one
};

/// Every key that a kind of YAML file has: the one list for its reader, overrides and documentation.
class Schema {
  public:
    /// `keys` begins with the empty pattern, the file itself. `empty_message` is the message for an empty file.
    Schema(std::string empty_message, std::vector<SchemaKey> keys);

    const std::vector<SchemaKey>& keys() const { return keys_; }
    const std::string& empty_message() const { return empty_message_; }

    /// The key of that pattern, or null.
    const SchemaKey* find(std::string_view pattern) const;
    /// Whether a map may hold the key.
    bool is_key_of(std::string_view map_pattern, std::string_view key) const;
    /// The keys a map may hold, in the order of the list.
    std::vector<std::string> keys_of(std::string_view map_pattern) const;
    /// The patterns that end in a key: not those of lists' entries, nor the file itself.
    std::vector<std::string> paths() const;
    /// The path of the key that was probably meant by one that the map does not know: the nearest of the map, or the same
    /// key elsewhere in the file, unless one of the map is nearly the same.
    std::string nearest_key(std::string_view map_pattern, std::string_view map_path,
                            std::string_view key) const;

  private:
    std::string empty_message_;
    std::vector<SchemaKey> keys_;
    std::unordered_map<std::string_view, std::size_t> index_;  ///< into keys_, by pattern
};

/// "bus" and "width_bits" to "bus.width_bits".
std::string key_pattern(std::string_view map_pattern, std::string_view key);

/// "renderers" and 2 to "renderers[2]".
std::string item_path(const std::string& list_path, std::size_t index);

}  // namespace metabuffer
