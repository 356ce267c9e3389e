#include "scenario/scenario_template.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "host/quiet_fork.h"
#include "scenario/scenario_keys.h"
#include "support/scenario_difference.h"
#include "unit/scenario/picture_files.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

const std::string kText = ScenarioFixture::minimal("name: wall\n");

ScenarioTemplate template_in(const ScratchDirectory& directory, const std::string& text = kText) {
    return ScenarioTemplate(directory.write("test.yaml", text));
}

void write_exr(const std::filesystem::path& file, float depth) {
    constexpr int kWidth = 64;
    constexpr int kHeight = 64;
    write_picture(file, kWidth, kHeight, {{"R", "G", "B", "Z"}, OIIO::TypeDesc::FLOAT},
                  std::vector<float>(std::size_t{kWidth} * kHeight * 4, depth));
}

}  // namespace

TEST_CASE("scenario template: the same as the file loaded with the same overrides") {
    const ScenarioFixture fixture;
    const auto file = fixture.directory().write("test.yaml", kText);
    const ScenarioTemplate scenarios(file);
    CHECK(scenarios.file() == file);
    CHECK(scenarios.text() == kText);
    const std::vector<std::vector<ScenarioOverride>> cases{
        {},
        {{"bus.width_bits", "32"}},
        {{"renderers.0.frames.0.viewport.x", "-5"}, {"frames", "3"}},
        {{"renderers.0.copies", "2"}, {"displays.background", "[1, 2, 3]"}},
        {},  // what came before has left no trace
    };
    for (const std::vector<ScenarioOverride>& overrides : cases) {
        CHECK(scenario_difference(scenarios.scenario(overrides), load_scenario(file, overrides)).empty());
    }
}

TEST_CASE("scenario template: an image is read once for each way in which its depths become Z") {
    const ScratchDirectory directory;
    write_exr(directory / "image.exr", 50.0F);
    const ScenarioTemplate scenarios =
        template_in(directory,
                    "displays: {width: 64, height: 64}\n"
                    "renderers: [{frames: [{image: image.exr, viewport: {x: 0, y: 0}}]}]\n");
    const std::vector<ScenarioOverride> narrow{{"depth_range", "[0, 50]"}};
    const std::vector<ScenarioOverride> deep{{"depth_format", "z24"}};
    const Scenario first = scenarios.scenario({});
    const Scenario second = scenarios.scenario(narrow);
    const Scenario third = scenarios.scenario(deep);
    CHECK(first.renderers[0].images[0]->pixels().at(0, 0).z() == 0x8000);
    CHECK(second.renderers[0].images[0]->pixels().at(0, 0).z() == 0xFFFF);
    CHECK(third.renderers[0].images[0]->pixels().at(0, 0).z() == 0x800000);
    std::filesystem::remove(directory / "image.exr");
    CHECK(scenarios.scenario({{"bus.width_bits", "32"}}).renderers[0].images == first.renderers[0].images);
    CHECK(scenarios.scenario(narrow).renderers[0].images == second.renderers[0].images);
    CHECK(scenarios.scenario(deep).renderers[0].images == third.renderers[0].images);
    const std::string error = input_error_of([&] { scenarios.scenario({{"depth_range", "[0, 49]"}}); });
    CHECK(error.find("renderers[0].frames[0].image: ") != std::string::npos);
    CHECK(error.find("No such file") != std::string::npos);
}

TEST_CASE("scenario template: settings are the values in force and need no images") {
    const ScratchDirectory directory;
    const ScenarioTemplate scenarios = template_in(directory);
    const std::map<std::string, std::string> settings = scenarios.settings({{"bus.burst_pixels", "48"}});
    CHECK(settings.at("name") == "wall");
    CHECK(settings.at("displays.columns") == "1");
    CHECK(settings.at("displays.width") == "16");
    CHECK(settings.at("bus.burst_pixels") == "48");
    CHECK(settings.at("composer.ready_space_pixels") == "48");  // follows the burst
    CHECK(settings.at("bus.arbitration") == "irsa");
    CHECK(settings.at("clocks.core_mhz") == "100");
    CHECK(settings.at("pacing") == "lockstep");
    CHECK(settings.at("frames") == "1");
    CHECK(scenarios.settings({{"clocks.core_mhz", "33.5"}}).at("clocks.core_mhz") == "33.5");
    CHECK(scenarios.settings({{"composer.on_starvation", "stall"}}).at("composer.on_starvation") == "stall");
    // The longest list of frames.
    CHECK(scenarios
              .settings({{"renderers.0.frames",
                          "[{image: a, table: []}, {image: a, table: []}, {image: a, table: []}]"}})
              .at("frames") == "3");
    CHECK(template_in(directory, ScenarioFixture::minimal()).settings({}).at("name") == "test");
}

