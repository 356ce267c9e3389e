#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "formats/control_scanline.h"
#include "scenario/scenario_template.h"
#include "unit/scenario/picture_files.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

/// A renderer with the given lines as its one frame, which stands on line 4.
std::string with_frame(const std::string& lines) {
    return std::string(ScenarioFixture::kDisplays) + "renderers:\n  - frames:\n" + lines;
}

/// A frame whose table stands on line 5, its rows on line 6 and following.
std::string with_rows(const std::vector<std::string>& rows) {
    std::string text = with_frame("      - image: image.exr\n        table:\n");
    for (const std::string& row : rows) text += "          - " + row + "\n";
    return text;
}

std::string with_faults(const std::vector<std::string>& faults) {
    std::string text =
        "displays: {width: 16, height: 8}\n"
        "renderers:\n"
        "  - {name: ball, frames: [{image: image.exr, viewport: {x: 0, y: 0}}]}\n"
        "  - {name: cube, frames: [{image: image.exr, viewport: {x: 0, y: 0}}]}\n"
        "faults:\n";
    for (const std::string& fault : faults) text += "  - " + fault + "\n";
    return text;
}

}  // namespace

TEST_CASE("renderers: names are unique; each has frames, each frame an image and a viewport or a table") {
    const ScenarioFixture fixture;
    const std::string frames = "frames: [{image: image.exr, viewport: {x: 0, y: 0}}]";
    const std::string head = std::string(ScenarioFixture::kDisplays) + "renderers:\n";
    const Scenario scenario = fixture.parse(head + "  - {" + frames + "}\n  - {name: ball, " + frames +
                                            "}\n  - {" + frames + "}\n");
    REQUIRE(scenario.renderers.size() == 3);
    CHECK(scenario.renderers[0].name == "renderer_1");
    CHECK(scenario.renderers[1].name == "ball");
    CHECK(scenario.renderers[2].name == "renderer_3");
    CHECK(fixture.error(head + "  - {name: ball, " + frames + "}\n  - {name: ball, " + frames + "}\n") ==
          "test.yaml:4: renderers[1].name: 'ball' is taken by an earlier renderer; use a name of its own");
    CHECK(fixture.error(head + "  - {name: renderer_2, " + frames + "}\n  - {" + frames + "}\n") ==
          "test.yaml:4: renderers[1].name: 'renderer_2' is taken by an earlier renderer; use a name of its "
          "own");
    CHECK(fixture.error(head + "  - {name: '', " + frames + "}\n") ==
          "test.yaml:3: renderers[0].name: is empty; use the renderer's name, on one line");
    fixture.check_refusals({
        {head + "  - name: ball\n",
         "test.yaml:3: renderers[0].frames: is missing; use a list of at least one frame"},
        {head + "  - name: ball\n    frames: []\n",
         "test.yaml:4: renderers[0].frames: has no entries; use at least one frame"},
        {head + "  - ball\n",
         "test.yaml:3: renderers[0]: is 'ball'; use a map with the keys name, copies, live and "
         "frames"},
        {head + "  - name: ball\n    frames: {image: image.exr}\n",
         "test.yaml:4: renderers[0].frames: is a map; use a list of frames, each with an image and a "
         "viewport, a table or controls"},
        {with_frame("      - viewport: {x: 0, y: 0}\n"),
         "test.yaml:4: renderers[0].frames[0].image: is missing; use a file name, on one line"},
        {with_frame("      - image: image.exr\n"),
         "test.yaml:4: renderers[0].frames[0]: has neither a viewport nor a table; use one of the two"},
        {with_frame("      - image: image.exr\n"
                    "        viewport: {x: 0, y: 0}\n"
                    "        table: []\n"),
         "test.yaml:6: renderers[0].frames[0].table: is given together with a viewport; use one of the two"},
    });
    const std::string frame = "{image: image.exr, viewport: {x: 0, y: 0}}";
    const std::string text = std::string(ScenarioFixture::kDisplays) + "renderers:\n  - frames: [" + frame +
                             "]\n  - frames: [" + frame + ", " + frame + ", " + frame + "]\n  - frames: [" +
                             frame + ", " + frame + "]\n";
    CHECK(fixture.parse(text).frames == 3);
    CHECK(fixture.parse("frames: 1\n" + text).frames == 1);
    CHECK(fixture.parse(text, {"frames=7"}).frames == 7);
}

