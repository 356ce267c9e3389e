#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "unit/tools/exploration/sweep_fixture.h"

namespace metabuffer::test {
namespace {

using namespace exploration;
using Texts = std::vector<std::string>;

/// A sweep with the given lines as its axes, the first on line 3.
std::string with_axes(const std::string& lines) { return "scenario: case.yaml\naxes:\n" + lines; }

/// A sweep with a key at its top, on line 3.
std::string with_key(const std::string& lines) {
    return "scenario: case.yaml\naxes: [{key: frames, values: [1, 2]}]\n" + lines;
}

constexpr const char* kEverything =
    "name: buffer-width\n"
    "set: {composer.on_starvation: glitch, displays.background: [1, 2, 3], name: 'a b'}\n"
    "pictures: true\n"
    "cost: buffer_bits / 1000 + 2 * bus.width_bits\n"
    "axes:\n"
    "  - {key: bus.width_bits, values: [32, 64, 128]}\n"
    "  - {key: composer.buffer_pixels, range: {from: 64, to: 256, factor: 2}}\n"
    "  - {key: memory.page_miss_cycles, range: {from: 0, to: 6, step: 6}}\n"
    "  - zip:\n"
    "      - {key: bus.burst_pixels, values: [8, 16]}\n"
    "      - {key: composer.ready_space_pixels, values: [8, 16]}\n"
    "  - {key: scenario, values: [case.yaml, wide.yaml]}\n"
    "filter: >\n"
    "  composer.buffer_pixels >= 8 * bus.burst_pixels\n"
    "  and scenario = 'case.yaml'\n"
    "minimize: {key: memory.page_words, from: 16, to: 100000, goal: starved_pixels = 0, checks: 8}\n";

}  // namespace

TEST_CASE("sweep file: everything that one may hold") {
    const SweepFixture fixture;
    const SweepDescription sweep = fixture.parse(kEverything);
    CHECK(sweep.name == "buffer-width");
    CHECK(sweep.scenario.empty());
    CHECK(sweep.base == fixture.directory().path());
    CHECK(sweep.pictures);
    CHECK(sweep.cost == "buffer_bits / 1000 + 2 * bus.width_bits");
    REQUIRE(sweep.fixed.size() == 3);
    CHECK(sweep.fixed[0].path == "composer.on_starvation");
    CHECK(sweep.fixed[0].value == "glitch");
    CHECK(sweep.fixed[1].value == "[1, 2, 3]");
    CHECK(sweep.fixed[2].value == "'a b'");
    REQUIRE(sweep.axes.size() == 5);
    CHECK(sweep.axes[1].values == std::vector<Texts>{{"64", "128", "256"}});
    CHECK(sweep.axes[2].values == std::vector<Texts>{{"0", "6"}});
    CHECK(sweep.axes[3].keys == Texts{"bus.burst_pixels", "composer.ready_space_pixels"});
    REQUIRE(sweep.search.has_value());
    CHECK(sweep.search->key == "memory.page_words");
    CHECK(sweep.search->from == 16);
    CHECK(sweep.search->to == 100000);
    CHECK(sweep.search->goal == "starved_pixels = 0");
    CHECK(sweep.search->checks == 8);
    const SweepPlan plan = make_plan(sweep);
    CHECK(plan.cost == sweep.cost);
    CHECK(plan.points.filtered() == 3 * 3 * 2 * 2 * 2 - 30);
    CHECK(plan.points.size() ==
          30);  // of the nine widths and depths, bursts of 8 go with all and of 16 with six
    CHECK(point_texts(plan)[0] ==
          "bus.width_bits=32 composer.buffer_pixels=64 memory.page_miss_cycles=0 bus.burst_pixels=8 "
          "composer.ready_space_pixels=8 scenario=case.yaml");
}

TEST_CASE("sweep file: the least and its defaults, any YAML as values, and weights as a cost") {
    const SweepFixture fixture;
    const SweepDescription sweep =
        fixture.parse("scenario: case.yaml\nminimize: {key: composer.buffer_pixels}\n");
    CHECK(sweep.name == "test");
    CHECK(sweep.scenario == fixture.directory() / "case.yaml");
    CHECK_FALSE(sweep.pictures);
    CHECK(sweep.search->goal == default_goal());
    CHECK(sweep.search->from == 1);
    CHECK(sweep.search->to == 16777216);
    CHECK(make_plan(sweep).points.size() == 1);
    CHECK(fixture.plan("scenario: case.yaml\n").points.size() == 1);
    const SweepPlan plan =
        fixture.plan(with_axes("  - {key: displays.background, values: [[1, 2, 3], [0, 0, 0]]}\n"
                               "  - key: bus\n"
                               "    values:\n"
                               "      - {width_bits: 32, arbitration: edf}\n"
                               "      - width_bits: 64\n"
                               "  - {key: name, values: ['64', it's]}\n"));
    CHECK(plan.points.size() == 8);
    CHECK(point_texts(plan)[0] ==
          "displays.background=[1, 2, 3] bus={width_bits: 32, arbitration: edf} name='64'");
    CHECK(point_texts(plan)[7] == "displays.background=[0, 0, 0] bus={width_bits: 64} name='it''s'");
    CHECK(fixture.parse(with_key("weights: {buffer_bits: 0.001, memory_devices: 40}\n")).cost ==
          "0.001 * \"buffer_bits\" + 40 * \"memory_devices\"");
    CHECK(fixture.plan(with_key("weights: {buffer_bits: 0.001, memory_devices: 40}\n")).points.size() == 2);
}

TEST_CASE("sweep file: paths are relative to the file") {
    const SweepFixture fixture;
    std::filesystem::create_directory(fixture.directory() / "sweeps");
    const auto file =
        fixture.directory().write("sweeps/widths.yaml", with_axes("  - {key: frames, values: [1]}\n"));
    CHECK(load_sweep(file).name == "widths");
    CHECK(load_sweep(file).scenario == fixture.directory() / "sweeps/case.yaml");
    CHECK(input_error_of([&] { make_plan(load_sweep(file)); }).find("sweeps/case.yaml: cannot be read: ") !=
          std::string::npos);
    fixture.directory().write("sweeps/widths.yaml",
                              "axes: [{key: scenario, values: [../case.yaml, ../wide.yaml]}]\n");
    const SweepPlan plan = make_plan(load_sweep(file));
    CHECK(point_texts(plan) == Texts{"scenario=../case.yaml", "scenario=../wide.yaml"});
    CHECK(std::filesystem::equivalent(plan.scenario_file(points_of(plan)[1].settings),
                                      fixture.directory() / "wide.yaml"));
    CHECK(input_error_of([&] {
              load_sweep(fixture.directory() / "none.yaml");
          }).find("none.yaml: cannot be read: No such file or directory") != std::string::npos);
}

TEST_CASE("sweep file: random viewports") {
    const SweepFixture fixture;
    const std::string text = with_axes(
        "  - zip:\n"
        "      - {key: renderers.0.frames.0.viewport.x, random: {from: -100, to: 220, count: 200, seed: 7}}\n"
        "      - {key: renderers.0.frames.0.viewport.y, random: {from: -100, to: 140, count: 200, seed: "
        "8}}\n");
    const SweepPlan plan = fixture.plan(text);
    CHECK(plan.points.size() == 200);
    CHECK(point_texts(plan) == point_texts(fixture.plan(text)));
    std::set<std::string> rows;
    for (const Point& point : plan.points) rows.insert(point.settings[1].value);
    CHECK(rows.size() < 200);  // keys that go together may have values twice
    const SweepPlan alone = fixture.plan(
        with_axes("  - {key: bus.burst_pixels, random: {from: 1, to: 200, count: 200, seed: 7}}\n"));
    std::set<std::string> bursts;
    for (const Point& point : alone.points) bursts.insert(point.settings[0].value);
    CHECK(bursts.size() == 200);
}

TEST_CASE("sweep file: every mistake is reported in one line with its line") {
    const SweepFixture fixture;
    const auto error = [&fixture](const std::string& text) {
        const std::string message = fixture.error(text);
        const std::string file = "test.yaml:";
        REQUIRE(message.rfind(file, 0) == 0);
        return message.substr(file.size());
    };
    check_refusals(error)({
        {"", "1: the sweep is empty; use at least the keys scenario and axes"},
        {"- a\n",
         "1: is a list; use a map with the keys name, scenario, set, pictures, cost, weights, axes, filter "
         "and minimize"},
        {"scenario: [\n", "2: not valid YAML: ..."},
        {"scenario: case.yaml\nscenario: case.yaml\n", "2: scenario: is here twice, first on line 1; ..."},
        {"axes: [{key: frames, values: [1]}]\n",
         "1: axes: there is no scenario; use the key scenario, or an axis of that name"},
        {"scenario:\n", "1: scenario: is nothing; use a scenario file, on one line"},
        {"scenario: {a: 1}\n", "1: scenario: is a map; use a scenario file, on one line"},
        {"axes: 3\n", "1: axes: is '3'; use a list of axes"},
        {"axes:\n  - {key: scenario, range: {from: 1, to: 2}}\n",
         "2: axes[0]: scenarios are neither numbers nor drawn; use values, a list of files"},
        {"axes:\n  - {key: scenario, values: [[case.yaml]]}\n",
         "2: axes[0].values[0]: is a list; use a value, on one line"},
        {"axes:\n  - {key: scenario, values: [none.yaml]}\n", "2: axes[0].key: ..."},
    });
    // A key at the top, on line 3.
    check_refusals([&error](const std::string& lines) { return error(with_key(lines)); })({
        {"axis: 3\n", "3: axis: is not a known key; the nearest is axes"},
        {"minimise: {key: frames}\n", "3: minimise: is not a known key; the nearest is minimize"},
        {"factor: 2\n", "3: factor: is not a known key; the nearest is axes[].range.factor"},
        {"name: a/b\n", "3: name: 'a/b' is a path; use a plain name, without slashes"},
        {"pictures: yes\n", "3: pictures: 'yes' is not true or false; use true or false"},
        {"pictures:\n", "3: pictures: is nothing; use true or false"},
        {"set: 3\n", "3: set: is '3'; use a map from scenario keys to values"},
        {"set:\n  bus.widht_bits: 3\n",
         "4: set.bus.widht_bits: bus.widht_bits: is not a known key; the nearest is bus.width_bits"},
        {"set:\n  bus.width_bits:\n", "4: set.bus.width_bits: is nothing; use a value"},
        {"set: {frames: 3}\n",
         "2: axes[0].key: frames is set to one value for every point already; use each key once"},
        {"axes: 3\n", "3: axes: is here twice, first on line 2; ..."},
        {"filter: [frames]\n", "3: filter: is a list; use an expression over scenario keys"},
        {"filter: ''\n", "3: filter: is empty; use an expression over scenario keys"},
        {"filter: frmaes > 1\n", "3: filter: ..."},
        {"filter: frames >\n", "3: filter: ..."},
        {"filter: frames > 2\n",
         "3: filter: 'frames > 2' lets none of the 2 points through; use a wider filter"},
        {"cost: buffer_bits +\n", "3: cost: ..."},
        {"cost: bufer_bits\n", "3: cost: 'bufer_bits' is not known; the nearest is buffer_bits"},
        {"cost: 2 * cost\n", "3: cost: 'cost' is not known; the nearest is ..."},
        {"weights: {bus_wires: 1}\ncost: bus_wires\n",
         "3: weights: is given together with a cost; use one of the two"},
        {"weights: {bus_wires: many}\n", "3: weights.bus_wires: ..."},
        {"weights: {wires: 1}\n", "3: weights: ..."},
        {"weights: {}\n", "3: weights: has no entries; use figures and what one of each costs"},
        {"minimize: frames\n",
         "3: minimize: is 'frames'; use a map with the keys key, from, to, step, goal and checks"},
        {"minimize:\n  from: 3\n",
         "3: minimize.key: is missing; use a scenario key that holds a number, on one line"},
        {"minimize:\n  key: frames\n", "4: minimize.key: frames is an axis already; use each key once"},
        {"minimize:\n  key: bus.arbitration\n",
         "4: minimize.key: bus.arbitration does not hold a number, and only those can be minimized; use a "
         "key like composer.buffer_pixels"},
        {"minimize:\n  key: composer.bufer_pixels\n",
         "4: minimize.key: composer.bufer_pixels: is not a known key; the nearest is composer.buffer_pixels"},
        {"minimize:\n  key: composer.buffer_pixels\n  from: 0\n",
         "5: minimize.from: 0 is out of range; use 1 to 16777216"},
        {"minimize:\n  key: composer.buffer_pixels\n  from: 9\n  to: 8\n",
         "3: minimize: composer.buffer_pixels: from 9 is above to 8; use from at most to"},
        {"minimize:\n  key: composer.buffer_pixels\n  checks: -1\n",
         "5: minimize.checks: -1 is out of range; use 0 to 10000"},
        {"minimize:\n  key: composer.buffer_pixels\n  goal: starved = 0\n", "5: minimize.goal: ..."},
    });
    // An axis, on line 3.
    const std::string axis = "3: axes[0]";
    const std::string ones = "use one of them";
    check_refusals([&error](const std::string& lines) { return error(with_axes(lines)); })({
        {"  - frames\n", axis + ": is 'frames'; use a map with the keys key, values, range, random and zip"},
        {"  - {values: [1]}\n", axis + ": has neither a key nor a zip; use one of the two"},
        {"  - {key: frames}\n", axis + ": has none of values, range and random; " + ones},
        {"  - {key: frames, values: [1], range: {from: 1, to: 2}}\n",
         axis + ": has more than one of values, range and random; " + ones},
        {"  - {key: frmaes, values: [1]}\n",
         axis + ".key: frmaes: is not a known key; the nearest is frames"},
        {"  - {key: 'renderers.x.name', values: [1]}\n",
         axis + ".key: renderers: 'x' is not an index; use an index of renderers, from 0"},
        {"  - {key: frames, values: 3}\n", axis + ".values: is '3'; use a list of values"},
        {"  - {key: frames, values: []}\n", axis + ".values: has no entries; use at least one value"},
        {"  - key: frames\n    values:\n      - 1\n      - ~\n",
         "6: axes[0].values[1]: is nothing; use a value"},
        {"  - {key: frames, valeus: [1]}\n",
         axis + ".valeus: is not a known key; the nearest is axes[0].values"},
        {"  - {key: frames, values: [1, 2, 1]}\n",
         axis + ".key: frames has 1 twice, as values 1 and 3; use each once"},
        {"  - {key: frames, values: [1]}\n  - {key: frames, values: [2]}\n",
         "4: axes[1].key: frames is an axis already; use each key once"},
        {"  - {key: frames, range: [1, 2]}\n",
         axis + ".range: is a list; use a map with the keys from, to, step and factor"},
        {"  - {key: frames, range: {from: 1}}\n", axis + ".range.to: is missing; use -1e+15 to 1e+15"},
        {"  - {key: frames, range: {from: 1, to: x}}\n",
         axis + ".range.to: 'x' is not a finite decimal number; use -1e+15 to 1e+15"},
        {"  - {key: frames, range: {from: 2, to: 1}}\n",
         axis + ".range: from 2 is above to 1; use from at most to"},
        {"  - {key: frames, range: {from: 1, to: 2, step: 1, factor: 2}}\n",
         axis + ".range: has a step and a factor; use one of the two"},
        {"  - {key: frames, range: {from: 1, to: 2, step: 0}}\n",
         axis + ".range: step 0 goes nowhere; use a step above 0"},
        {"  - {key: frames, range: {from: 1, to: 9, factor: 1}}\n",
         axis + ".range: factor 1 goes nowhere; use a factor above 1"},
        {"  - {key: frames, range: {from: 1, to: 1e9}}\n",
         axis + ".range: makes 1e+09 values; use at most 1000000"},
        {"  - {key: frames, random: {from: 1, to: 9, count: 3}}\n",
         axis + ".random.seed: is missing; use 0 to 9223372036854775807"},
        {"  - {key: frames, random: {from: 1, to: 9, count: 0, seed: 1}}\n",
         axis + ".random.count: 0 is out of range; use 1 to 1000000"},
        {"  - {key: frames, random: {from: 1, to: 9, count: 10, seed: 1}}\n",
         axis +
             ".random: has 9 numbers to draw 10 different ones from; use a smaller count or a wider range"},
        {"  - zip: [&a {key: frames, range: {from: 1, to: 1000000}}, *a, *a, *a, *a]\n",
         axis + ".zip[4]: makes 5000000 values in all axes so far; use at most 4000000"},
        {"  - {zip: []}\n", axis + ".zip: has no entries; use at least one key with values"},
        {"  - {key: frames, zip: [{key: name, values: [a]}]}\n",
         axis + ".key: is given together with a zip; put it into the zip"},
        {"  - zip:\n      - {key: frames, values: [1, 2]}\n      - {key: name, values: [a]}\n",
         "5: axes[0].zip[1].key: name has 1 values and frames has 2; use as many for each of the keys that "
         "go together"},
        {"  - zip:\n      - {values: [1, 2]}\n",
         "4: axes[0].zip[0].key: is missing; use a scenario key, on one line"},
        {"  - {key: scenario, values: [case.yaml]}\n",
         "2: axes: an axis names the scenarios, and the sweep names one as well; use one of the two"},
        {"  - {key: frames, range: {from: 1, to: 2000}}\n  - {key: bus.burst_pixels, range: {from: 1, to: "
         "2000}}\n",
         "2: axes: the axes make 4000000 points or more; use at most 1000000"},
    });
}

TEST_CASE("sweep file: the documentation's list of keys") {
    const Texts paths = sweep_key_paths();
    const std::set<std::string> set(paths.begin(), paths.end());
    for (const char* path :
         {"name", "scenario", "set", "axes[].values", "axes[].zip[].random.seed", "minimize.goal"}) {
        CHECK(set.count(path) == 1);
    }
    CHECK(set.size() == paths.size());
}

}  // namespace metabuffer::test
