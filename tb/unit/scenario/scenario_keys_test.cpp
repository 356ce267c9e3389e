#include "scenario/scenario_keys.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "host/text.h"
#include "unit/scenario/picture_files.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

/// A scenario with every key, so that each can be given a wrong value.
constexpr const char* kEveryKey =
    "name: every key\n"
    "displays: {columns: 2, rows: 1, width: 16, height: 8, supersample: 1, background: [1, 2, 3], gap: {x: "
    "0, y: 0}, correction: [{display: 1, gain: [1, 1, 1], gamma: 1}]}\n"
    "composition: z\n"
    "depth_format: a8z16\n"
    "depth_range: [0.0, 100.0]\n"
    "depth_nothing: [-1]\n"
    "depth_integers: scaled\n"
    "depth_bits: channel\n"
    "colour_encoding: as-is\n"
    "clocks: {core_mhz: 100, dvi_in_mhz: 100, dvi_out_mhz: 100}\n"
    "memory: {page_words: 512, banks: 1, precharge_cycles: 0, activate_cycles: 6, page_miss_cycles: 6, "
    "words_per_cycle: 1}\n"
    "bus: {width_bits: 64, burst_pixels: 32, arbitration: irsa}\n"
    "composer: {buffer_pixels: 1024, ready_space_pixels: 32, on_starvation: glitch}\n"
    "links: {layer: tmds}\n"
    "pacing: lockstep\n"
    "link_timeout_pairs: 2\n"
    "watchdog_cycles: 0\n"
    "frames: 1\n"
    "renderers:\n"
    "  - name: ball\n"
    "    copies: 1\n"
    "    frames:\n"
    "      - {image: image.exr, depth: depth.png, viewport: {x: 0, y: 0, multiple: 1}}\n"
    "      - {image: image.exr, table: [[1, 0, 0, 16, 8, 0, 0, 1]]}\n"
    "      - {image: image.exr, frames: 0-1, viewport: {path: [{frame: 0, x: 0, y: 0, multiple: 1}]}}\n"
    "faults:\n"
    "  - {renderer: ball, pair: 0, kind: delay, frame: colour, delay_pairs: 1}\n"
    "  - {renderer: ball, pair: 0, kind: short_frame, lines: 1}\n"
    "  - {renderer: ball, pair: 0, kind: control_byte, byte: 0, bits: 1}\n"
    "  - {renderer: ball, pair: 0, kind: pixel_bits, bits: 1, x: 0, y: 0}\n"
    "  - {renderer: ball, pair: 0, kind: drift, ppm: 1}\n"
    "  - {renderer: ball, kind: busready_low, display: 1, from_cycle: 0, cycles: 1}\n"
    "  - {renderer: ball, kind: lost_beat, display: 1, beats: 1, of: any}\n"
    "  - {renderer: ball, kind: random_stalls, percent: 1, seed: 0}\n"
    "  - {renderer: ball, pair: 0, kind: tmds_slip, channel: red, at_line: 0, at_clock: 0, late_bits: 0}\n"
    "  - {renderer: ball, pair: 0, kind: tmds_skew, channel: red, at_line: 0, at_clock: 0, late_characters: "
    "0}\n"
    "  - {renderer: ball, kind: tmds_noise, per_billion: 1}\n";

/// Which of the faults has the key; for `bits` the fault with the widest range.
std::string index_of_fault(const std::string& pattern) {
    const std::vector<std::pair<std::string, int>> indices{
        {"lines", 1},       {"byte", 2},       {"bits", 3},
        {"x", 3},           {"y", 3},          {"ppm", 4},
        {"display", 5},     {"from_cycle", 5}, {"cycles", 5},
        {"beats", 6},       {"of", 6},         {"percent", 7},
        {"seed", 7},        {"channel", 8},    {"at_line", 8},
        {"at_clock", 8},    {"late_bits", 8},  {"late_characters", 9},
        {"per_billion", 10}};
    for (const auto& [key, index] : indices) {
        if (pattern == "faults[]." + key) return "[" + std::to_string(index) + "]";
    }
    return "[0]";
}

