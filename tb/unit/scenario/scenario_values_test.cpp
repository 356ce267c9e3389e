#include <catch2/catch.hpp>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "support/rows.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

std::string joined_text(std::initializer_list<std::string_view> parts) {
    std::string text;
    for (const std::string_view part : parts) text += part;
    return text;
}

/// A key's line under its map, as the scenario's first lines: `bus.width_bits` is on line 2, `frames` on
/// line 1.
struct KeyLines {
    std::string text;
    int line;
};

KeyLines key_lines(const std::string& path, const std::string& value) {
    const std::size_t dot = path.find('.');
    if (dot == std::string::npos) return {path + ": " + value + "\n", 1};
    return {path.substr(0, dot) + ":\n  " + path.substr(dot + 1) + ": " + value + "\n", 2};
}

/// The scenario with that key and value on top, other keys as they must be.
std::string scenario_with(const std::string& path, const std::string& value) {
    const std::string lines = key_lines(path, value).text;
    if (path.rfind("displays.", 0) != 0) return ScenarioFixture::minimal(lines);
    std::string rest;
    if (path != "displays.width") rest += "  width: 16\n";
    if (path != "displays.height") rest += "  height: 8\n";
    return lines + rest + ScenarioFixture::kRenderers;
}

void check_error(const ScenarioFixture& fixture, const std::string& path, const std::string& value,
                 const std::string& message) {
    INFO(path << ": " << value);
    CHECK(fixture.error(scenario_with(path, value)) ==
          "test.yaml:" + std::to_string(key_lines(path, value).line) + ": " + path + ": " + message);
}

/// What an integer key accepts and what it rejects, and what its messages say would be right.
template <typename Get>
void check_integer_key(const ScenarioFixture& fixture, const std::string& path, const std::string& low,
                       const std::string& high, Get get) {
    const std::string use = "; use " + low + " to " + high;
    INFO(path);
    CHECK(std::to_string(get(fixture.parse(scenario_with(path, low)))) == low);
    CHECK(std::to_string(get(fixture.parse(scenario_with(path, high)))) == high);
    const std::string below = std::to_string(std::stoll(low) - 1);
    const std::string above = std::to_string(std::stoll(high) + 1);
    check_error(fixture, path, below, below + " is out of range" + use);
    check_error(fixture, path, above, above + " is out of range" + use);
    for (const std::string wrong : {"99999999999999999999", "-99999999999999999999"}) {
        check_error(fixture, path, wrong, joined_text({wrong, " is out of range", use}));
    }
    for (const std::string wrong :
         {"12abc", "abc", "1.0", "1e1", "0x10", "1_0", "true", "+", "+-1", ".inf"}) {
        check_error(fixture, path, wrong, joined_text({"'", wrong, "' is not a whole number", use}));
    }
    for (const std::string wrong : {"010", "-010", "00"}) {
        check_error(fixture, path, wrong,
                    joined_text({"'", wrong, "' has a leading zero", use, ", in decimal digits"}));
    }
    check_error(fixture, path, "'12'", "'12' is not a whole number" + use + " without quotation marks");
    check_error(fixture, path, "[1]", "is a list" + use);
    check_error(fixture, path, "{a: 1}", "is a map" + use);
    check_error(fixture, path, "", "is nothing" + use);
    check_error(fixture, path, "~", "is nothing" + use);
}

