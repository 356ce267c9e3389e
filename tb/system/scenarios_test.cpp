#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "functional/functional_compositor.h"
#include "images/image_codec.h"
#include "machine_checks.h"
#include "machine_run.h"
#include "naive_pipeline.h"
#include "replicates_only.h"
#include "report/picture_writer.h"
#include "scenario/scenario_loader.h"
#include "support/trace_switch.h"
#include "tlm_run.h"

namespace metabuffer::test::scenarios_test {

namespace {

const std::filesystem::path kScenarioDirectory = METABUFFER_SOURCE_DIRECTORY "/scenarios";

/// Scenarios whose comments promise that nothing starves.
const std::set<std::string> kNeverStarve{"paper-figure",
                                         "paper-figure-small",
                                         "paper-table",
                                         "case-1",
                                         "case-2",
                                         "case-3",
                                         "case-4",
                                         "foveated",
                                         "foveated-smooth",
                                         "sea-smooth",
                                         "union",
                                         "supersample-off",
                                         "supersample-on",
                                         "projectors",
                                         "tmds"};
/// Scenarios that are there to show starvation.
const std::set<std::string> kStarve{"paper-figure-starved"};

std::vector<std::string> scenario_names() {
    std::vector<std::string> names;
    std::istringstream text(METABUFFER_SCENARIO_NAMES);
    for (std::string name; std::getline(text, name, ',');) names.push_back(name);
    return names;
}

using Overrides = std::vector<ScenarioOverride>;

Scenario load(const std::string& name, const Overrides& overrides = {}) {
    return load_scenario(kScenarioDirectory / (name + ".yaml"), overrides);
}

/// Runs the scenario on the clocked machine, in this process's one elaboration.
std::unique_ptr<MachineRun> run_scenario(const std::string& name) {
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("metabuffer", load(name)));
    TraceSwitch trace;
    trace.add(runs.back()->machine());
    REQUIRE(run_to_end(runs));
    REQUIRE(runs.back()->report().frames.size() == static_cast<std::size_t>(runs.back()->scenario().frames));
    return std::move(runs.back());
}

/// The same with the transaction-level machines beside it.
LevelRuns run_levels(const std::string& name, const Overrides& overrides) {
    std::vector<LevelRuns> runs;
    runs.emplace_back("metabuffer", load(name, overrides));
    TraceSwitch trace;
    trace.add(runs.back().rtl->machine());
    REQUIRE(run_to_end(runs));
    REQUIRE(runs.back().rtl->report().frames.size() ==
            static_cast<std::size_t>(runs.back().rtl->scenario().frames));
    return std::move(runs.back());
}

/// The pictures of the functional level, which has no time and no clocked part.
std::vector<ColourImage> functional_pictures(const Scenario& scenario, int frame) {
    const auto pairs = functional::pairs_without_time(scenario).at(static_cast<std::size_t>(frame));
    const auto contributions = functional::contributions_of(scenario, pairs);
    std::vector<ColourImage> pictures;
    for (int display = 1; display <= scenario.displays.count(); ++display) {
        pictures.push_back(functional::composite_display(scenario, contributions, display));
    }
    return pictures;
}

/// One scenario file, run to its end: its pictures are the functional level's, except for the pixels that the
/// machine located as starved, and level tlm gives all the same.
class ScenarioRun final : public Catch::ITestInvoker {
  public:
    explicit ScenarioRun(std::string name, Overrides overrides = {})
        : name_(std::move(name)), overrides_(std::move(overrides)) {}
    void invoke() const override {
        const LevelRuns levels = run_levels(name_, overrides_);
        check_levels(levels);
        const std::unique_ptr<MachineRun>& run = levels.rtl;
        check_run(*run);
        const std::int64_t starved = run->report().total_starved_pixels();
        if (kNeverStarve.count(name_) != 0) {
            CHECK(starved == 0);
        }
        if (kStarve.count(name_) != 0) {
            CHECK(starved > 0);
        }
        CHECK(run->report().total_rejected() == 0);
        if (starved > 0) {
            return;
        }
        for (int frame = 0; frame < run->scenario().frames; ++frame) {
            const std::vector<ColourImage> expected = functional_pictures(run->scenario(), frame);
            for (int display = 1; display <= run->scenario().displays.count(); ++display) {
                INFO("frame " << frame << " on display " << display);
                CHECK(differing_pixels(run->picture(frame, display),
                                       expected[static_cast<std::size_t>(display) - 1]) == 0);
            }
        }
    }