TEST_CASE("renderers: viewports, and tables, which are used as they are") {
    const ScenarioFixture fixture;
    const auto error = [&fixture](const std::string& viewport) {
        return fixture.error(with_frame("      - image: image.exr\n        viewport:\n" + viewport));
    };
    const std::string path = "renderers[0].frames[0].viewport";
    check_refusals(error)({
        {"          y: 0\n", "test.yaml:5: " + path + ".x: is missing; use -1000000000 to 1000000000"},
        {"          x: 0\n", "test.yaml:5: " + path + ".y: is missing; use -1000000000 to 1000000000"},
        {"          x: 0.5\n          y: 0\n",
         "test.yaml:6: " + path + ".x: '0.5' is not a whole number; use -1000000000 to 1000000000"},
        {"          x: 0\n          y: 2000000000\n",
         "test.yaml:7: " + path + ".y: 2000000000 is out of range; use -1000000000 to 1000000000"},
    });
    for (const std::string wrong : {"0", "256", "-1"}) {
        std::string viewport = "          x: 0\n          y: 0\n          multiple: ";
        viewport += wrong;
        viewport += '\n';
        std::string expected = "test.yaml:8: renderers[0].frames[0].viewport.multiple: ";
        expected += wrong;
        expected += " is out of range; use 1 to 255";
        CHECK(error(viewport) == expected);
    }
    // Wholly outside the wall is no error: the renderer shows nothing.
    const Scenario scenario = fixture.parse(
        with_frame("      - {image: image.exr, viewport: {x: -1000000000, y: 1000000000, multiple: 255}}\n"));
    CHECK(scenario.renderers[0].frames[0].table.empty());
    const auto table = [&fixture](const std::vector<std::string>& rows) {
        return fixture.parse(with_rows(rows)).renderers[0].frames[0].table;
    };
    CHECK(table({"[1, 0, 0, 16, 8, 0, 0, 1]"}) == ViewportTable{{1, 0, 0, 16, 8, 0, 0, 1}});
    // No such display, no such rectangle: the machine drops and counts it.
    CHECK(table({"[65535, 65535, 65535, 65535, 65535, 32767, 32767, 65535]"}) ==
          ViewportTable{{65535, 65535, 65535, 65535, 65535, 32767, 32767, 65535}});
    CHECK(table({"[0, 0, 0, 0, 0, -32768, -32768, 0]"}) == ViewportTable{{0, 0, 0, 0, 0, -32768, -32768, 0}});
    const Scenario none = fixture.parse(with_frame("      - {image: image.exr, table: []}\n"));
    CHECK(none.renderers[0].frames[0].table.empty());
    CHECK_FALSE(none.renderers[0].frames[0].viewport.has_value());
    CHECK(fixture.parse(with_rows({"[1, 0, 0, 16, 8, 0, 0, 1]"})).renderers[0].frames[0].table_line == 5);
}

TEST_CASE("renderers: a table's fields must fit") {
    const ScenarioFixture fixture;
    const std::string path = "renderers[0].frames[0].table";
    const std::string eight = "use eight, [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]";
    fixture.check_refusals({
        {with_rows({"[1, 0, 0, 16, 8, 0, 0]"}), "test.yaml:6: " + path + "[0]: has 7 entries; " + eight},
        {with_rows({"[1, 0, 0, 16, 8, 0, 0, 1, 1]"}),
         "test.yaml:6: " + path + "[0]: has 9 entries; " + eight},
        {with_rows({"[1, 0, 0, 16, 8, 0, 0, 1]", "3"}),
         "test.yaml:7: " + path +
             "[1]: is '3'; use a row of eight whole numbers, [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"},
        {with_frame("      - {image: image.exr, table: all}\n"),
         "test.yaml:4: " + path +
             ": is 'all'; use a list of rows, each [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"},
    });
    const std::vector<std::string> good{"1", "0", "0", "16", "8", "0", "0", "1"};
    for (std::size_t field = 0; field < good.size(); ++field) {
        const bool is_signed = field == 5 || field == 6;
        const std::string use = is_signed ? "use -32768 to 32767" : "use 0 to 65535";
        const std::vector<std::string> wrong =
            is_signed ? std::vector<std::string>{"-32769", "32768"} : std::vector<std::string>{"-1", "65536"};
        for (const std::string& value : wrong) {
            std::vector<std::string> fields = good;
            fields[field] = value;
            std::string row;
            for (const std::string& one : fields) row += (row.empty() ? "[" : ", ") + one;
            row += ']';
            std::string expected = "test.yaml:6: renderers[0].frames[0].table[0][";
            expected += std::to_string(field);
            expected += "]: ";
            expected += value;
            expected += " is out of range; ";
            expected += use;
            CHECK(fixture.error(with_rows({row})) == expected);
        }
    }
    CHECK(fixture.error(with_rows({"[one, 0, 0, 16, 8, 0, 0, 1]"})) ==
          "test.yaml:6: " + path + "[0][0]: 'one' is not a whole number; use 0 to 65535");
}

