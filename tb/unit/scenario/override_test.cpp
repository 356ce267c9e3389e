#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

constexpr const char* kTwoFrames =
    "displays: {width: 16, height: 8, background: [1, 2, 3]}\n"
    "bus: {width_bits: 48}\n"
    "renderers:\n"
    "  - name: ball\n"
    "    frames:\n"
    "      - {image: image.exr, viewport: {x: 0, y: 0}}\n"
    "      - {image: image.exr, table: [[1, 0, 0, 16, 8, 0, 0, 1]]}\n"
    "faults:\n"
    "  - {renderer: ball, pair: 0, kind: crc}\n";

/// Of a scenario with an override: what is said of it, after the words that name it.
auto complaint_of(const ScenarioFixture& fixture, const std::string& text = ScenarioFixture::minimal()) {
    return [&fixture, text](const std::string& setting) {
        const std::string error = fixture.error(text, {setting});
        const std::string named = "--set " + setting + ": ";
        REQUIRE(error.rfind(named, 0) == 0);
        return error.substr(named.size());
    };
}

}  // namespace

TEST_CASE("override: PATH=VALUE replaces a value before anything is checked, both ways to write an index") {
    CHECK(parse_override("bus.width_bits=32").path == "bus.width_bits");
    CHECK(parse_override("bus.width_bits=32").value == "32");
    CHECK(parse_override("name=a=b").value == "a=b");
    CHECK(parse_override("name=").value.empty());
    CHECK(input_error_of([] { parse_override("bus.width_bits"); }) ==
          "--set bus.width_bits: has no value; use --set PATH=VALUE, like --set bus.width_bits=32");
    CHECK(input_error_of([] { parse_override("=32"); }) ==
          "--set =32: has no key path; use --set PATH=VALUE, like --set bus.width_bits=32");
    CHECK(input_error_of([] { parse_override(""); }) ==
          "--set : has no value; use --set PATH=VALUE, like --set bus.width_bits=32");
    const ScenarioFixture fixture;
    CHECK(fixture.error(kTwoFrames).rfind("test.yaml:2: bus.width_bits: 48", 0) == 0);
    CHECK(fixture.parse(kTwoFrames, {"bus.width_bits=32"}).bus.width_bits == 32);
    CHECK(fixture.parse(kTwoFrames, {"bus.width_bits=32", "bus.width_bits=128"}).bus.width_bits == 128);
    for (const std::string path : {"renderers.0.frames.0.viewport.x", "renderers[0].frames[0].viewport.x",
                                   "renderers.0.frames[0].viewport.x"}) {
        INFO(path);
        const Scenario scenario = fixture.parse(kTwoFrames, {"bus.width_bits=32", path + "=-3"});
        const RendererFrame& frame = scenario.renderers[0].frames[0];
        REQUIRE(frame.viewport.has_value());
        CHECK(frame.viewport->x == -3);
        CHECK(frame.table == ViewportTable{{1, 3, 0, 13, 8, 0, 0, 1}});
        CHECK(frame.table_line == 6);
    }
    const std::vector<std::string> deep{"bus.width_bits=32", "renderers.0.frames.1.table.0.5=-4",
                                        "renderers[0].frames[1].table[0][6]=-5", "displays.background.1=77",
                                        "faults.0.kind=missing"};
    const Scenario scenario = fixture.parse(kTwoFrames, deep);
    CHECK(scenario.renderers[0].frames[1].table == ViewportTable{{1, 0, 0, 16, 8, -4, -5, 1}});
    CHECK(scenario.displays.background[1] == 77);
    CHECK(scenario.faults[0].kind == FaultKind::kMissing);
}

