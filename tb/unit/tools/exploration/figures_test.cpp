#include "tools/exploration/figures.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "support/scenarios.h"

namespace metabuffer::exploration {
namespace {

/// Two renderers and three displays of 20 by 10 pixels, supersampled twice, and a report with every count different.
Scenario small_machine() {
    Scenario scenario = test::small_scenario(20, 10, 3);
    scenario.displays.supersample = 2;
    scenario.bus.width_bits = 128;
    scenario.composer.buffer_pixels = 100;
    scenario.frames = 5;
    scenario.renderers.resize(2);
    return scenario;
}

RunReport small_report() {
    RunReport report;
    report.level = "tlm";
    report.core_mhz = 50.0;
    report.core_cycles = 9000;
    report.frames = {{0, 1000, 1999, 2400, false, 40, {0}},
                     {1, 2000, 2999, 3000, false, std::nullopt, {1}},
                     {2, 3500, 4999, 5500, false, 70, {2}}};
    for (FrameRecord& frame : report.frames) frame.wrong_pixels = {5, 0, frame.index};
    report.raster_pixels = 800;
    report.rate_limits = rate_limits(small_machine());
    report.rate_limits->core_hz = 50e6;
    report.rate_limits->pairs_per_second = {1e6};
    report.rate_limits->refresh_hz = report.rate_limits->raster_hz = 1e6;
    report.renderers.resize(2);
    BusCounters& bus = report.renderers[0].bus;
    bus.busy_cycles = 1;
    bus.table_cycles = 2;
    bus.page_miss_cycles = 3;
    bus.refresh_cycles = 17;
    bus.write_cycles = 19;
    bus.grant_cycles = 23;
    bus.poll_cycles = 4;
    bus.lost_cycles = 5;
    bus.idle_cycles = 6;
    bus.page_misses = 7;
    bus.pixels_sent = 800;
    bus.bursts = 9;
    bus.recovered_slots = 10;
    report.renderers[1].bus = bus;
    report.renderers[1].bus.busy_cycles = 100;
    report.renderers[1].bus.pixels_sent = 2000;
    report.renderers[0].rejected_frames = {1, 2, 0, 0, 0, 3};
    report.renderers[1].rejected_frames = {0, 0, 4, 0, 0, 0};
    report.renderers[0].rejected_rows[1] = 5;
    report.renderers[1].rejected_rows[2] = 6;
    report.renderers[0].repeated_frames = 11;
    report.renderers[1].repeated_frames = 12;
    report.renderers[0].dropped_frames = 13;
    report.renderers[1].dropped_frames = 14;
    report.renderers[0].injected_faults = 15;
    report.renderers[1].injected_faults = 16;
    for (int n = 0; n < 6; ++n) {
        ComposerCounters composer;
        composer.renderer = 1 + n / 3;
        composer.display = 1 + n % 3;
        composer.starved_pixels = 1 + n;
        composer.stalled_cycles = 10 + n;
        composer.buffer_high_water = n == 2 ? 99 : 50;
        composer.busready_drops = 20 + n;
        composer.late_pixels = 30 + n;
        composer.replayed_pixels = 40 + n;
        composer.lost_pixels = 50 + n;
        composer.lost_tables = 60 + n;
        report.composers.push_back(composer);
    }
    report.displays = {{4, 1, 2}, {3, 3, 4}, {5, 5, 6}};
    return report;
}

Value figure(const RunReport& report, const Scenario& scenario, const std::string& name) {
    const std::vector<Value> values = figures_of(report, scenario);
    REQUIRE(values.size() == figure_kinds().size());
    for (std::size_t n = 0; n < values.size(); ++n) {
        if (figure_kinds()[n].name == name) return values[n];
    }
    FAIL("no figure " << name);
    return {};
}

}  // namespace

TEST_CASE("figures: every one has a name of its own and a meaning") {
    std::set<std::string> names;
    for (const FigureKind& kind : figure_kinds()) {
        CAPTURE(kind.name);
        CHECK(names.insert(kind.name).second);
        CHECK_FALSE(std::string(kind.meaning).empty());
        CHECK(std::string(kind.meaning).find('\n') == std::string::npos);
        CHECK(kind.unit != nullptr);
    }
}

TEST_CASE("figures: those of report.json's totals are the same") {
    const RunReport report = small_report();
    const auto totals = nlohmann::json::parse(report_json(report)).at("totals");
    int compared = 0;
    for (const FigureKind& kind : figure_kinds()) {
        const std::string name = kind.name;
        const auto& counters = totals.at("bus").contains(name) ? totals.at("bus") : totals;
        // The totals of these are by display and by cause.
        if (!counters.contains(name) || name == "frames_shown" || counters.at(name).is_object()) continue;
        CAPTURE(name);
        const Value value = figure(report, small_machine(), name);
        if (const auto* whole = std::get_if<std::int64_t>(&value)) {
            CHECK(*whole == counters.at(name).get<std::int64_t>());
        } else {
            CHECK(std::get<double>(value) == counters.at(name).get<double>());
        }
        ++compared;
    }
    CHECK(compared == 29);
}

TEST_CASE("figures: those that are not in the report are what their meaning says") {
    const RunReport report = small_report();
    const Scenario scenario = small_machine();
    const auto whole = [&](const char* name) {
        return std::get<std::int64_t>(figure(report, scenario, name));
    };
    const auto number = [&](const char* name) { return std::get<double>(figure(report, scenario, name)); };
    CHECK(whole("frames_shown") == 3);
    CHECK(whole("frames_asked") == 5);
    CHECK(whole("core_cycles") == 9000);
    CHECK(number("frame_cycles") == Approx(4000.0 / 3.0));
    CHECK(number("composition_hz") == Approx(2.0 * 50e6 / 2500.0));
    CHECK(whole("slowest_interval_cycles") == 1500);
    CHECK(whole("slowest_interval_frame") == 2);
    CHECK(number("display_hz") == Approx(1.0 * 50e6 / 2500.0));
    CHECK(number("frames_per_second") == Approx(1.0 * 50e6 / 2500.0));
    CHECK(number("raster_hz") == Approx(100e6 / 800));
    CHECK(number("refresh_hz") == Approx(100e6 / (100 * 25)));
    CHECK(number("pairs_per_second") == Approx(100e6 / (2 * 80 * 16)));
    // The second renderer is worse off; its bus works 169 clocks, with 800 of the raster a frame.
    CHECK(figure(report, scenario, "bottleneck") == Value(std::string("buffers")));
    CHECK(number("bottleneck_share") == Approx(169.0 / 2400));
    CHECK(number("bus_load") == Approx(169.0 / 2400));
    CHECK(whole("latency_cycles") == 70);
    CHECK(whole("rejected_frames") == 10);
    CHECK(whole("rejected_rows") == 11);
    CHECK(whole("whole") == 0);
    CHECK(number("pixels_per_cycle") == Approx(2800.0 / (101 + 4 + 6 + 34 + 38 + 46 + 10)));
    CHECK(number("demand_pixels_per_cycle") == Approx(2000.0 / 4000.0));
    CHECK(whole("lost_tables") == 60 + 61 + 62 + 63 + 64 + 65);
    CHECK(whole("injected_faults") == 31);
    CHECK(whole("display_stalled_cycles") == 9);
    CHECK(whole("kept_frames") == 12);
    CHECK(whole("renderers") == 2);
    CHECK(whole("displays") == 3);
    CHECK(whole("composers") == 6);
    CHECK(whole("raster_pixels") == 800);
    CHECK(whole("buffer_bits") == 38400);
    CHECK(number("cost") == Approx(machine_cost(scenario).weighted()));
    CHECK(whole("memory_devices") == 4);
    CHECK(number("composer_mhz") == Approx(machine_cost(scenario).composer_mhz));
    // Two renderers of 128-bit buses, each with the pins beside the data, to composers of three displays.
    CHECK(whole("bus_wires") == 2 * (128 + 103 + 3 * 2));
}

TEST_CASE("figures: a run is whole unless pixels starve, frames are not shown, or something is rejected") {
    struct Row {
        std::function<void(RunReport&)> change;
        std::string missing;
    };
    const std::vector<Row> rows{
        {[](RunReport&) {}, ""},
        {[](RunReport& r) { r.displays[1].stalled_cycles = 3; }, ""},
        {[](RunReport& r) { r.composers[1].starved_pixels = 7; }, "starved_pixels 7"},
        {[](RunReport& r) { r.renderers[0].rejected_frames[1] = 2; }, "rejected_frames 2"},
        {[](RunReport& r) { r.renderers[1].rejected_rows[0] = 3; }, "rejected_rows 3"},
        {[](RunReport& r) { r.renderers[1].rejected_slot_tables = 1; }, "rejected_slot_tables 1"},
        {[](RunReport& r) { r.displays[1].frames_shown = 4; }, "frames_shown 4 of 5"},
    };
    for (const Row& row : rows) {
        RunReport report;
        report.renderers.resize(2);
        report.composers.resize(2);
        report.displays.resize(2);
        for (auto& display : report.displays) display.frames_shown = 5;
        row.change(report);
        CAPTURE(row.missing);
        const std::vector<Value> values = figures_of(report, small_machine());
        CHECK(values.at(figure_index("whole").value()) == Value(std::int64_t{row.missing.empty()}));
        CHECK(missing_from_whole(values) == row.missing);
    }
}

TEST_CASE("figures: without frames there are no rates and no latency, and a latency of some is the longest") {
    RunReport report = small_report();
    report.frames.clear();
    for (const char* name :
         {"frame_cycles", "frames_per_second", "composition_hz", "slowest_interval_cycles",
          "slowest_interval_frame", "display_hz", "latency_cycles", "demand_pixels_per_cycle"}) {
        CAPTURE(name);
        // The mean and the rate of no frames are nothing and not zero.
        CHECK(std::holds_alternative<std::monostate>(figure(report, small_machine(), name)));
    }
    report.renderers[0].bus = {};
    report.renderers[1].bus = {};
    CHECK(figure(report, small_machine(), "pixels_per_cycle") == Value());
    report.displays.clear();
    CHECK(figure(report, small_machine(), "frames_shown") == Value(std::int64_t{0}));
    report = small_report();
    report.frames[2].latency_cycles.reset();
    CHECK(figure(report, small_machine(), "latency_cycles") == Value(std::int64_t{40}));
}

}  // namespace metabuffer::exploration