TEST_CASE("renderers: a frame may give the host's slot table, by display") {
    const ScenarioFixture fixture;
    const std::string table = "table: [[1, 0, 0, 8, 8, 0, 0, 1]]";
    const auto slots = [&](const std::string& keys) {
        return fixture.parse(with_frame("      - {image: image.exr, " + keys + "}\n"))
            .renderers[0]
            .frames[0]
            .slots;
    };
    CHECK_FALSE(slots(table));
    CHECK(slots(table + ", slots: [1, 1]") == std::vector<int>{1, 1});
    CHECK(slots(table + ", slots: []") == std::vector<int>{});  // none is sent
    CHECK(slots("viewport: {x: 0, y: 0}, slots: [1]") == std::vector<int>{1});

    const auto error_of = [&](const std::string& keys) {
        return fixture.error(with_frame("      - {image: image.exr, " + keys + "}\n"));
    };
    const std::string path = "test.yaml:4: renderers[0].frames[0].slots";
    CHECK(error_of(table + ", slots: [1, 2]") == path + ": display 2 has no row; use displays that have one");
    CHECK_THAT(error_of(table + ", slots: 1"),
               Catch::Contains(path) && Catch::Contains("a list of displays"));
    CHECK_THAT(error_of(table + ", slots: [one]"), Catch::Contains(path + "[0]"));
    std::string many = "1";
    for (int slot = 1; slot < 300; ++slot) many += ", 1";
    CHECK(error_of(table + ", slots: [" + many.substr(0, 208 * 3 - 2) + "]").empty());
    CHECK(error_of(table + ", slots: [" + many + "]") ==
          path +
              ": 300 slots do not fit the control scanline of an image 16 pixels wide; use 208 at the most "
              "or a wider image");
}

TEST_CASE("renderers: a frame may have the control scanlines as an application wrote them") {
    const ScenarioFixture fixture;
    const auto with_controls = [](const std::string& controls) {
        return with_frame("      - {image: image.exr, controls: " + controls + "}\n");
    };
    constexpr int kWidth = 16;
    ControlScanline colour;
    colour.frame_number = 7;
    colour.table = {{1, 0, 0, 8, 8, 0, 0, 1}};
    ControlScanline depth;
    depth.kind = FrameKind::kDepth;
    depth.frame_number = 7;
    depth.payload = {'S', 1, 1, 0, 0};
    const std::string sent = hex_of_scanline(encode_control_scanline(colour, kWidth));
    const std::string other = hex_of_scanline(encode_control_scanline(depth, kWidth));
    CHECK(hex_of_scanline({0x102030, 0x400000, 0, 0}) == "10203040");  // zeros at its end need not be written
    const RendererFrame frame =
        fixture.parse(with_controls("['" + sent + "', '" + other + "']")).renderers[0].frames[0];
    REQUIRE(frame.controls);
    CHECK(frame.controls->number == 7U);
    CHECK(frame.controls->payload == depth.payload);
    CHECK(frame.table == colour.table);
    CHECK(frame.controls->colour == encode_control_scanline(colour, kWidth));
    // What no decoder takes for a pair is sent all the same: two colour frames, other numbers, nothing at all.
    ++depth.frame_number;
    for (const std::string& second :
         {sent, hex_of_scanline(encode_control_scanline(depth, kWidth)), std::string()}) {
        const Scenario scenario = fixture.parse(with_controls("['" + sent + "', '" + second + "']"));
        CHECK_FALSE(scenario.renderers[0].frames[0].controls->number);
        CHECK(scenario.renderers[0].frames[0].table == colour.table);
    }
    const std::string path = "test.yaml:4: renderers[0].frames[0].controls";
    const std::string use =
        "is not a control scanline; use two hexadecimal digits for each byte, at most 48 bytes";
    CHECK(fixture.error(with_controls("['0g', '']")) == path + "[0]: " + use);
    CHECK(fixture.error(with_controls("['', '012']")) == path + "[1]: " + use);
    CHECK(fixture.error(with_controls("['', '" + std::string(98, '0') + "']")) == path + "[1]: " + use);
    CHECK(fixture.error(with_controls("['']")) == path + ": has 1 entries; use two, [colour, depth]");
    CHECK(fixture.error(
              with_frame("      - {image: image.exr, viewport: {x: 0, y: 0}, controls: ['', '']}\n")) ==
          path + ": is given together with a viewport; use one of the two");
    CHECK(
        fixture.error(with_controls("['" + sent + "', '" + other + "']") +
                      "faults:\n  - {renderer: renderer_1, kind: number, pair: 0}\n") ==
        "test.yaml:6: faults[0].kind: number changes control scanlines that the host makes, and the pair has "
        "controls; use other controls");
}