template <typename Get>
void check_number_key(const ScenarioFixture& fixture, const std::string& path, Get get) {
    const std::string use = "; use 0.001 to 10000";
    INFO(path);
    CHECK(get(fixture.parse(ScenarioFixture::minimal())) == 100.0);
    for (const auto& [value, number] : std::vector<std::pair<std::string, double>>{{"0.001", 0.001},
                                                                                   {"10000", 10000.0},
                                                                                   {"74.25", 74.25},
                                                                                   {"1.5e2", 150.0},
                                                                                   {".5", 0.5},
                                                                                   {"5.", 5.0},
                                                                                   {"+3", 3.0},
                                                                                   {"010", 10.0}}) {
        INFO(value);
        CHECK(get(fixture.parse(scenario_with(path, value))) == number);
    }
    for (const std::string wrong : {"0", "0.0009", "10000.5", "-1"}) {
        check_error(fixture, path, wrong, joined_text({wrong, " is out of range", use}));
    }
    for (const std::string wrong : {"fast", "true", ".inf", "-.inf", "inf", ".nan", "nan", "NaN", "12abc",
                                    "0x10", "1e", "+-1", "1e999", "1,5"}) {
        check_error(fixture, path, wrong, joined_text({"'", wrong, "' is not a finite decimal number", use}));
    }
    check_error(fixture, path, "'12'", "'12' is not a finite decimal number" + use);
    check_error(fixture, path, "[1]", "is a list" + use);
    check_error(fixture, path, "", "is nothing" + use);
}

template <typename Enum, typename Get>
void check_choice_key(const ScenarioFixture& fixture, const std::string& path, const std::string& what,
                      const std::vector<std::pair<std::string, Enum>>& names, const std::string& use,
                      Get get) {
    INFO(path);
    CHECK(get(fixture.parse(ScenarioFixture::minimal())) == names.front().second);
    for (const auto& [name, value] : names) {
        CHECK(get(fixture.parse(scenario_with(path, name))) == value);
        CHECK(get(fixture.parse(scenario_with(path, "'" + name + "'"))) == value);
    }
    check_error(fixture, path, "nonsense", "'nonsense' is not " + what + "; use " + use);
    check_error(fixture, path, "Z", "'Z' is not " + what + "; use " + use);
    check_error(fixture, path, "1", "'1' is not " + what + "; use " + use);
    check_error(fixture, path, "[z]", "is a list; use " + use);
    check_error(fixture, path, "", "is nothing; use " + use);
}

}  // namespace

TEST_CASE("scenario: the least scenario has the documented defaults") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(ScenarioFixture::minimal());
    CHECK(scenario.name == "test");
    CHECK(scenario.displays.columns == 1);
    CHECK(scenario.displays.rows == 1);
    CHECK(scenario.displays.width_pixels == 16);
    CHECK(scenario.displays.height_pixels == 8);
    CHECK(scenario.displays.supersample == 1);
    CHECK(scenario.background_pixel() == Pixel(0, 0, 0, 0, 0xFFFF));
    CHECK(scenario.composition == Composition::kZ);
    CHECK(scenario.depth_format == DepthFormat::kA8Z16);
    CHECK(scenario.image_reading.near == 0.0);
    CHECK(scenario.image_reading.far == 100.0);
    CHECK(scenario.memory.page_words == 512);
    CHECK(scenario.memory.page_miss_cycles == 6);
    CHECK(scenario.memory.words_per_cycle == 1);
    CHECK(scenario.bus.width_bits == 64);
    CHECK(scenario.bus.burst_pixels == 32);
    CHECK(scenario.composer.buffer_pixels == 1024);
    CHECK(scenario.composer.ready_space_pixels == 32);
    CHECK(scenario.link_timeout_pairs == 2);
    CHECK(scenario.watchdog_cycles == 0);
    CHECK(scenario.frames == 1);
    CHECK(scenario.faults.empty());
    REQUIRE(scenario.renderers.size() == 1);
    const Renderer& renderer = scenario.renderers[0];
    CHECK(renderer.name == "renderer_1");
    CHECK(renderer.image_width_pixels == 16);
    CHECK(renderer.image_height_pixels == 8);
    REQUIRE(renderer.images.size() == 1);
    CHECK(renderer.images[0]->pixels().values[0] == Pixel(0, 0, 0, 255, 0));
    REQUIRE(renderer.frames.size() == 1);
    CHECK(renderer.frames[0].table == ViewportTable{{1, 0, 0, 16, 8, 0, 0, 1}});
    REQUIRE(renderer.frames[0].viewport.has_value());
    CHECK(renderer.frames[0].viewport->multiple == 1);
    CHECK(renderer.frames[0].table_line == 5);
    CHECK_NOTHROW(check_scenario(scenario));
}