/// Which of the frames has the key.
std::string index_of_frame(const std::string& pattern) {
    if (pattern.find(".table") != std::string::npos) return "[1]";
    const bool is_of_range =
        pattern.find(".path") != std::string::npos || pattern == "renderers[].frames[].frames";
    return is_of_range ? "[2]" : "[0]";
}

/// The key's path with an index for each list.
std::string with_indices(const std::string& pattern) {
    std::string path;
    for (std::size_t at = 0; at < pattern.size(); ++at) {
        if (pattern.compare(at, 2, "[]") == 0) {
            const bool is_frame = path.size() > 7 && path.compare(path.size() - 7, 7, ".frames") == 0;
            path += is_frame ? index_of_frame(pattern) : index_of_fault(pattern);
            ++at;
        } else {
            path += pattern[at];
        }
    }
    return path;
}

}  // namespace

TEST_CASE("scenario keys: every key of the list is read, and only with a value of its shape") {
    const ScenarioFixture fixture;
    write_picture(fixture.directory() / "depth.png", 16, 8, {{"Y"}, OIIO::TypeDesc::UINT16},
                  std::vector<std::uint16_t>(std::size_t{16} * 8));
    CHECK(fixture.error(kEveryKey).empty());
    write_picture(fixture.directory() / "depth.png", 16, 8, {{"Y"}, OIIO::TypeDesc::UINT16},
                  std::vector<std::uint16_t>(std::size_t{16} * 8));
    for (const SchemaKey& key : scenario_schema().keys()) {
        if (std::string(key.pattern).empty()) continue;
        const std::string path = with_indices(key.pattern);
        for (const std::string wrong : {"{}", "[[]]", "", "~", "'\x07'"}) {
            const bool empty_map = key.shape == KeyShape::kMap && wrong == "{}";
            const bool list_in_list = key.shape == KeyShape::kList && wrong == "[[]]";
            if (empty_map || list_in_list) continue;
            std::string setting = path;
            setting += '=';
            setting += wrong;
            const std::string error = fixture.error(kEveryKey, {setting});
            INFO(setting << " -> " << error);
            const std::string start = "--set " + setting;
            const std::string middle = ": " + path + ": ";
            CHECK(error.rfind(start.substr(0, start.find('\x07')), 0) == 0);
            CHECK(error.find(middle) != std::string::npos);
            CHECK(error.find("; use ") != std::string::npos);
        }
    }
}

TEST_CASE("scenario keys: every key's surroundings are in the list, and its path for documentation") {
    for (const SchemaKey& key : scenario_schema().keys()) {
        const std::string pattern = key.pattern;
        INFO(pattern);
        CHECK_FALSE(std::string(key.meaning).empty());
        const bool is_entry = pattern.size() > 2 && pattern.compare(pattern.size() - 2, 2, "[]") == 0;
        const std::size_t end =
            is_entry ? pattern.size() - 2 : (pattern.find('.') == std::string::npos ? 0 : pattern.rfind('.'));
        const SchemaKey* around = scenario_schema().find(pattern.substr(0, end));
        REQUIRE(around != nullptr);
        if (!pattern.empty()) CHECK(around->shape == (is_entry ? KeyShape::kList : KeyShape::kMap));
    }
    const std::vector<std::string> paths = scenario_key_paths();
    const std::set<std::string> set(paths.begin(), paths.end());
    CHECK(set.size() == paths.size());
    for (const char* path : {"name", "bus", "bus.width_bits", "displays.background", "renderers",
                             "renderers[].frames[].viewport.multiple", "faults[].delay_pairs",
                             "link_timeout_pairs", "watchdog_cycles"}) {
        CHECK(set.count(path) == 1);
    }
    CHECK(std::none_of(paths.begin(), paths.end(),
                       [](const std::string& path) { return path.empty() || path.back() == ']'; }));
}