TEST_CASE("renderers: one is live in place of frames, where that is accepted") {
    const ScenarioFixture fixture;
    const auto with_live = [](const std::string& keys) {
        return std::string(ScenarioFixture::kDisplays) + "renderers:\n  - {name: one, " + keys + "}\n";
    };
    const auto accepted = [&fixture](const std::string& text) {
        return ScenarioTemplate(text, "test.yaml", fixture.directory().path())
            .scenario({}, LiveRenderers::kAccepted);
    };
    const Scenario scenario = accepted(with_live("copies: 2, live: {width: 20, height: 9}"));
    REQUIRE(scenario.renderers.size() == 2);
    for (const Renderer& renderer : scenario.renderers) {
        CHECK(renderer.is_live);
        CHECK(renderer.image_width_pixels == 20);
        CHECK(renderer.image_height_pixels == 9);
        REQUIRE(renderer.frames.size() == 1);
        CHECK(renderer.frames[0].table.empty());
        CHECK(renderer.image_of_pair(0).at(19, 8).z() == far_z(scenario.depth_format));
    }
    const std::string path = "test.yaml:3: renderers[0].live";
    fixture.check_refusals({
        {with_live("live: {width: 20, height: 9}"),
         path + ": gets its images from an application; use metabuffer live, or frames with images"},
        {with_live("live: {width: 20}"), path + ".height: is missing; use 1 to 8192"},
        {with_live("live: {width: 20, height: 9}, frames: []"),
         path + ": is given together with frames; use one of the two"},
    });
    const std::string fault = "faults:\n  - {renderer: one, kind: missing, pair: 0, frame: colour}\n";
    CHECK(input_error_of([&] { accepted(with_live("live: {width: 20, height: 9}") + fault); }) ==
          "test.yaml:5: faults[0].kind: missing says whether a pair comes, and that of a live renderer comes "
          "from its "
          "application; use another kind");
}

TEST_CASE("renderers: a table must fit the control scanline") {
    const ScenarioFixture fixture;
    const std::string row = "[1, 0, 0, 16, 8, 0, 0, 1]";
    CHECK(fixture.error(with_rows({row, row})) ==
          "test.yaml:5: renderers[0].frames[0].table: the table of 2 rows needs 50 bytes and the control "
          "scanline of an image 16 pixels wide has 48; use fewer rows or an image at least 17 pixels wide");
    const std::string wall = "displays: {width: 16, height: 8, columns: 2}\n";
    CHECK(fixture.error(
              wall + "renderers:\n  - frames:\n      - image: image.exr\n        viewport: {x: 8, y: 0}\n") ==
          "test.yaml:5: renderers[0].frames[0].viewport: the table of 2 rows needs 50 bytes and the control "
          "scanline of an image 16 pixels wide has 48; use fewer rows or an image at least 17 pixels wide");
    write_black(fixture.directory() / "narrow.exr", 6, 2);
    CHECK(fixture.error(with_frame("      - {image: narrow.exr, table: []}\n")).empty());
    write_black(fixture.directory() / "narrow.exr", 5, 2);
    CHECK(fixture.error(with_frame("      - {image: narrow.exr, table: []}\n")) ==
          "test.yaml:4: renderers[0].frames[0].table: the table of 0 rows needs 18 bytes and the control "
          "scanline of an image 5 pixels wide has 15; use fewer rows or an image at least 6 pixels wide");
    CHECK(fixture.error(with_rows({row}), {"renderers.0.frames.0.table=[" + row + "," + row + "]"})
              .rfind("--set renderers.0.frames.0.table=[", 0) == 0);
}

