#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace metabuffer {

enum class KeyShape : std::uint8_t {
    kScalar,
    kMap,      ///< of the schema's keys
    kList,     ///< its entries are the key "[]"
    kFreeMap,  ///< a map that may hold any key; its values are the key "[]"
    kAny,      ///< the schema says nothing about it
};

/// One place of a file. A list's entries are written "[]": `renderers[].frames[].viewport.x`.
struct SchemaKey {
    const char* pattern;
    KeyShape shape;
    const char* meaning;  ///< completes "use ..."
};

/// Every place that a kind of YAML file has, the one list that its reader, overrides and documentation go by.
class Schema {
  public:
    /// `keys` begins with the empty pattern, the file itself. `empty_message` is what an empty file is told.
    Schema(std::string empty_message, std::vector<SchemaKey> keys);

    const std::vector<SchemaKey>& keys() const { return keys_; }
    const std::string& empty_message() const { return empty_message_; }

    /// The place of that pattern, or null.
    const SchemaKey* find(std::string_view pattern) const;
    /// Whether a map may hold the key.
    bool is_key_of(std::string_view map_pattern, std::string_view key) const;
    /// The keys a map may hold, in the order of the list.
    std::vector<std::string> keys_of(std::string_view map_pattern) const;
    /// The patterns that end in a key: not those of lists' entries, nor the file itself.
    std::vector<std::string> paths() const;
    /// What to tell about a key that the map does not know: the path of the nearest known one. A key that is
    /// known elsewhere is named with where it belongs, unless one of this map is nearly the same.
    std::string nearest_key(std::string_view map_pattern, std::string_view map_path,
                            std::string_view key) const;

  private:
    std::string empty_message_;
    std::vector<SchemaKey> keys_;
    std::unordered_map<std::string_view, std::size_t> places_;  ///< into keys_, by pattern
};

/// "bus" and "width_bits" to "bus.width_bits".
std::string key_pattern(std::string_view map_pattern, std::string_view key);

}  // namespace metabuffer