TEST_CASE("scenario: numbers") {
    const ScenarioFixture fixture;
    check_integer_key(fixture, "displays.columns", "1", "64",
                      [](const Scenario& s) { return s.displays.columns; });
    check_integer_key(fixture, "displays.rows", "1", "64", [](const Scenario& s) { return s.displays.rows; });
    check_integer_key(fixture, "displays.width", "1", "4096",
                      [](const Scenario& s) { return s.displays.width_pixels; });
    check_integer_key(fixture, "displays.height", "1", "4096",
                      [](const Scenario& s) { return s.displays.height_pixels; });
    check_integer_key(fixture, "memory.page_words", "1", "16777216",
                      [](const Scenario& s) { return s.memory.page_words; });
    check_integer_key(fixture, "memory.page_miss_cycles", "0", "1000000",
                      [](const Scenario& s) { return s.memory.page_miss_cycles; });
    check_integer_key(fixture, "memory.words_per_cycle", "1", "8",
                      [](const Scenario& s) { return s.memory.words_per_cycle; });
    check_integer_key(fixture, "bus.burst_pixels", "1", "65535",
                      [](const Scenario& s) { return s.bus.burst_pixels; });
    check_integer_key(fixture, "composer.buffer_pixels", "1", "16777216",
                      [](const Scenario& s) { return s.composer.buffer_pixels; });
    check_integer_key(fixture, "link_timeout_pairs", "1", "1000000",
                      [](const Scenario& s) { return s.link_timeout_pairs; });
    check_integer_key(fixture, "watchdog_cycles", "0", "1000000000000000",
                      [](const Scenario& s) { return s.watchdog_cycles; });
    check_integer_key(fixture, "frames", "1", "1000000", [](const Scenario& s) { return s.frames; });
    for (const int width : {16, 32, 64, 128, 256, 512}) {
        CHECK(fixture.parse(scenario_with("bus.width_bits", std::to_string(width))).bus.width_bits == width);
    }
    for (const std::string wrong : {"48", "0", "-16", "1024", "8"}) {
        check_error(fixture, "bus.width_bits", wrong,
                    wrong + " is not a bus width; use 16, 32, 64, 128, 256 or 512");
    }
    check_error(fixture, "bus.width_bits", "wide",
                "'wide' is not a whole number; use 16, 32, 64, 128, 256 or 512");
    for (const int s : {1, 2, 4}) {
        const Scenario scenario = fixture.parse(scenario_with("displays.supersample", std::to_string(s)));
        CHECK(scenario.displays.supersample == s);
        CHECK(scenario.displays.raster_width_pixels() == 16 * s);
    }
    for (const std::string wrong : {"0", "3", "8"}) {
        check_error(fixture, "displays.supersample", wrong, wrong + " is not a supersampling; use 1, 2 or 4");
    }
    check_number_key(fixture, "clocks.core_mhz", [](const Scenario& s) { return s.clocks.core_mhz; });
    check_number_key(fixture, "clocks.dvi_in_mhz", [](const Scenario& s) { return s.clocks.dvi_in_mhz; });
    check_number_key(fixture, "clocks.dvi_out_mhz", [](const Scenario& s) { return s.clocks.dvi_out_mhz; });
}