TEST_CASE("renderers: each different pair of files is read once, relative to the scenario or absolute") {
    const ScenarioFixture fixture;
    write_black(fixture.directory() / "other.exr", 16, 8);
    write_picture(fixture.directory() / "depth.png", 16, 8, {{"Y"}, OIIO::TypeDesc::UINT16},
                  std::vector<std::uint16_t>(std::size_t{16} * 8, 700));
    const std::string viewport = "viewport: {x: 0, y: 0}}\n";
    const Scenario scenario = fixture.parse(with_frame(
        "      - {image: image.exr, " + viewport + "      - {image: other.exr, " + viewport +
        "      - {image: image.exr, " + viewport + "      - {image: image.exr, depth: depth.png, " +
        viewport + "      - {image: other.exr, depth: depth.png, " + viewport +
        "      - {image: image.exr, depth: depth.png, " + viewport));
    const Renderer& renderer = scenario.renderers[0];
    CHECK(renderer.images.size() == 4);
    std::vector<std::size_t> indices;
    for (const RendererFrame& frame : renderer.frames) indices.push_back(frame.image);
    CHECK(indices == std::vector<std::size_t>{0, 1, 0, 2, 3, 2});
    CHECK(renderer.images[0]->pixels().at(3, 3).z() == 0);
    CHECK(renderer.images[2]->pixels().at(3, 3).z() == 700);
    std::filesystem::create_directories(fixture.directory() / "images");
    write_black(fixture.directory() / "images/small.exr", 12, 3);
    fixture.directory().write("images/scenario.yaml",
                              with_frame("      - {image: ../image.exr, viewport: {x: 0, y: 0}}\n"));
    CHECK(load_scenario(fixture.directory() / "images/scenario.yaml").renderers[0].image_width_pixels == 16);
    CHECK(fixture.parse(with_frame("      - {image: images/small.exr, viewport: {x: 0, y: 0}}\n"))
              .renderers[0]
              .image_width_pixels == 12);
    const Scenario absolute =
        parse_scenario(with_frame("      - {image: " + (fixture.directory() / "image.exr").string() +
                                  ", viewport: {x: 0, y: 0}}\n"),
                       "test.yaml", "/nowhere");
    CHECK(absolute.renderers[0].image_height_pixels == 8);
}

TEST_CASE("renderers: renderers that name the same files share their image") {
    const ScenarioFixture fixture;
    write_black(fixture.directory() / "other.exr", 16, 8);
    const std::string viewport = "viewport: {x: 0, y: 0}}\n";
    const std::string image = "      - {image: image.exr, " + viewport;
    const std::string other = "      - {image: other.exr, " + viewport;
    const std::string next = "  - frames:\n";
    const Scenario scenario = fixture.parse(with_frame(image + next + other + image + next + image));
    REQUIRE(scenario.renderers.size() == 3);
    const std::vector<Renderer>& renderers = scenario.renderers;
    CHECK(renderers[1].images.size() == 2);
    CHECK(renderers[1].images[0] != renderers[0].images[0]);
    CHECK(renderers[1].images[1] == renderers[0].images[0]);
    CHECK(renderers[2].images[0] == renderers[0].images[0]);
    CHECK(&renderers[1].image_of_pair(1) == &renderers[2].image_of_pair(0));
}

TEST_CASE("renderers: images of one size, with Z, and what is wrong with one, have their line") {
    const ScenarioFixture fixture;
    const std::string folder = fixture.directory().path().string();
    write_black(fixture.directory() / "wide.exr", 17, 8);
    write_picture(fixture.directory() / "depth.png", 16, 7, {{"Y"}, OIIO::TypeDesc::UINT16},
                  std::vector<std::uint16_t>(std::size_t{16} * 7));
    const std::string first =
        "      - image: image.exr\n"
        "        viewport: {x: 0, y: 0}\n";
    fixture.check_refusals({
        {with_frame(first + "      - viewport: {x: 0, y: 0}\n        image: wide.exr\n"),
         "test.yaml:7: renderers[0].frames[1].image: the image has 17 x 8 pixels, and the renderer's first "
         "16 x 8 pixels; use images of one size, the renderer's DVI mode"},
        {with_frame(first + "      - viewport: {x: 0, y: 0}\n        image: absent.png\n"),
         "test.yaml:7: renderers[0].frames[1].image: " + folder +
             "/absent.png: cannot be read: No such file or directory"},
        {with_frame(first + "        depth: depth.png\n"),
         "test.yaml:6: renderers[0].frames[0].depth: " + folder +
             "/depth.png: has 16 x 7 pixels; use 16 x 8 pixels, as the image it belongs to"},
        {with_frame(first + "        depth: absent.png\n"),
         "test.yaml:6: renderers[0].frames[0].depth: " + folder +
             "/absent.png: cannot be read: No such file or directory"},
    });
    write_picture<std::uint8_t>(fixture.directory() / "two.exr", 16, 8, {{"U", "V"}},
                                std::vector<std::uint8_t>(std::size_t{16} * 8 * 2));
    CHECK(fixture.error(with_frame(first + "        depth: two.exr\n")).rfind("test.yaml:6: ", 0) == 0);
    write_black(fixture.directory() / "colours.png", 16, 8);
    const auto frame = [](const std::string& depth) {
        return with_frame("      - {image: colours.png" + depth + ", viewport: {x: 0, y: 0}}\n");
    };
    const std::string where = "test.yaml:4: renderers[0].frames[0].";
    fixture.check_refusals({
        {frame(""),
         where + "image: " + (fixture.directory() / "colours.png").string() +
             ": has the channels R, G and B and no Z; use depth, a file of Z, z, one depth for all of it, "
             "or depth_layer, a layer or a channel of the file"},
        {frame(", z: 100.5"), where + "z: 100.5 is out of range; use 0 to 100"},
        {frame(", z: -1"), {"depth_range=[-0.5, 7]"}, where + "z: -1 is out of range; use -0.5 to 7"},
        {frame(", z: 11, depth_range: [10, 0]"), where + "z: 11 is out of range; use 0 to 10"},
        {frame(", z: 1, depth_range: [3, 3]"),
         where + "depth_range: near and far are both 3; use two different depths"},
        {frame(", z: 1, depth: colours.png"),
         where + "z: is given together with a depth; use one of the two"},
    });
    const Scenario scenario = fixture.parse(frame(", z: 25"));
    CHECK(scenario.renderers[0].images[0]->pixels().at(15, 7).z() == 16384);  // 65535 / 4, rounded
    CHECK(scenario.image_files.at(scenario.renderers[0].images[0].get()).z == 25.0);
}