  private:
    std::string name_;
    Overrides overrides_;
};

void register_run(const std::string& title, ScenarioRun* run) {
    // Registers in its constructor, as the macro does for a function.
    const Catch::AutoReg registration(run, CATCH_INTERNAL_LINEINFO, Catch::StringRef(),
                                      Catch::NameAndTags{title, "[system][scenario]"});
}

bool register_scenarios() {
    for (const std::string& name : scenario_names()) register_run("scenario " + name, new ScenarioRun(name));
    if (kReplicatesOnly) return true;
    // The paper's viewport table and its cases, smoothed.
    for (const std::string name : {"paper-table", "case-1", "case-2", "case-3", "case-4"}) {
        register_run("scenario " + name + ", smoothed",
                     new ScenarioRun(name, {{"composer.smoothing", "bilinear"}}));
    }
    return true;
}

const bool kRegistered = register_scenarios();

}  // namespace

TEST_CASE("every scenario that promises something is there", "[system][scenario]") {
    REQUIRE(kRegistered);
    const std::vector<std::string> names = scenario_names();
    const std::set<std::string> present(names.begin(), names.end());
    for (const std::string& name : kNeverStarve) {
        INFO(name);
        const bool smooths = name.find("-smooth") != std::string::npos;
        CHECK((present.count(name) == 1 || (kReplicatesOnly && smooths)));
    }
    CHECK(std::includes(present.begin(), present.end(), kStarve.begin(), kStarve.end()));
    for (const std::string& name : names) {
        INFO(name);
        CHECK(load(name).name == name);
    }
}

TEST_CASE("the union of three renderers shows what one renderer sees", "[system][scenario]") {
    const std::unique_ptr<MachineRun> run = run_scenario("union");
    const Scenario& scenario = run->scenario();
    std::vector<ColourImage> displays;
    for (int display = 1; display <= scenario.displays.count(); ++display) {
        const ColourImage* picture = run->picture(scenario.frames - 1, display);
        REQUIRE(picture != nullptr);
        displays.push_back(*picture);
    }
    const ColourImage composite = collage(displays, scenario.displays, 0);
    const PixelImage truth = image_codec().load({kScenarioDirectory / "images/union/truth.exr"},
                                                scenario.depth_format, scenario.image_reading);
    REQUIRE(composite.width_pixels == truth.width_pixels);
    REQUIRE(composite.height_pixels == truth.height_pixels);
    ColourImage expected(truth.width_pixels, truth.height_pixels);
    std::transform(truth.values.begin(), truth.values.end(), expected.values.begin(),
                   [](Pixel pixel) { return pixel.rgb(); });
    CHECK(differing_pixels(&composite, expected) == 0);
}

TEST_CASE("the paper's table is the split of a viewport at 25, 25", "[system][scenario]") {
    const Scenario paper = load("paper-table");
    REQUIRE(paper.renderers.size() == 1);
    const Renderer& renderer = paper.renderers[0];
    const ViewportTable& table = renderer.frames.at(0).table;
    CHECK(table == ViewportTable{{1, 0, 0, 75, 75, 25, 25, 1},
                                 {2, 75, 0, 25, 75, 0, 25, 1},
                                 {3, 0, 75, 75, 25, 25, 0, 1},
                                 {4, 75, 75, 25, 25, 0, 0, 1}});
    CHECK(table == split_viewport({25, 25, 1}, renderer.image_width_pixels, renderer.image_height_pixels,
                                  paper.displays.wall()));
    CHECK(functional_pictures(paper, 0) == functional_pictures(load("case-2"), 0));
}

TEST_CASE("the four cases of section 5.1 have the paper's segments", "[system][scenario]") {
    const auto widths_of = [](const std::string& name) {
        std::vector<int> widths;
        const Scenario scenario = load(name);
        for (const ViewportRow& row : scenario.renderers.at(0).frames.at(0).table) {
            widths.push_back(row.sdx);
        }
        return widths;
    };
    CHECK(widths_of("case-1") == std::vector<int>{100});                                 // w
    CHECK(widths_of("case-2") == std::vector<int>{75, 25, 75, 25});                      // l, w - l
    CHECK(widths_of("case-3") == std::vector<int>{50, 50, 50, 50});                      // w / 2
    CHECK(widths_of("case-4") == std::vector<int>{30, 50, 20, 30, 50, 20, 30, 50, 20});  // l / 2, w / 2, ...
}

}  // namespace metabuffer::test::scenarios_test