TEST_CASE("scenario: choices") {
    const ScenarioFixture fixture;
    check_choice_key<Composition>(
        fixture, "composition", "a composition",
        {{"z", Composition::kZ}, {"z-alpha-key", Composition::kZAlphaKey}, {"over", Composition::kOver}},
        "z, z-alpha-key or over", [](const Scenario& s) { return s.composition; });
    check_choice_key<DepthFormat>(fixture, "depth_format", "a depth format",
                                  {{"a8z16", DepthFormat::kA8Z16}, {"z24", DepthFormat::kZ24}},
                                  "a8z16 or z24", [](const Scenario& s) { return s.depth_format; });
    check_choice_key<Arbitration>(fixture, "bus.arbitration", "an arbitration",
                                  {{"irsa", Arbitration::kIrsa},
                                   {"slot-allocation", Arbitration::kSlotAllocation},
                                   {"round-robin", Arbitration::kRoundRobin},
                                   {"edf", Arbitration::kEdf}},
                                  "irsa, slot-allocation, round-robin or edf",
                                  [](const Scenario& s) { return s.bus.arbitration; });
    check_choice_key<Smoothing>(fixture, "composer.smoothing", "a smoothing",
                                {{"replicate", Smoothing::kReplicate}, {"bilinear", Smoothing::kBilinear}},
                                "replicate or bilinear",
                                [](const Scenario& s) { return s.composer.smoothing; });
    check_choice_key<StarvationMode>(fixture, "composer.on_starvation", "a starvation mode",
                                     {{"glitch", StarvationMode::kGlitch}, {"stall", StarvationMode::kStall}},
                                     "glitch or stall",
                                     [](const Scenario& s) { return s.composer.on_starvation; });
    check_choice_key<Pacing>(fixture, "pacing", "a pacing",
                             {{"lockstep", Pacing::kLockstep}, {"free-running", Pacing::kFreeRunning}},
                             "lockstep or free-running", [](const Scenario& s) { return s.pacing; });
}

TEST_CASE("scenario: ready space and gap between displays") {
    const ScenarioFixture fixture;
    const auto ready_space = [&fixture](const std::string& above) {
        return fixture.parse(ScenarioFixture::minimal(above)).composer.ready_space_pixels;
    };
    CHECK(ready_space("bus: {burst_pixels: 100}\n") == 100);
    CHECK(ready_space("bus: {burst_pixels: 1}\n") == 2);
    CHECK(ready_space("bus: {burst_pixels: 4, width_bits: 512}\nmemory: {words_per_cycle: 8}\n") == 16);
    CHECK(ready_space("composer: {ready_space_pixels: 2}\n") == 2);
    check_error(fixture, "composer.ready_space_pixels", "1",
                "1 is less than the 2 pixels that can be in flight; use 2 or more");
    check_error(fixture, "composer.ready_space_pixels", "0", "0 is out of range; use 1 to 16777216");
    // The rows are checked against the buffer's own limit: they are dropped and counted.
    CHECK(ready_space("composer: {ready_space_pixels: 64, buffer_pixels: 8}\n") == 64);
    const Scenario scenario = fixture.parse(
        std::string("displays: {columns: 2, rows: 2, width: 16, height: 8, gap: {x: 3, y: 2}}\n") +
        ScenarioFixture::kRenderers);
    const DisplayWall wall = scenario.displays.wall();
    CHECK(wall.gap_x_pixels == 3);
    CHECK(wall.gap_y_pixels == 2);
    // 24 x 12 pixels from (4, 3): of its columns 12 to 14 and its rows 5 and 6 nobody sees anything.
    const ViewportTable table = split_viewport({4, 3, 1}, 24, 12, wall);
    const auto row = [](int display, int sx, int sy, int sdx, int sdy, int dx, int dy) {
        ViewportRow made;
        made.dcomp = static_cast<std::uint16_t>(display);
        made.sx = static_cast<std::uint16_t>(sx);
        made.sy = static_cast<std::uint16_t>(sy);
        made.sdx = static_cast<std::uint16_t>(sdx);
        made.sdy = static_cast<std::uint16_t>(sdy);
        made.dx = static_cast<std::int16_t>(dx);
        made.dy = static_cast<std::int16_t>(dy);
        made.dmultiple = 1;
        return made;
    };
    CHECK((table == ViewportTable{row(1, 0, 0, 12, 5, 4, 3), row(2, 15, 0, 9, 5, 0, 3),
                                  row(3, 0, 7, 12, 5, 4, 0), row(4, 15, 7, 9, 5, 0, 0)}));
    CHECK(fixture.error(scenario_with("displays.gap", "{x: -1}")) ==
          "test.yaml:2: displays.gap.x: -1 is out of range; use 0 to 65535");
}

