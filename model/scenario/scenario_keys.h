#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace metabuffer {

enum class KeyShape : std::uint8_t { kScalar, kMap, kList };

/// One place of a scenario. A list's entries are written "[]": `renderers[].frames[].viewport.x`.
struct ScenarioKey {
    const char* pattern;
    KeyShape shape;
    const char* meaning;  ///< completes "use ..."
};

/// Every place of a scenario, the one list that the reader, overrides and documentation go by.
const std::vector<ScenarioKey>& scenario_keys();

/// The place of that pattern, or null; the empty pattern is the scenario itself.
const ScenarioKey* find_scenario_key(std::string_view pattern);

/// Whether a map may hold the key.
bool is_key_of(std::string_view map_pattern, std::string_view key);

/// The keys a map may hold, in the order of the list.
std::vector<std::string> keys_of(std::string_view map_pattern);

/// What to tell about a key that the map does not know: the path of the nearest known one. A key that is
/// known elsewhere is named with where it belongs, unless one of this map is nearly the same.
std::string nearest_key(std::string_view map_pattern, std::string_view map_path, std::string_view key);

std::string key_pattern(std::string_view map_pattern, std::string_view key);

}  // namespace metabuffer