TEST_CASE("override: values are YAML, for a known key and the maps around it, but no new entry of a list") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(
        kTwoFrames, {"bus={width_bits: 128, arbitration: edf}", "name='12'", "displays.background=[9, 8, 7]",
                     "renderers.0.frames.1={image: image.exr, viewport: {x: 1, y: 1}}", "faults=[]"});
    CHECK(scenario.bus.width_bits == 128);
    CHECK(scenario.bus.arbitration == Arbitration::kEdf);
    CHECK(scenario.name == "12");
    CHECK(scenario.displays.background[2] == 7);
    CHECK(scenario.renderers[0].frames[1].viewport.has_value());
    CHECK(scenario.renderers[0].frames[1].table_line == 0);
    CHECK(scenario.faults.empty());
    const std::string minimal = ScenarioFixture::minimal();
    CHECK(fixture.parse(minimal, {"bus.width_bits=32"}).bus.width_bits == 32);
    CHECK(fixture.parse(minimal, {"composer.on_starvation=stall"}).composer.on_starvation ==
          StarvationMode::kStall);
    CHECK(fixture.parse(minimal, {"renderers.0.name=cube"}).renderers[0].name == "cube");
    CHECK(fixture.parse(minimal, {"renderers.0.frames.0.viewport.multiple=2"}).renderers[0].frames[0].table ==
          ViewportTable{{1, 0, 0, 8, 4, 0, 0, 2}});
    CHECK(fixture.parse("bus:\n" + minimal, {"bus.width_bits=32"}).bus.width_bits == 32);
    check_refusals(complaint_of(fixture))({
        {"faults.0.pair=3",
         "faults[0]: is out of range; faults has no entries to override; use the whole list as the value"},
        {"renderers.1.name=cube", "renderers[1]: is out of range; use an index of renderers, 0 to 0"},
        {"renderers[99999999999999999999].name=a",
         "renderers: '99999999999999999999' is not an index; use an index of renderers, 0 to 0"},
        {"renderers.-1.name=a", "renderers: '-1' is not an index; use an index of renderers, 0 to 0"},
        {"renderers.name=a", "renderers: 'name' is not an index; use an index of renderers, 0 to 0"},
    });
    check_text(complaint_of(fixture, kTwoFrames)("renderers.0.frames.2.viewport.x=1"),
               "renderers[0].frames[2]: is out of range; use an index of renderers[0].frames, 0 to 1");
}

TEST_CASE("override: an unknown key names the nearest, and errors name it in place of file and line") {
    const ScenarioFixture fixture;
    const std::string minimal = ScenarioFixture::minimal();
    check_refusals(complaint_of(fixture))({
        {"bus.widht_bits=32", "bus.widht_bits: is not a known key; the nearest is bus.width_bits"},
        {"buss.width_bits=32", "buss: is not a known key; the nearest is bus"},
        {"renderers.0.frames.0.viewport.mutiple=2",
         "renderers[0].frames[0].viewport.mutiple: is not a known key; the nearest is "
         "renderers[0].frames[0].viewport.multiple"},
        {"bus={width: 32}", "bus.width: is not a known key; the nearest is displays.width"},
        {"bus[0]=32", "bus.0: is not a known key; ..."},
        {"frames.x=1", "frames: has nothing inside; use --set frames=VALUE"},
        {"bus.width_bits=33", "bus.width_bits: 33 is not a bus width; use 16, 32, 64, 128, 256 or 512"},
        {"frames=", "frames: is nothing; use 1 to 1000000"},
        {"frames=010", "frames: '010' has a leading zero; use 1 to 1000000, in decimal digits"},
        {"depth_range=[2, 2]", "depth_range: near and far are both 2; use two different depths"},
        {"composer.ready_space_pixels=1",
         "composer.ready_space_pixels: 1 is less than the 2 pixels that can be in flight; use 2 or more"},
        {"bus=[1", "not valid YAML: ..."},
        {"frames=,", "text goes on after the end of ..."},
        {"bus={width_bits: 32, width_bits: 64}",
         "width_bits: is here twice, first already; use each key once in a map"},
    });
    CHECK(fixture.error(minimal, {"name=\"a\\\nb\n\nc\""}).find('\n') == std::string::npos);
    CHECK(fixture.error(minimal, {"renderers.0.frames.0.image=none.png"}) ==
          "--set renderers.0.frames.0.image=none.png: renderers[0].frames[0].image: " +
              (fixture.directory() / "none.png").string() + ": cannot be read: No such file or directory");
    CHECK(fixture.error("bus: 3\n" + minimal, {"bus.width_bits=32"}) ==
          "test.yaml:1: bus: is '3'; use a map with the keys width_bits, burst_pixels, arbitration, "
          "grant_cycles, slot_table and register_stages");
    CHECK(fixture.error("renderers: 3\n", {"renderers.0.name=a"}) ==
          "test.yaml:1: renderers: is '3'; use a list of renderers");
    for (const std::string path : {".", "bus.", ".bus", "bus..width_bits", "renderers[0", "renderers[]",
                                   "[0]", "renderers[0]name", "renderers]0["}) {
        INFO(path);
        const bool is_path = path == "renderers]0[";
        check_text(complaint_of(fixture)(path + "=1"),
                   is_path ? "..."
                           : "...is not a key path; use keys and indices with dots, like "
                             "renderers.0.frames.1.viewport.x...");
    }
}

}  // namespace metabuffer::test