TEST_CASE("scenario: the background is three channels, and depths that mean nothing are one or a list") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(scenario_with("displays.background", "[0, 128, 255]"));
    CHECK(scenario.background_pixel() == Pixel(0, 128, 255, 0, 0xFFFF));
    const std::string list = "a list of three whole numbers 0 to 255, [R, G, B]";
    check_error(fixture, "displays.background", "red", "is 'red'; use " + list);
    check_error(fixture, "displays.background", "", "is nothing; use " + list);
    check_error(fixture, "displays.background", "[1, 2]",
                "has 2 entries; use three whole numbers 0 to 255, [R, G, B]");
    CHECK(fixture.error(scenario_with("displays.background", "[0, 256, 0]")) ==
          "test.yaml:2: displays.background[1]: 256 is out of range; use 0 to 255");
    CHECK(fixture.error(scenario_with("displays.background", "[0,\n    0,\n    -1]")) ==
          "test.yaml:4: displays.background[2]: -1 is out of range; use 0 to 255");
    CHECK(fixture.error(scenario_with("displays.background", "[0.5, 0, 0]")) ==
          "test.yaml:2: displays.background[0]: '0.5' is not a whole number; use 0 to 255");
    const auto reading = [&](const std::string& value) {
        return fixture.parse(scenario_with("depth_nothing", value)).image_reading;
    };
    CHECK(reading("-1").nothing == std::vector<double>{-1.0});
    const ImageReading all = reading("[0, .inf, -inf, NaN, 1e10, Infinity]");
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK(all.nothing == std::vector<double>{0.0, infinity, -infinity, 1e10, infinity});
    CHECK(all.nan_is_nothing);
    CHECK_FALSE(reading("[]").nan_is_nothing);
    CHECK(fixture.error(scenario_with("depth_nothing", "[1, none]")) ==
          "test.yaml:1: depth_nothing[1]: 'none' is not a finite decimal number; use "
          "-1.7976931348623157e+308 to 1.7976931348623157e+308");
    check_error(
        fixture, "depth_nothing", "{a: 1}",
        "is a map; use a list of numbers, nan or inf: the depths in image files that mean nothing is there");
}

TEST_CASE("scenario: the depth range is near and far, which differ") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(scenario_with("depth_range", "[-2.5, 100]"));
    CHECK(scenario.image_reading.near == -2.5);
    CHECK(scenario.image_reading.far == 100.0);
    CHECK(fixture.parse(scenario_with("depth_range", "[5, 1.5]")).image_reading.larger_is_nearer());
    check_error(fixture, "depth_range", "[5, 5]", "near and far are both 5; use two different depths");
    const std::string use = "two numbers, [near, far]; near > far if larger ones are nearer";
    check_error(fixture, "depth_range", "[1]", "has 1 entries; use " + use);
    check_error(fixture, "depth_range", "100", "is '100'; use a list of " + use);
    CHECK(fixture.error(scenario_with("depth_range", "[0, .inf]")) ==
          "test.yaml:1: depth_range[1]: '.inf' is not a finite decimal number; use -1e+30 to 1e+30");
    CHECK(fixture.error(scenario_with("depth_range", "\n  - 0\n  - 1e31")) ==
          "test.yaml:3: depth_range[1]: 1e31 is out of range; use -1e+30 to 1e+30");
}

TEST_CASE("scenario: its name") {
    const ScenarioFixture fixture;
    CHECK(fixture.parse(scenario_with("name", "two balls")).name == "two balls");
    CHECK(fixture.parse(scenario_with("name", "12")).name == "12");
    CHECK(parse_scenario(ScenarioFixture::minimal(), "some/where/two.balls.yaml", fixture.directory().path())
              .name == "two.balls");
    CHECK(parse_scenario(ScenarioFixture::minimal(), "", fixture.directory().path()).name == "scenario");
    check_error(fixture, "name", "''", "is empty; use the scenario's name, on one line");
    check_error(fixture, "name", "\"a\\nb\"",
                "'a b' has control characters; use the scenario's name, on one line");
    check_error(fixture, "name", "[a]", "is a list; use the scenario's name, on one line");
}

