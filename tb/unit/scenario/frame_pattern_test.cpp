#include "scenario/frame_pattern.h"

#include <optional>
#include <string>
#include <vector>

#include "scenario/scenario_template.h"
#include "scenario/scenario_writer.h"
#include "scenario_fixture.h"

using namespace metabuffer;
using test::check_refusals;
using test::ScenarioFixture;
using test::write_black;

namespace {

const std::string kHead = "displays: {width: 16, height: 8}\nrenderers:\n  - frames:\n";

std::string with_entry(const std::string& members) { return kHead + "      - {" + members + "}\n"; }

std::vector<std::string> image_names(const Scenario& scenario) {
    std::vector<std::string> names;
    const Renderer& renderer = scenario.renderers.front();
    for (const RendererFrame& frame : renderer.frames) {
        names.push_back(
            scenario.image_files.at(renderer.images[frame.image].get()).image.filename().string());
    }
    return names;
}

}  // namespace

TEST_CASE("frames: numbers and names") {
    const auto numbers = input::parse_frame_numbers("8-12");
    REQUIRE(numbers);
    CHECK((numbers->first == 8 && numbers->last == 12 && numbers->count() == 5));
    CHECK(input::parse_frame_numbers("7")->count() == 1);
    for (const char* wrong : {"", "-", "3-", "-3", "3-2", "a-b", "1-2-3", "1 - 2", "1.5", "99999999999"}) {
        INFO(wrong);
        CHECK_FALSE(input::parse_frame_numbers(wrong));
    }
    CHECK(input::numbered_name("f%d.png", 7) == "f7.png");
    CHECK(input::numbered_name("f%04d.png", 7) == "f0007.png");
    CHECK(input::numbered_name("%02d", 123) == "123");
    CHECK(input::numbered_name("still.png", 7) == "still.png");
    for (const char* wrong : {"f%.png", "f%4d.png", "f%0d.png", "%d-%d", "f%", "f%04", "f%x"}) {
        INFO(wrong);
        CHECK_FALSE(input::numbered_name(wrong, 7));
    }
}

