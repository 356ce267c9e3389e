#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "scenario/colour_table_file.h"
#include "scenario/scenario_template.h"
#include "scenario/scenario_writer.h"
#include "support/colour_tables.h"
#include "support/scenario_difference.h"
#include "unit/scenario/scenario_fixture.h"

// displays.correction: what a scenario may say of it, and the files of its tables.

namespace metabuffer::test {
namespace {

std::string with_corrections(const std::string& corrections) {
    return "displays: {columns: 2, width: 16, height: 8, correction: " + corrections + "}\n" +
           ScenarioFixture::kRenderers;
}

std::string rows(int count, const std::string& row = "1,2,3\n") {
    std::string text;
    for (int n = 0; n < count; ++n) text += row;
    return text;
}

/// R is 255 - v, G is v, B is always 7.
std::string some_table() {
    std::string text;
    for (int v = 0; v < 256; ++v) text += std::to_string(255 - v) + "," + std::to_string(v) + ",7\n";
    return text;
}

}  // namespace

TEST_CASE("corrections: gains, gamma and tables are read for the displays that they name", "[scenario]") {
    const ScenarioFixture fixture;
    fixture.directory().write("t.csv", some_table());
    const Scenario scenario = fixture.parse(
        with_corrections("[{display: 2, gain: [1, 0.5, 2], gamma: 2.2}, {display: 1, lut: t.csv}]"));
    const DisplayConfig& displays = scenario.displays;
    REQUIRE(displays.correction.size() == 2);
    CHECK(displays.corrected() == std::vector<int>{1, 2});
    CHECK(*displays.colour_table_of(2) == colour_table({1.0, 0.5, 2.0}, 2.2));
    const auto table = displays.colour_table_of(1);
    CHECK(table->channels()[0][3] == 252);
    CHECK(table->channels()[1][3] == 3);
    CHECK(table->channels()[2][255] == 7);
    CHECK(fixture.parse(ScenarioFixture::minimal()).displays.colour_table_of(1) == nullptr);
    // Each of the two has a default.
    CHECK(*fixture.parse(with_corrections("[{display: 1, gamma: 2}]")).displays.colour_table_of(1) ==
          colour_table({1.0, 1.0, 1.0}, 2.0));
    CHECK(*fixture.parse(with_corrections("[{display: 1, gain: [0.5, 1, 1]}]")).displays.colour_table_of(1) ==
          colour_table({0.5, 1.0, 1.0}, 1.0));
    CHECK(fixture.parse(with_corrections("[]")).displays.correction.empty());
}

TEST_CASE("corrections: what is wrong is said on one line with file and line", "[scenario]") {
    const ScenarioFixture fixture;
    const auto error = [&fixture](const std::string& corrections) {
        return fixture.error(with_corrections(corrections));
    };
    const std::string at = "test.yaml:1: displays.correction[0]";
    check_refusals(error)({
        {"[{display: 3, gamma: 2}]", at + ".display: 3 is not a display; use 1 to 2"},
        {"[{display: 0, gamma: 2}]", at + ".display: 0 is out of range; use 1 to 4096"},
        {"[{gamma: 2}]", at + ".display: is missing; use 1 to 4096"},
        {"[{display: 1, gamma: 2}, {display: 1, gamma: 2}]",
         "test.yaml:1: displays.correction[1].display: 1 has a correction already; use one a display"},
        {"[{display: 1}]", at + ": has none of gain, gamma and lut; use gain and gamma, or lut"},
        {"[{display: 1, gain: [0, 1, 1]}]", at + ".gain[0]: 0 is out of range; use 0.001 to 1000"},
        {"[{display: 1, gain: [1, -1, 1]}]", at + ".gain[1]: -1 is out of range; use 0.001 to 1000"},
        {"[{display: 1, gain: [1, 1, .nan]}]",
         at + ".gain[2]: '.nan' is not a finite decimal number; use 0.001 to 1000"},
        {"[{display: 1, gain: [1, 1]}]", at + ".gain: has 2 entries; use three numbers, [R, G, B]"},
        {"[{display: 1, gamma: 0}]", at + ".gamma: 0 is out of range; use 0.01 to 100"},
        {"[{display: 1, gamma: .inf}]",
         at + ".gamma: '.inf' is not a finite decimal number; use 0.01 to 100"},
        {"[{display: 1, lut: t.csv, gamma: 2}]",
         at + ".gamma: is given together with a lut; use one of the two"},
        {"[{display: 1, lut: ''}]", at + ".lut: is empty; use a file of 256 rows of R, G, B as "
                                         "CSV, instead of gain and gamma, on one line"},
        {"{display: 1}",
         "test.yaml:1: displays.correction: is a map; use a list of displays whose colours are corrected"},
        {"[{display: 1, gamme: 2}]",
         at + ".gamme: is not a known key; the nearest is displays.correction[0].gamma"},
    });
}

TEST_CASE("corrections: a table is whole, or it is refused and no display is corrected by a part of it",
          "[scenario]") {
    const ScenarioFixture fixture;
    const auto error = [&fixture](const std::string& table) {
        fixture.directory().write("t.csv", table);
        const std::string message = fixture.error(with_corrections("[{display: 2, lut: t.csv}]"));
        const std::string file =
            "test.yaml:1: displays.correction[0].lut: " + (fixture.directory() / "t.csv").string();
        REQUIRE(message.substr(0, file.size()) == file);
        return message.substr(file.size());
    };
    const std::string use = "; use 256 rows of R,G,B, each a whole number, 0 to 255";
    check_refusals(error)({
        {rows(255), ": has 255 rows" + use},
        {rows(257), ": has 257 rows" + use},
        {"", ": has 0 rows" + use},
        {rows(255) + "1,2,256\n", ":256: '256' is not a value of a colour" + use},
        {rows(3) + "1,-2,3\n" + rows(252), ":4: '-2' is not a value of a colour" + use},
        {rows(3) + "1,2.0,3\n" + rows(252), ":4: '2.0' is not a value of a colour" + use},
        {rows(3) + "1,,3\n" + rows(252), ":4: '' is not a value of a colour" + use},
        {"R,G,B\n" + rows(256), ":1: 'R' is not a value of a colour" + use},
        {rows(5) + "1,2\n" + rows(250), ":6: has 2 values" + use},
        {rows(5) + "1,2,3,4\n" + rows(250), ":6: has 4 values" + use},
        {rows(5) + "\n" + rows(251), ":6: has 1 value" + use},
        {rows(70'000), ": cannot be read: it is longer than 64 KiB"},
    });
    // Empty lines at the end do no harm, but for their length.
    const auto of_length = [](std::size_t bytes) {
        return rows(256) + std::string(bytes - rows(256).size(), '\n');
    };
    CHECK(error(of_length(64 * 1024 + 1)) == ": cannot be read: it is longer than 64 KiB");
    fixture.directory().write("t.csv", of_length(64 * 1024));
    CHECK(input::read_colour_table(fixture.directory() / "t.csv") ==
          input::parse_colour_table(rows(256), "t"));
    CHECK(fixture.error(with_corrections("[{display: 2, lut: absent.csv}]"))
              .find("absent.csv: cannot be read: No such file or directory") != std::string::npos);
    REQUIRE(mkfifo((fixture.directory() / "pipe").c_str(), 0600) == 0);
    CHECK(fixture.error(with_corrections("[{display: 2, lut: pipe}]")).find("it is no regular file") !=
          std::string::npos);

    DisplayCorrection correction;
    correction.display = 1;
    correction.lut_file = "never-read.csv";
    CHECK_THROWS_AS(correction.table(), std::logic_error);
    const ColourTable plain = input::parse_colour_table(rows(256), "t");
    CHECK(input::parse_colour_table(rows(256, " 1 ,\t2, 3 \r\n") + "\n \n", "t") == plain);
    const std::string text = rows(256);
    CHECK(input::parse_colour_table(text.substr(0, text.size() - 1), "t") == plain);
    CHECK(input::colour_table_text(plain) == text);
}

TEST_CASE("corrections: overrides reach them, and rules hold for scenarios that were built", "[scenario]") {
    const ScenarioFixture fixture;
    const std::string text = with_corrections("[{display: 1, gamma: 2}]");
    CHECK(fixture.parse(text, {"displays.correction.0.gamma=3"}).displays.correction[0].gamma == 3.0);
    CHECK(fixture.parse(text, {"displays.correction[0].gain=[1, 0.25, 1]"}).displays.correction[0].gain[1] ==
          0.25);
    CHECK(fixture.parse(text, {"displays.correction=[]"}).displays.correction.empty());
    CHECK(fixture.error(text, {"displays.correction.0.gamma=-1"}) ==
          "--set displays.correction.0.gamma=-1: displays.correction[0].gamma: -1 is out of range; use 0.01 "
          "to 100");

    const Scenario right = fixture.parse(text);
    const auto broken = [&right](void (*change)(DisplayCorrection&)) {
        Scenario scenario = right;
        change(scenario.displays.correction[0]);
        return input_error_of([&] { check_scenario(scenario); });
    };
    CHECK(broken([](DisplayCorrection&) {}).empty());
    CHECK(broken([](DisplayCorrection& c) { c.gain[2] = 0.0; }) ==
          "displays.correction[0].gain: 0 is out of range; use 0.001 to 1000");
    CHECK(broken([](DisplayCorrection& c) { c.gamma = 0.0; }) ==
          "displays.correction[0].gamma: 0 is out of range; use 0.01 to 100");
    CHECK(broken([](DisplayCorrection& c) { c.lut = std::make_shared<const ColourTable>(c.table()); }) ==
          "displays.correction[0].gamma: is given together with a lut; use one of the two");
}

TEST_CASE("corrections: a written scenario reads back with the same tables", "[scenario][writer]") {
    const ScenarioFixture fixture;
    Random random(5);
    Scenario scenario = fixture.parse(with_corrections("[{display: 2, gain: [0.1, 1, 3], gamma: 0.3333}]"));
    DisplayCorrection by_table;
    by_table.display = 1;
    by_table.lut = std::make_shared<const ColourTable>(random_colour_table(random));
    scenario.displays.correction.push_back(by_table);
    check_scenario(scenario);
    write_scenario(scenario, fixture.directory() / "written");
    const Scenario loaded = load_scenario(fixture.directory() / "written/scenario.yaml");
    CHECK(scenario_difference(scenario, loaded).empty());
    CHECK(*loaded.displays.colour_table_of(1) == *by_table.lut);
    CHECK(*loaded.displays.colour_table_of(2) == *scenario.displays.colour_table_of(2));

    // A run's own scenario names the file that was read, from where it lies.
    const std::string effective = effective_scenario(loaded, fixture.directory() / "out");
    CHECK(effective.find("correction: [{display: 2, gain: [0.1, 1, 3], gamma: 0.3333}, {display: 1, lut: "
                         "'../written/lut_1.csv'}]") != std::string::npos);
}

TEST_CASE("corrections: files of tables are inputs of a scenario", "[scenario]") {
    const ScenarioFixture fixture;
    const ScenarioTemplate scenario(with_corrections("[{display: 1, lut: t.csv}, {display: 2, lut: u.csv}]"),
                                    "test.yaml", fixture.directory().path());
    const auto file = [&fixture](const char* name) { return fixture.directory() / name; };
    CHECK(scenario.input_files({}) ==
          std::vector<std::filesystem::path>{file("image.exr"), file("t.csv"), file("u.csv")});
    CHECK(scenario.input_files({{"displays.correction.0.lut", "other.csv"}}) ==
          std::vector<std::filesystem::path>{file("image.exr"), file("other.csv"), file("u.csv")});
}

}  // namespace metabuffer::test
