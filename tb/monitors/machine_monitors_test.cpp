#include "monitors/machine_monitors.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <set>
#include <sstream>

#include "altered_machine.h"
#include "random_scenario.h"

namespace metabuffer::test::machine_monitors_test {
using Catch::Contains;

TEST_CASE("machine monitors: a report that differs from the wires", "[monitors]") {
    const Scenario scenario = altered_scenario();
    rtl::Metabuffer machine("machine", scenario);
    monitors::ViolationLog log;
    std::vector<monitors::Violation> violations;
    log.on_violation([&](const monitors::Violation& violation) { violations.push_back(violation); });
    monitors::MachineMonitors all("monitors", scenario, machine, log);
    RunReport report;
    machine.on_finished([&] { report = machine.report(); });
    REQUIRE(simulate_until([&] { return !report.level.empty(); }));
    CHECK(all.scoreboard().pictures() == 2 * kAlteredFrames);
    CHECK(all.unreported() == 0);

    all.finish(report);
    CHECK(violations.empty());

    const auto found = [&](const std::function<void(RunReport&)>& change) {
        RunReport changed = report;
        change(changed);
        violations.clear();
        all.finish(changed);
        return violations.size() == 1 ? violations[0].rule + " " + violations[0].signal : "";
    };
    CHECK(found([](RunReport& r) { r.renderers[1].bus.pixels_sent += 9; }) == "counters/bus BUS_2");
    CHECK(found([](RunReport& r) { r.renderers[0].bus.bursts -= 1; }) == "counters/bus BUS_1");
    CHECK(found([](RunReport& r) { ++r.composers[1].late_pixels; }) == "counters/composer composer_1_2");
    CHECK(found([](RunReport& r) { ++r.composers[2].buffer_high_water; }) ==
          "counters/composer composer_2_1");
    CHECK(found([](RunReport& r) { ++r.composers[3].replayed_pixels; }) == "counters/composer composer_2_2");
    CHECK(found([](RunReport& r) { ++r.composers[0].starved_pixels; }) == "counters/composer composer_1_1");
    CHECK(found([](RunReport& r) { r.displays[1].frames_shown = 0; }) == "counters/display DVI_OUT_2");
    CHECK(found([](RunReport& r) { ++r.displays[0].kept_frames; }) == "counters/display DVI_OUT_1");
}

TEST_CASE("machine monitors: without a listener a violation is an error of its rule", "[monitors]") {
    monitors::ViolationLog log;
    CHECK_THROWS_WITH(log.add({"dvi/hsync", "DVI_OUT_1", "dvi_out", 12, 3, "late"}),
                      Contains("/metabuffer/monitor/dvi/hsync") &&
                          Contains("dvi/hsync: DVI_OUT_1, dvi_out clock 12, frame 3: late"));
    CHECK(log.count() == 1);
}

TEST_CASE("machine monitors: every rule has its own name and is documented", "[monitors]") {
    const std::vector<std::string>& rules = monitors::machine_rules();
    CHECK(std::set<std::string>(rules.begin(), rules.end()).size() == rules.size());
    std::ifstream file(METABUFFER_SOURCE_DIRECTORY "/docs/monitors.md");
    std::stringstream text;
    text << file.rdbuf();
    for (const std::string& rule : rules) {
        INFO(rule);
        CHECK(text.str().find("`" + rule + "`") != std::string::npos);
    }
}

TEST_CASE("machine monitors: random machines are compared pixel by pixel", "[monitors]") {
    MachineRuns runs;
    for (const std::uint64_t seed : {7001, 7002, 7003}) {
        runs.push_back(
            std::make_unique<MachineRun>("machine_" + std::to_string(seed), random_scenario(seed)));
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        const Scenario& scenario = run->scenario();
        const std::int64_t pictures = std::int64_t{scenario.frames} * scenario.displays.count();
        CHECK(run->monitors().scoreboard().pictures() == pictures);
        CHECK(run->monitors().scoreboard().raster_pixels() ==
              pictures * scenario.displays.raster_width_pixels() * scenario.displays.raster_height_pixels());
    }
}

}  // namespace metabuffer::test::machine_monitors_test