TEST_CASE("frames: a viewport moves evenly between the positions of its path") {
    const std::vector<input::PathPosition> path{{10, {0, 100, 2}}, {14, {10, 90, 3}}, {16, {-5, 90, 1}}};
    const auto at = [&path](int frame) {
        const Viewport viewport = viewport_on_path(path, frame);
        return std::vector<int>{viewport.x, viewport.y, viewport.multiple};
    };
    CHECK(at(0) == std::vector<int>{0, 100, 2});
    CHECK(at(10) == std::vector<int>{0, 100, 2});
    CHECK(at(11) == std::vector<int>{3, 97, 2});  // 2.5 and 97.5, a half away from where it comes from
    CHECK(at(12) == std::vector<int>{5, 95, 2});
    CHECK(at(14) == std::vector<int>{10, 90, 3});
    CHECK(at(15) == std::vector<int>{2, 90, 3});  // 2.5
    CHECK(at(16) == std::vector<int>{-5, 90, 1});
    CHECK(at(99) == std::vector<int>{-5, 90, 1});
    // The longest paths that a scenario can have.
    const std::vector<input::PathPosition> far{{0, {-1'000'000'000, 0, 1}},
                                               {2'000'000'000, {1'000'000'000, 0, 1}}};
    CHECK(viewport_on_path(far, 1'000'000'001).x == 1);
}

TEST_CASE("frames: a range stands for a list of frames, of images or a still one, and is written as one") {
    const ScenarioFixture fixture;
    for (const char* name : {"f08.exr", "f09.exr", "f10.exr"}) write_black(fixture.directory() / name, 16, 8);
    const Scenario scenario =
        fixture.parse(with_entry("image: 'f%02d.exr', frames: 8-10, viewport: {path: [{frame: 8, x: 0, y: "
                                 "4}, {frame: 10, x: 8, y: 0, multiple: 2}]}") +
                      "      - {image: image.exr, viewport: {x: 1, y: 1}}\n");
    CHECK(scenario.frames == 4);
    CHECK(image_names(scenario) == std::vector<std::string>{"f08.exr", "f09.exr", "f10.exr", "image.exr"});
    CHECK(scenario.renderers[0].frames[1].viewport->x == 4);
    CHECK(scenario.renderers[0].frames[1].viewport->y == 2);
    CHECK(scenario.renderers[0].frames[1].viewport->multiple == 1);
    CHECK(scenario.renderers[0].frames[2].viewport->multiple == 2);

    const std::string written = effective_scenario(scenario, fixture.directory().path());
    const Scenario again = fixture.parse(written);
    CHECK(image_names(again) == image_names(scenario));
    CHECK(effective_scenario(again, fixture.directory().path()) == written);
    const Scenario moving = fixture.parse(with_entry(
        "image: image.exr, frames: 0-4, viewport: {path: [{frame: 0, x: 0, y: 0}, {frame: 4, x: 8, y: 0}]}"));
    REQUIRE(moving.renderers[0].frames.size() == 5);
    CHECK(moving.renderers[0].images.size() == 1);
    CHECK(moving.renderers[0].frames[3].viewport->x == 6);
    const Scenario table =
        fixture.parse(with_entry("image: image.exr, frames: 0-2, table: [[0, 0, 0, 16, 8, 0, 0, 1]]"));
    CHECK(table.renderers[0].frames[2].table == table.renderers[0].frames[0].table);
    CHECK(fixture.parse(with_entry("image: image.exr, frames: 5, viewport: {x: 0, y: 0}")).frames == 1);
    const ScenarioTemplate scenarios(
        with_entry("image: 'f%d.exr', depth: 'd%02d.exr', frames: 9-10, viewport: {x: 0, y: 0}"), "test.yaml",
        fixture.directory().path());
    std::vector<std::string> names;
    for (const auto& file : scenarios.input_files({})) names.push_back(file.filename().string());
    CHECK(names == std::vector<std::string>{"d09.exr", "d10.exr", "f10.exr", "f9.exr"});
}

TEST_CASE("frames: depth files have numbers, too") {
    const ScenarioFixture fixture;
    write_black(fixture.directory() / "c0.png", 16, 8);
    for (const char* name : {"d0.exr", "d1.exr"}) write_black(fixture.directory() / name, 16, 8);
    const Scenario scenario =
        fixture.parse(with_entry("image: c0.png, depth: 'd%d.exr', frames: 0-1, viewport: {x: 0, y: 0}"));
    const Renderer& renderer = scenario.renderers.front();
    REQUIRE(renderer.images.size() == 2);
    for (std::size_t n = 0; n < 2; ++n) {
        const ImageFiles& files = scenario.image_files.at(renderer.images[n].get());
        CHECK(files.image.filename() == "c0.png");
        CHECK(files.depth->filename() == "d" + std::to_string(n) + ".exr");
    }
}

TEST_CASE("frames: what is wrong with a range, a path or a frame of it is reported in one line") {
    const ScenarioFixture fixture;
    const std::string where = "test.yaml:4: renderers[0].frames[0].";
    const auto error = [&fixture](const std::string& members) { return fixture.error(with_entry(members)); };
    const std::string path = "viewport: {path: [{frame: 0, x: 0, y: 0}]}";
    check_refusals(error)({
        {"image: image.exr, " + path,
         where + "viewport.path: goes with a range of frames; add frames, such as 0-29, next to the image"},
        {"image: image.exr, frames: 9-3, " + path,
         where + "frames: '9-3' is not a range; use numbers such as 0-299"},
        {"image: image.exr, frames: 0-100000, " + path,
         where + "frames: makes 100001 frames so far; use at most 100000"},
        {"image: image.exr, frames: 1-3, " + path,
         where + "viewport.path: goes from frame 0 to 0; use frames of 1-3"},
        {"image: 'f%4d.exr', frames: 0-3, " + path,
         where + "image: 'f%4d.exr' has a % that is no number's; use one %d, or %04d for four digits"},
        {"image: image.exr, frames: 0-3, viewport: {x: 0, path: [{frame: 0, x: 0, y: 0}]}",
         where + "viewport.x: is given together with a path, which has its own; use one of the two"},
        {"image: image.exr, frames: 0-3, viewport: {path: []}",
         where + "viewport.path: has no positions; use at least one"},
        {"image: image.exr, frames: 0-3, viewport: {path: [{frame: 2, x: 0, y: 0}, {frame: 2, x: 1, "
         "y: 0}]}",
         where + "viewport.path[1].frame: 2 does not come after 2; use a later frame"},
        {"image: image.exr, frames: 0-3, viewport: {path: [{frame: 2, x: 0}]}",
         "...viewport.path[0].y: is missing..."},
        {"image: 'f%d.exr', frames: 3-4, viewport: {x: 0, y: 0}", "...f3.exr..."},
    });
    write_black(fixture.directory() / "f0.exr", 16, 8);
    write_black(fixture.directory() / "f1.exr", 24, 8);
    const std::string message =
        fixture.error(with_entry("image: 'f%d.exr', frames: 0-1, viewport: {x: 0, y: 0}"));
    CHECK(message.find("test.yaml:4: renderers[0].frames[0]") == 0);
    CHECK(message.find("(frame 1)") != std::string::npos);
}