TEST_CASE(
    "scenario template: settings have every single value outside of lists and make the same scenario again") {
    const ScratchDirectory directory;
    const ScenarioTemplate scenarios = template_in(directory);
    const std::map<std::string, std::string> settings = scenarios.settings({{"memory.words_per_cycle", "4"}});
    std::vector<std::string> keys;
    for (const SchemaKey& key : scenario_schema().keys()) {
        const std::string pattern = key.pattern;
        const bool in_list = pattern.find("[]") != std::string::npos;
        if (key.shape == KeyShape::kScalar && !in_list) keys.push_back(pattern);
    }
    CHECK(setting_keys() == keys);
    std::vector<ScenarioOverride> all;
    for (const std::string& key : keys) {
        // These stand for a clock, which is among the settings.
        const bool is_refresh_rate = key == "clocks.dvi_in_refresh_hz" || key == "clocks.dvi_out_refresh_hz";
        CHECK((settings.count(key) == 0) == is_refresh_rate);
        if (!is_refresh_rate) all.push_back({key, settings.at(key)});
    }
    CHECK(settings.size() == all.size());
    CHECK(scenarios.settings(all) == settings);
    const auto at_60_hz =
        scenarios.settings({{"clocks.dvi_out_refresh_hz", "60"}, {"clocks.dvi_in_refresh_hz", "60"}});
    CHECK(at_60_hz.at("clocks.dvi_out_refresh_hz") == "60");
    CHECK(at_60_hz.at("clocks.dvi_out_mhz") != settings.at("clocks.dvi_out_mhz"));
    CHECK(at_60_hz.count("clocks.dvi_in_mhz") == 0);  // not before the images are read
}

TEST_CASE("scenario template: errors are those of the loader") {
    const ScenarioFixture fixture;
    const auto file = fixture.directory().write("test.yaml", kText);
    const ScenarioTemplate scenarios(file);
    const std::vector<ScenarioOverride> overrides{
        {"bus.width_bits", "48"},       {"bus.widht_bits", "32"}, {"composer.ready_space_pixels", "1"},
        {"renderers.1.name", "ball"},   {"renderers", "[]"},      {"displays.columns", "[1"},
        {"renderers.0.frames.0", "{}"}, {"displays.rows", "65"},  {"name", "a/b"},
        {"displays", "{width: 16}"},    {"faults", "[{}]"},       {"depth_range", "[2, 2]"},
    };
    for (const ScenarioOverride& one : overrides) {
        INFO(one.path << "=" << one.value);
        const std::string error = input_error_of([&] { load_scenario(file, {one}); });
        CHECK_FALSE(error.empty());
        CHECK(input_error_of([&] { scenarios.scenario({one}); }) == error);
        CHECK(input_error_of([&] { scenarios.settings({one}); }) == error);
    }
    CHECK(input_error_of([&] {
              ScenarioTemplate(fixture.directory() / "none.yaml");
          }).find("none.yaml: cannot be read: No such file or directory") != std::string::npos);
    CHECK(input_error_of([&] {
              ScenarioTemplate(fixture.directory().write("bad.yaml", "a: [1\n"));
          }).find("not valid YAML") != std::string::npos);
}

TEST_CASE("scenario template: a forked child goes on reading images") {
    // OpenEXR's threads would not come along, and the child would wait for them.
    const ScratchDirectory directory;
    write_exr(directory / "image.exr", 50.0F);
    const ScenarioTemplate scenarios =
        template_in(directory,
                    "displays: {width: 64, height: 64}\n"
                    "renderers: [{frames: [{image: image.exr, viewport: {x: 0, y: 0}}]}]\n");
    CHECK(scenarios.scenario({}).renderers[0].images[0]->pixels().at(0, 0).z() == 0x8000);
    const pid_t child = quiet_fork();
    if (child == 0) {
        constexpr unsigned kPatienceSeconds = 60;
        alarm(kPatienceSeconds);  // ends a child that waits for ever
        const Scenario other = scenarios.scenario({{"depth_range", "[0, 50]"}});
        const bool good = other.renderers[0].images[0]->pixels().at(0, 0).z() == 0xFFFF;
        _exit(good ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    REQUIRE(child > 0);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == EXIT_SUCCESS);
}

}  // namespace metabuffer::test