TEST_CASE("scenario keys: what a whole-number key accepts is what the reader accepts") {
    const ScenarioFixture fixture;
    write_picture(fixture.directory() / "depth.png", 16, 8, {{"Y"}, OIIO::TypeDesc::UINT16},
                  std::vector<std::uint16_t>(std::size_t{16} * 8));
    int count = 0;
    for (const SchemaKey& key : scenario_schema().keys()) {
        const bool takes_whole_numbers = key.rule.type == ValueRule::Type::kWholeNumber;
        const bool other = std::string(key.pattern).find(".table") != std::string::npos;
        // The text of the error says whether the reader asks for a whole number there.
        const std::string wrong = key.shape == KeyShape::kScalar && !other
                                      ? fixture.error(kEveryKey, {with_indices(key.pattern) + "=x"})
                                      : std::string();
        INFO(key.pattern << ": " << wrong);
        CHECK(takes_whole_numbers == (wrong.find("is not a whole number") != std::string::npos));
        if (!takes_whole_numbers) continue;
        ++count;
        const auto error = [&](std::int64_t value) {
            return fixture.error(kEveryKey, {with_indices(key.pattern) + "=" + std::to_string(value)});
        };
        if (key.rule.only.empty()) {
            CHECK(wrong.find("; use " + text::range(key.rule.whole)) != std::string::npos);
            for (const std::int64_t beyond : {key.rule.whole.low - 1, key.rule.whole.high + 1}) {
                CHECK(error(beyond).find("is out of range; use " + text::range(key.rule.whole)) !=
                      std::string::npos);
            }
        }
        for (const std::int64_t value : key.rule.only) {
            CHECK(error(value).find(key.pattern) == std::string::npos);
            CHECK(error(3 * value).find(" is not a ") != std::string::npos);
        }
        CHECK(std::is_sorted(key.rule.only.begin(), key.rule.only.end()));
    }
    CHECK(count == 57);
    for (const char* map : {"bus", ""}) {
        CHECK(scenario_schema().find(map)->rule.type == ValueRule::Type::kAny);
    }
}

TEST_CASE("scenario keys: an unknown key names the nearest known one") {
    const ScenarioFixture fixture;
    struct Case {
        std::string above;
        std::string error;
    };
    const std::vector<Case> cases{
        {"bus:\n  widht_bits: 64\n",
         "test.yaml:2: bus.widht_bits: is not a known key; the nearest is bus.width_bits"},
        {"composer: {on_starving: glitch}\n",
         "test.yaml:1: composer.on_starving: is not a known key; the nearest is composer.on_starvation"},
        {"\n\nfrmaes: 3\n", "test.yaml:3: frmaes: is not a known key; the nearest is frames"},
        {"Frames: 3\n", "test.yaml:1: Frames: is not a known key; the nearest is frames"},
        {"width_bits: 64\n", "test.yaml:1: width_bits: is not a known key; the nearest is bus.width_bits"},
        {"multiple: 2\n",
         "test.yaml:1: multiple: is not a known key; the nearest is renderers[].frames[].viewport.multiple"},
        {"memory: {width_bits: 64}\n",
         "test.yaml:1: memory.width_bits: is not a known key; the nearest is bus.width_bits"},
        {"'': 1\n", "test.yaml:1: is not a known key; the nearest is bus"},
        {"'bus.width_bits': 64\n", "test.yaml:1: bus.width_bits: is not a known key; the nearest is bus"},
        {"<<: {frmaes: 3}\n", "test.yaml:1: frmaes: is not a known key; the nearest is frames"},
        {"'<<': {frames: 3}\n", "test.yaml:1: <<: is not a known key; the nearest is "},
    };
    for (const Case& one : cases) {
        INFO(one.above);
        const std::string error = fixture.error(ScenarioFixture::minimal(one.above));
        CHECK(error.substr(0, one.error.size()) == one.error);
    }
    CHECK(fixture.error("displays: {width: 16, height: 8}\n"
                        "renderers:\n"
                        "  - frames:\n"
                        "      - image: image.exr\n"
                        "        viewport:\n"
                        "          x: 0\n"
                        "          z: 0\n") ==
          "test.yaml:7: renderers[0].frames[0].viewport.z: is not a known key; the nearest is "
          "renderers[0].frames[0].viewport.x");
}

}  // namespace metabuffer::test
