#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "scenario/scenario_rules.h"
#include "scenario/scenario_writer.h"
#include "support/scenario_difference.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

std::string with_copies(const std::string& copies) {
    return "displays: {width: 16, height: 8}\n"
           "renderers:\n"
           "  - {name: ball, frames: [{image: image.exr, viewport: {x: 0, y: 0}}]}\n"
           "  - name: cube\n"
           "    copies: " +
           copies +
           "\n"
           "    frames:\n"
           "      - {image: image.exr, viewport: {x: 3, y: 0}}\n"
           "      - {image: image.exr, table: [[1, 0, 0, 16, 8, 0, 0, 1]]}\n"
           "  - {frames: [{image: image.exr, viewport: {x: 0, y: 1}}]}\n";
}

std::vector<std::string> names_of(const Scenario& scenario) {
    std::vector<std::string> names;
    for (const Renderer& renderer : scenario.renderers) names.push_back(renderer.name);
    return names;
}

}  // namespace

TEST_CASE("copies: as many renderers of the same frames that share their images, and are written out") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(with_copies("3"));
    CHECK(names_of(scenario) == std::vector<std::string>{"ball", "cube_1", "cube_2", "cube_3", "renderer_3"});
    for (std::size_t i = 1; i <= 3; ++i) {
        INFO(i);
        const Renderer& copy = scenario.renderers[i];
        REQUIRE(copy.images.size() == 1);
        CHECK(copy.images[0] == scenario.renderers[0].images[0]);
        CHECK(copy.image_width_pixels == 16);
        CHECK(copy.image_height_pixels == 8);
        REQUIRE(copy.frames.size() == 2);
        CHECK(copy.frames[0].table == ViewportTable{{1, 0, 0, 13, 8, 3, 0, 1}});
        CHECK(copy.frames[1].table == ViewportTable{{1, 0, 0, 16, 8, 0, 0, 1}});
        CHECK(copy.frames[1].table_line == 8);
    }
    CHECK(scenario.renderers[4].frames[0].viewport->y == 1);
    CHECK(scenario.frames == 2);
    CHECK_NOTHROW(check_scenario(scenario));
    CHECK(names_of(fixture.parse(with_copies("1"))) ==
          std::vector<std::string>{"ball", "cube", "renderer_3"});
    // The default name counts the file's entries.
    CHECK(names_of(fixture.parse(ScenarioFixture::minimal(), {"renderers.0.copies=2"})) ==
          std::vector<std::string>{"renderer_1_1", "renderer_1_2"});
    const ScratchDirectory directory;
    write_scenario(scenario, directory.path());
    const Scenario loaded = load_scenario(directory / "scenario.yaml");
    CHECK(scenario_difference(scenario, loaded).empty());
    CHECK(names_of(loaded) == names_of(scenario));
}

TEST_CASE("copies: faults name one of them, and what is wrong is reported at the entry that makes them") {
    const ScenarioFixture fixture;
    const auto with_fault = [](const std::string& renderer) {
        return with_copies("3") + "faults: [{renderer: " + renderer + ", pair: 0, kind: crc}]\n";
    };
    CHECK(fixture.parse(with_fault("cube_2")).faults[0].renderer == 2);
    CHECK(fixture.parse(with_fault("renderer_3")).faults[0].renderer == 4);
    CHECK(fixture.error(with_fault("cube")) ==
          "test.yaml:10: faults[0].renderer: 'cube' is not a renderer; the nearest is cube_1");
    const std::string at = "test.yaml:5: renderers[1].copies: ";
    fixture.check_refusals({
        {with_copies("0"), at + "0 is out of range; use 1 to 65536"},
        {with_copies("65537"), at + "65537 is out of range; use 1 to 65536"},
        {with_copies("'2'"), at + "'2' is not a whole number; use 1 to 65536 without quotation marks"},
        {with_copies("two"), at + "'two' is not a whole number; use 1 to 65536"},
        {with_copies("65536"),
         at + "makes 65537 renderers and 131072 frames so far; use at most 65536 and 1000000"},
        {with_copies("65535"),
         "test.yaml:2: renderers: 65537 renderers on 1 displays need 65537 composers; use at most 65536, "
         "which is "
         "65536 renderers"},
        // ball, cube_1 to cube_3: the third entry is the machine's fifth renderer.
        {with_copies("3"),
         {"renderers.2.name=cube_2"},
         "--set renderers.2.name=cube_2: renderers[2].name: 'cube_2' is taken by an earlier renderer; use a "
         "name of its own"},
        {with_copies("3"),
         {"renderers.0.name=cube_2"},
         "test.yaml:4: renderers[1].name: 'cube_2' is taken by an earlier renderer; use a name of its own"},
    });
    write_black(fixture.directory() / "large.exr", 16, 9);
    CHECK(fixture.error(with_copies("3"), {"renderers.1.frames.1.image=large.exr"})
              .find(": renderers[1].frames[1].image: the image has 16 x 9 pixels, ") != std::string::npos);
}

TEST_CASE("copies: a great many are one image and little time") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(ScenarioFixture::minimal(), {"renderers.0.copies=65536"});
    REQUIRE(scenario.renderers.size() == 65536);
    CHECK(scenario.renderers.back().name == "renderer_1_65536");
    CHECK(scenario.renderers.back().images == scenario.renderers.front().images);
    CHECK(scenario.renderers.front().images[0].use_count() <= 65537);
}

}  // namespace metabuffer::test