TEST_CASE("renderers: frames that differ in their depth have images of their own") {
    const ScenarioFixture fixture;
    const Scenario scenario =
        fixture.parse(with_frame("      - {image: image.exr, viewport: {x: 0, y: 0}}\n"
                                 "      - {image: image.exr, z: 1, viewport: {x: 0, y: 0}}\n"
                                 "      - {image: image.exr, z: 1.0, viewport: {x: 3, y: 0}}\n"));
    CHECK(scenario.renderers[0].images.size() == 2);
    CHECK(scenario.renderers[0].frames[2].image == scenario.renderers[0].frames[1].image);
}

TEST_CASE("renderers: the depth range and format reach the images") {
    const ScenarioFixture fixture;
    write_picture(fixture.directory() / "z.exr", 12, 1, {{"R", "G", "B", "A", "Z"}, OIIO::TypeDesc::FLOAT},
                  [] {
                      std::vector<float> samples;
                      for (int x = 0; x < 12; ++x) {
                          for (const float value : {1.0F, 0.0F, 0.0F, 0.0F, static_cast<float>(x)}) {
                              samples.push_back(value);
                          }
                      }
                      return samples;
                  }());
    const std::string text =
        "depth_range: [0, 10]\n" + with_frame("      - {image: z.exr, viewport: {x: 0, y: 0}}\n");
    const Scenario z16 = fixture.parse(text);
    CHECK(z16.renderers[0].images[0]->pixels().at(5, 0) == Pixel(255, 0, 0, 0, 32768));
    CHECK(z16.renderers[0].images[0]->pixels().at(11, 0).z() == 0xFFFF);
    const Scenario own =
        fixture.parse(text +
                      "      - {image: z.exr, depth_range: [20, 0], viewport: {x: 0, y: 0}}\n"
                      "      - {image: z.exr, depth_range: [20, 0], z: 15, viewport: {x: 0, y: 0}}\n");
    CHECK(own.renderers[0].images[0]->pixels().at(5, 0).z() == 32768);
    CHECK(own.renderers[0].images[1]->pixels().at(5, 0).z() == 49151);
    CHECK(own.renderers[0].images[2]->pixels().at(5, 0).z() == 16384);
    const Scenario z24 = fixture.parse("depth_format: z24\n" + text);
    CHECK(z24.renderers[0].images[0]->pixels().at(5, 0) == Pixel(255, 0, 0, 255, 8388608));
    CHECK(z24.background_pixel().z() == 0xFFFFFF);
}