TEST_CASE("scenario: what must be there, and be a map") {
    const ScenarioFixture fixture;
    fixture.check_refusals({
        {"", "test.yaml:1: the scenario is empty; use at least the keys displays and renderers"},
        {"# nothing\n", "test.yaml:1: the scenario is empty; use at least the keys displays and renderers"},
        {"~\n", "test.yaml:1: the scenario is empty; use at least the keys displays and renderers"},
        {"[1]\n", "test.yaml:1: is a list; use a map with the keys name, displays, ..."},
        {"hello\n", "test.yaml:1: is 'hello'; use a map with the keys name, ..."},
        {ScenarioFixture::kRenderers,
         "test.yaml:1: displays: is missing; use a map with at least the keys width and height"},
        {"\ndisplays:\n  width: 3\n" + std::string(ScenarioFixture::kRenderers),
         "test.yaml:2: displays.height: is missing; use 1 to 4096"},
        {"displays: {height: 3}\n" + std::string(ScenarioFixture::kRenderers),
         "test.yaml:1: displays.width: is missing; use 1 to 4096"},
        {ScenarioFixture::kDisplays,
         "test.yaml:1: renderers: is missing; use a list of at least one renderer"},
        {std::string(ScenarioFixture::kDisplays) + "renderers: []\n",
         "test.yaml:2: renderers: has no entries; use at least one renderer"},
        {std::string(ScenarioFixture::kDisplays) + "renderers:\n",
         "test.yaml:2: renderers: is nothing; use a list of renderers"},
    });
    check_error(fixture, "bus", "64",
                "is '64'; use a map with the keys width_bits, burst_pixels, arbitration, grant_cycles, "
                "slot_table and register_stages");
    check_error(fixture, "bus", "",
                "is nothing; use a map with the keys width_bits, burst_pixels, arbitration, grant_cycles, "
                "slot_table and register_stages");
    check_error(fixture, "memory", "[512]",
                "is a list; use a map with the keys page_words, banks, precharge_cycles, activate_cycles, "
                "page_miss_cycles, words_per_cycle, read_latency_cycles, refresh_interval_cycles, "
                "refresh_cycles, ports and write_block_words");
    check_error(fixture, "clocks", "100",
                "is '100'; use a map with the keys core_mhz, dvi_in_refresh_hz, dvi_in_mhz, "
                "dvi_out_refresh_hz and dvi_out_mhz");
    check_error(
        fixture, "composer", "100",
        "is '100'; use a map with the keys buffer_pixels, ready_space_pixels, on_starvation and smoothing");
    CHECK(fixture.parse(scenario_with("bus", "{}")).bus.width_bits == 64);
}

