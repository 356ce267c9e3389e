#include "scenario/scenario_keys.h"

#include <algorithm>

#include "scenario/scenario_loader.h"
#include "scenario/text.h"

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

/// What a pattern's key stands in: "" for the keys at the top.
std::string_view enclosing_map(std::string_view pattern) {
    const std::size_t dot = pattern.rfind('.');
    return dot == std::string_view::npos ? std::string_view() : pattern.substr(0, dot);
}

}  // namespace

const std::vector<ScenarioKey>& scenario_keys() {
    constexpr KeyShape kScalar = KeyShape::kScalar;
    constexpr KeyShape kMap = KeyShape::kMap;
    constexpr KeyShape kList = KeyShape::kList;
    static const std::vector<ScenarioKey> keys{
        {"", kMap, "a map"},
        {"name", kScalar, "the scenario's name"},
        {"displays", kMap, "a map"},
        {"displays.columns", kScalar, "displays side by side"},
        {"displays.rows", kScalar, "displays one above the other"},
        {"displays.width", kScalar, "pixels of one display"},
        {"displays.height", kScalar, "pixels of one display"},
        {"displays.supersample", kScalar, "raster pixels per display pixel and axis"},
        {"displays.background", kList, "a list of three whole numbers 0 to 255, [R, G, B]"},
        {"displays.background[]", kScalar, "one of R, G, B"},
        {"composition", kScalar, "how a composer merges two pixels"},
        {"depth_format", kScalar, "the layout of a depth frame's pixel"},
        {"depth_range", kList, "a list of two numbers, [near, far]"},
        {"depth_range[]", kScalar, "near or far"},
        {"clocks", kMap, "a map"},
        {"clocks.core_mhz", kScalar, "MHz"},
        {"clocks.dvi_in_mhz", kScalar, "MHz"},
        {"clocks.dvi_out_mhz", kScalar, "MHz"},
        {"memory", kMap, "a map"},
        {"memory.page_words", kScalar, "words of an open page"},
        {"memory.page_miss_cycles", kScalar, "cycles to open a page"},
        {"memory.words_per_cycle", kScalar, "words per cycle of the open page"},
        {"bus", kMap, "a map"},
        {"bus.width_bits", kScalar, "bits"},
        {"bus.burst_pixels", kScalar, "most pixels of a burst"},
        {"bus.arbitration", kScalar, "who is next on the bus"},
        {"composer", kMap, "a map"},
        {"composer.buffer_pixels", kScalar, "pixels of the buffer"},
        {"composer.ready_space_pixels", kScalar, "free pixels at which a slot is taken"},
        {"composer.on_starvation", kScalar, "what happens when a pixel is late"},
        {"pacing", kScalar, "who waits for whom"},
        {"link_timeout_pairs", kScalar, "pair times"},
        {"watchdog_cycles", kScalar, "cycles, 0 for a value derived from the scenario"},
        {"frames", kScalar, "composited frames"},
        {"renderers", kList, "a list of renderers"},
        {"renderers[]", kMap, "a map"},
        {"renderers[].name", kScalar, "the renderer's name"},
        {"renderers[].frames", kList, "a list of frames, each with an image and a viewport or a table"},
        {"renderers[].frames[]", kMap, "a map"},
        {"renderers[].frames[].image", kScalar, "a file name"},
        {"renderers[].frames[].depth", kScalar, "a file name"},
        {"renderers[].frames[].viewport", kMap, "a map"},
        {"renderers[].frames[].viewport.x", kScalar, "raster pixels"},
        {"renderers[].frames[].viewport.y", kScalar, "raster pixels"},
        {"renderers[].frames[].viewport.multiple", kScalar, "raster pixels per source pixel and axis"},
        {"renderers[].frames[].table", kList,
         "a list of rows, each [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"},
        {"renderers[].frames[].table[]", kList,
         "a row of eight whole numbers, [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"},
        {"renderers[].frames[].table[][]", kScalar, "a field of a row"},
        {"faults", kList, "a list of faults"},
        {"faults[]", kMap, "a map"},
        {"faults[].renderer", kScalar, "a renderer's name"},
        {"faults[].pair", kScalar, "the pair's number, from 0"},
        {"faults[].kind", kScalar, "what goes wrong"},
        {"faults[].frame", kScalar, "which frame of the pair"},
        {"faults[].delay_pairs", kScalar, "pair times"},
    };
    return keys;
}

const ScenarioKey* find_scenario_key(std::string_view pattern) {
    const auto& keys = scenario_keys();
    const auto found = std::find_if(keys.begin(), keys.end(),
                                    [pattern](const ScenarioKey& key) { return pattern == key.pattern; });
    return found == keys.end() ? nullptr : &*found;
}

bool is_key_of(std::string_view map_pattern, std::string_view key) {
    // A key with a dot in it would otherwise pass for a path.
    return !key.empty() && key.find_first_of(".[]") == std::string_view::npos &&
           find_scenario_key(key_pattern(map_pattern, key)) != nullptr;
}

std::vector<std::string> keys_of(std::string_view map_pattern) {
    std::vector<std::string> keys;
    for (const ScenarioKey& key : scenario_keys()) {
        const std::string_view pattern = key.pattern;
        if (!last_key(pattern).empty() && enclosing_map(pattern) == map_pattern) {
            keys.emplace_back(last_key(pattern));
        }
    }
    return keys;
}

std::string nearest_key(std::string_view map_pattern, std::string_view map_path, std::string_view key) {
    constexpr int kSlip = 2;  // edits that are still a slip of the pen
    const std::string sibling = text::nearest(key, keys_of(map_pattern));
    if (text::edit_distance(key, sibling) > kSlip && !key.empty()) {
        for (const ScenarioKey& elsewhere : scenario_keys()) {
            if (last_key(elsewhere.pattern) == key) return elsewhere.pattern;
        }
    }
    return key_pattern(map_path, sibling);
}

std::string key_pattern(std::string_view map_pattern, std::string_view key) {
    return map_pattern.empty() ? std::string(key) : std::string(map_pattern) + "." + std::string(key);
}

std::vector<std::string> scenario_key_paths() {
    std::vector<std::string> paths;
    for (const ScenarioKey& key : scenario_keys()) {
        if (!last_key(key.pattern).empty()) paths.emplace_back(key.pattern);
    }
    return paths;
}

}  // namespace metabuffer