TEST_CASE("faults: each kind has its own keys") {
    const ScenarioFixture fixture;
    const std::vector<std::pair<std::string, FaultKind>> kinds{{"magic", FaultKind::kMagic},
                                                               {"version", FaultKind::kVersion},
                                                               {"kind", FaultKind::kKind},
                                                               {"crc", FaultKind::kCrc},
                                                               {"number", FaultKind::kNumber},
                                                               {"short_line", FaultKind::kShortLine},
                                                               {"long_line", FaultKind::kLongLine},
                                                               {"short_frame", FaultKind::kShortFrame},
                                                               {"long_frame", FaultKind::kLongFrame},
                                                               {"missing", FaultKind::kMissing},
                                                               {"repeated", FaultKind::kRepeated},
                                                               {"other_pair", FaultKind::kOtherPair}};
    for (const auto& [name, kind] : kinds) {
        const Scenario scenario =
            fixture.parse(with_faults({"{renderer: cube, pair: 4, kind: " + name + "}"}));
        REQUIRE(scenario.faults.size() == 1);
        CHECK(scenario.faults[0].renderer == 1);
        CHECK(scenario.faults[0].pair == 4);
        CHECK(scenario.faults[0].kind == kind);
        CHECK(scenario.faults[0].frame == FrameKind::kColour);
        CHECK(scenario.faults[0].delay_pairs == 0);
        CHECK(scenario.faults[0].lines == 1);
        CHECK(scenario.faults[0].where == "test.yaml:6: faults[0]");
    }
    const Scenario scenario =
        fixture.parse(with_faults({"{renderer: ball, pair: 4294967295, kind: crc, frame: depth}",
                                   "{renderer: ball, pair: 0, kind: delay, frame: colour, delay_pairs: 3}"}));
    REQUIRE(scenario.faults.size() == 2);
    CHECK(scenario.faults[0].frame == FrameKind::kDepth);
    CHECK(scenario.faults[0].pair == 4294967295U);
    CHECK(scenario.faults[1].kind == FaultKind::kDelay);
    CHECK(scenario.faults[1].delay_pairs == 3);
    CHECK(fixture.parse("faults: []\n" + ScenarioFixture::minimal()).faults.empty());
    const auto only = [&](const std::string& keys) {
        return fixture.parse(with_faults({"{renderer: ball, " + keys + "}"})).faults.at(0);
    };
    CHECK(only("pair: 0, kind: long_frame, lines: 8").lines == 8);
    Fault fault = only("pair: 2, frame: depth, kind: control_byte, byte: 47, bits: 129");
    CHECK(fault.byte == 47);
    CHECK(fault.bits == 129);
    CHECK(fault.frame == FrameKind::kDepth);
    fault = only("pair: 2, kind: pixel_bits, bits: 16777215, x: 15, y: 7");
    CHECK(fault.bits == 0xFFFFFF);
    CHECK(fault.x == 15);
    CHECK(fault.y == 7);
    fault = only("pair: 2, kind: drift, ppm: -250");
    CHECK(fault.pair == 2);
    CHECK(fault.ppm == -250);
    CHECK(only("pair: 3, kind: drift, ppm: 0").ppm == 0);
    fault = only("kind: busready_low, display: 1");
    CHECK(fault.display == 1);
    CHECK(fault.from_cycle == 0);
    CHECK_FALSE(fault.cycles.has_value());
    fault = only("kind: pipeready_low, display: 1, from_cycle: 5000000000, cycles: 7");
    CHECK(fault.from_cycle == 5'000'000'000);
    CHECK(fault.cycles == 7);
    fault = only("kind: lost_beat, display: 1, beats: 3, from_cycle: 9");
    CHECK(fault.beats == 3);
    CHECK(fault.of == LostBeats::kPixels);
    CHECK(only("kind: lost_beat, display: 1, of: pixels").of == LostBeats::kPixels);
    CHECK(only("kind: lost_beat, display: 1, of: table").of == LostBeats::kTable);
    CHECK(only("kind: lost_beat, display: 1, of: any").of == LostBeats::kAny);
    fault = only("kind: random_stalls, percent: 40, seed: 12345678901");
    CHECK(fault.percent == 40);
    CHECK(fault.seed == 12'345'678'901U);
}

TEST_CASE("faults: what is wrong with one has its line, a reset's too, which is the whole machine's") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(with_faults({"{kind: reset, from_cycle: 40, cycles: 9}"}));
    CHECK(scenario.faults.at(0).kind == FaultKind::kReset);
    CHECK(scenario.faults.at(0).from_cycle == 40);
    CHECK(scenario.faults.at(0).cycles == 9);
    CHECK(fixture.error(with_faults({"{renderer: ball, kind: reset, cycles: 9}"})) ==
          "test.yaml:6: faults[0].renderer: does not go with kind reset, which is the whole machine's; leave "
          "it out");
    CHECK_THAT(fixture.error(with_faults({"{kind: reset, from_cycle: 40}"})),
               Catch::Contains("faults[0].cycles: is missing; use "));
    CHECK_THAT(fixture.error(with_faults({"{kind: reset, cycles: 2000000}"})),
               Catch::Contains("faults[0].cycles: 2000000 is ") && Catch::Contains("use 1 to 1000000"));
    CHECK_THAT(fixture.error(with_faults({"{kind: busready_low, display: 1}"})),
               Catch::Contains("faults[0].renderer: is missing"));
    CHECK(fixture.error("clocks: {dvi_out_mhz: 30}\n" + with_faults({"{kind: reset, cycles: 7}"})).empty());
    CHECK_THAT(fixture.error("clocks: {dvi_out_mhz: 30}\n" + with_faults({"{kind: reset, cycles: 6}"})),
               Catch::Contains(
                   "faults[0].cycles: 6 core cycles are less than two of the slowest clock; use 7 or more"));
    const std::string good = "{renderer: ball, pair: 0, kind: crc}";
    const auto error = [&](const std::string& fault) { return fixture.error(with_faults({good, fault})); };
    const std::string at = "test.yaml:7: faults[1]";
    check_refusals(error)({
        {"{renderer: bal, pair: 0, kind: crc}",
         at + ".renderer: 'bal' is not a renderer; the nearest is ball"},
        {"{pair: 0, kind: crc}", at + ".renderer: is missing; use a renderer's name, on one line"},
        {"{renderer: ball, kind: crc}", at + ".pair: is missing; use 0 to 4294967295"},
        {"{renderer: ball, pair: -1, kind: crc}", at + ".pair: -1 is out of range; use 0 to 4294967295"},
        {"{renderer: ball, pair: 0}",
         at + ".kind: is missing; use magic, version, kind, crc, number, short_line, long_line, "
              "short_frame, long_frame, missing, delay, repeated, other_pair, control_byte, pixel_bits, "
              "drift, busready_low, pipeready_low, lost_beat, random_stalls, reset, tmds_bits, tmds_slip, "
              "tmds_skew or tmds_noise"},
        {"{renderer: ball, pair: 0, kind: crcs}", at + ".kind: 'crcs' is not a kind of fault; use ..."},
        {"{renderer: ball, pair: 0, kind: crc, frame: even}",
         at + ".frame: 'even' is not a frame of a pair; use colour or depth"},
        {"{renderer: ball, pair: 0, kind: crc, delay_pairs: 2}",
         at + ".delay_pairs: does not go with kind crc; use it with kind delay only"},
        {"{renderer: ball, pair: 0, kind: delay}", at + ".delay_pairs: is missing; use 1 to 1000000"},
        {"{renderer: ball, pair: 0, kind: delay, delay_pairs: 0}",
         at + ".delay_pairs: 0 is out of range; use 1 to 1000000"},
        {"{renderer: ball, pair: 0, kind: crc, frames: depth}",
         at + ".frames: is not a known key; the nearest is faults[1].frame"},
        {"crc",
         at + ": is 'crc'; use a map with the keys renderer, pair, kind, frame, delay_pairs, lines, byte, "
              "bits, x, y, ppm, display, from_cycle, cycles, beats, of, percent, seed, channel, at_line, "
              "at_clock, late_bits, late_characters and per_billion"},
        {"{renderer: ball, pair: 0, kind: crc, lines: 2}",
         at + ".lines: does not go with kind crc; use it with kind short_frame or long_frame only"},
        {"{renderer: ball, pair: 0, kind: busready_low, display: 1}",
         at + ".pair: does not go with kind busready_low; its keys are renderer, kind, display, from_cycle "
              "and cycles"},
        {"{renderer: ball, pair: 0, kind: drift, ppm: 1, frame: depth}",
         at + ".frame: does not go with kind drift; its keys are renderer, kind, pair and ppm"},
        {"{renderer: ball, pair: 0, kind: drift}", at + ".ppm: is missing; use -100000 to 100000"},
        {"{renderer: ball, kind: random_stalls, percent: 3, display: 1}",
         at + ".display: does not go with kind random_stalls; use it with kind busready_low, pipeready_low "
              "or lost_beat only"},
        {"{renderer: ball, pair: 0, kind: control_byte, byte: 3}", at + ".bits: is missing; use 1 to 255"},
        {"{renderer: ball, pair: 0, kind: control_byte, byte: 48, bits: 1}",
         at + ".byte: 48 is out of range; use 0 to 47, the bytes of the control scanline"},
        {"{renderer: ball, kind: lost_beat, display: 1, of: rows}",
         at + ".of: 'rows' is not a kind of beat; use pixels, table or any"},
        {"{renderer: ball, kind: busready_low, display: 1, of: table}",
         at + ".of: does not go with kind busready_low; use it with kind lost_beat only"},
        {"{renderer: ball, kind: lost_beat, display: 2}", at + ".display: 2 is out of range; use 1 to 1"},
    });
}

}  // namespace metabuffer::test