TEST_CASE("scenario: text that is not YAML, a key twice, and aliases without end") {
    const ScenarioFixture fixture;
    const auto check = [&fixture](const std::string& text, const std::string& start) {
        const std::string error = fixture.error(text);
        INFO(error);
        CHECK(error.rfind(start, 0) == 0);
        CHECK(error.find("; look for the indentation, colon, quotation mark or bracket") !=
              std::string::npos);
    };
    check("a: 1\nbus: [1, 2\n", "test.yaml:");
    check("a: 1\nb: c: d\n", "test.yaml:2: not valid YAML: ");
    check("a: 1\n b: 2\n", "test.yaml:2: not valid YAML: ");
    check("a: *nowhere\n", "test.yaml:1: not valid YAML: the referenced anchor is not defined");
    check("\n\n\"open", "test.yaml:3: not valid YAML: ");
    const std::string goes_on =
        "text goes on after the end of the YAML document; use one document, without '---' or a stray ',' "
        "between its parts";
    fixture.check_refusals({
        {ScenarioFixture::minimal() + "---\nframes: 3\n", "test.yaml:6: " + goes_on},
        {",", "test.yaml:1: " + goes_on},
        {ScenarioFixture::minimal() + "...\n", ""},
        {"---\n" + ScenarioFixture::minimal(), ""},
        {"[1, 2]: 3\n", "test.yaml:1: a key is not plain text; use the name of a key"},
    });
    CHECK(fixture.error(ScenarioFixture::minimal("frames: 1\nname: a\nframes: 1\n")) ==
          "test.yaml:3: frames: is here twice, first on line 1; use each key once in a map");
    CHECK(fixture.error(ScenarioFixture::minimal("bus:\n  width_bits: 64\n  width_bits: 32\n")) ==
          "test.yaml:3: width_bits: is here twice, first on line 2; use each key once in a map");
    const Scenario scenario = fixture.parse(
        "displays: {width: &side 16, height: *side}\n"
        "renderers:\n"
        "  - &one\n"
        "    frames: [{image: image.exr, viewport: {x: 0, y: 0}}]\n"
        "  - *one\n");
    CHECK(scenario.displays.height_pixels == 16);
    CHECK(scenario.renderers.size() == 2);
    CHECK(scenario.renderers[1].name == "renderer_2");
    CHECK(fixture.error("renderers: &all [*all]\n").find("is nested without end") != std::string::npos);
    std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
    for (int i = 1; i < 12; ++i) {
        const std::string last = "*a" + std::to_string(i - 1);
        const std::string self = "a" + std::to_string(i);
        bomb += joined_text({self, ": &", self, " [", last});
        for (int k = 1; k < 10; ++k) bomb += joined_text({", ", last});
        bomb += "]\n";
    }
    CHECK(fixture.error(bomb).find("is nested without end") != std::string::npos);
}

TEST_CASE("scenario: files") {
    const ScenarioFixture fixture;
    const std::string folder = fixture.directory().path().string();
    const auto error = [&](const std::string& name) {
        return input_error_of([&] { load_scenario(fixture.directory() / name); });
    };
    CHECK(error("absent.yaml") == folder + "/absent.yaml: cannot be read: No such file or directory");
    CHECK(error("") == folder + "/: cannot be read: Is a directory");
    fixture.directory().write("empty.yaml", "");
    CHECK(error("empty.yaml") ==
          folder + "/empty.yaml:1: the scenario is empty; use at least the keys displays and renderers");
    fixture.directory().write("bad.yaml", "bus:\n  width_bits: 48\n" + ScenarioFixture::minimal());
    CHECK(error("bad.yaml") ==
          folder + "/bad.yaml:2: bus.width_bits: 48 is not a bus width; use 16, 32, 64, 128, 256 or 512");
    const auto good = fixture.directory().write("good one.yaml", ScenarioFixture::minimal());
    const Scenario scenario = load_scenario(good, {parse_override("frames=3")});
    CHECK(scenario.name == "good one");
    CHECK(scenario.frames == 3);
    fixture.directory().write("windows.yaml",
                              "displays: {width: 16, height: 8}\r\nrenderers:\r\n"
                              "  - frames:\r\n      - image: image.exr\r\n"
                              "        viewport: {x: 0, y: 0}\r\n");
    CHECK(error("windows.yaml").empty());
    fixture.directory().write("zeros.yaml", std::string(100, '\0'));
    CHECK(error("zeros.yaml").rfind(folder + "/zeros.yaml:1: ", 0) == 0);
}

TEST_CASE("scenario: frames have the same tables if rows and slots are the same, whatever their images") {
    RendererFrame frame;
    frame.table = {segment_row({4, 2})};
    frame.slots = {1, 1};
    RendererFrame other = frame;
    other.image = 1;
    CHECK(has_same_tables(frame, other));
    other.slots = {1, 2};
    CHECK_FALSE(has_same_tables(frame, other));
    other.slots = std::nullopt;
    CHECK_FALSE(has_same_tables(frame, other));
    other.slots = frame.slots;
    other.table.push_back(segment_row({4, 2}, {}, 1, 2));
    CHECK_FALSE(has_same_tables(frame, other));
}

}  // namespace metabuffer::test
