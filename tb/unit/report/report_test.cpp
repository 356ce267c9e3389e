#include "report/report.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "support/lines.h"

using namespace metabuffer;
using nlohmann::ordered_json;

namespace {

/// Two renderers, two displays, three frames, and something of everything that can go wrong.
RunReport troubled_run() {
    RunReport report;
    report.scenario = "troubled";
    report.level = "rtl";
    report.core_mhz = 50.0;
    report.core_cycles = 30000;
    report.raster_pixels = 9000;
    report.buffer_pixels = 1024;

    report.frames.resize(2);
    report.frames[0].index = 0;
    report.frames[0].start_cycle = 1000;
    report.frames[0].end_cycle = 10999;
    report.frames[0].latency_cycles = 10500;
    report.frames[0].pairs = {0, -1};
    report.frames[1].index = 1;
    report.frames[1].start_cycle = 12000;
    report.frames[1].end_cycle = 20999;
    report.frames[1].pairs = {0, -1};
    report.frames.push_back({2, 21000, 29999, 30000, false, 9100, {2, 0}});
    report.frames[0].swap_cycle = 11000;
    report.frames[0].starved_pixels = {0, 1204};
    report.frames[1].swap_cycle = 21000;
    report.rate_limits = RateLimits{50e6, 6000.0, 6000.0, {7000.0, 8000.0}};

    report.renderers.resize(2);
    RendererCounters& ball = report.renderers[0];
    ball.name = "ball";
    ball.bus = {6000, 10, 990, 40, 25, 35, 2400, 500, 20000, 165, 5990, 200, 7};
    ball.rejected_frames = {0, 1, 0, 0, 2, 0};
    ball.rejected_rows[static_cast<std::size_t>(RowDefect::kDisplay)] = 3;
    ball.rejected_row_messages = {"pair 0, row 2: display 9 is not 1..2",
                                  "pair 0, row 4: display 7 is not 1..2"};
    ball.repeated_frames = 1;
    RendererCounters& cube = report.renderers[1];
    cube.name = "a renderer with a long name";
    cube.bus = {3000, 10, 0, 0, 0, 0, 0, 0, 26990, 0, 3000, 94, 0};
    cube.rejected_rows[static_cast<std::size_t>(RowDefect::kBuffer)] = 1;
    cube.dropped_frames = 4;

    report.composers.resize(4);
    report.composers[0] = {1, 1, 0, 0, 1024, 12, 0, 0, 0, 0, std::nullopt, std::nullopt, 0, {}};
    report.composers[1] = {
        1, 2, 30, 0, 992, 3, 5, 6000, 0, 0, StarvedPixel{1, 12, 40}, StarvedPixel{1, 12, 40}, 0, {}};
    report.composers[2] = {2, 1, 0, 25, 64, 1, 0, 100, 0, 0, std::nullopt, std::nullopt, 0, {}};
    report.composers[3] = {2, 2, 1204, 0, 0, 0, 7, 0, 0, 0, StarvedPixel{0, 3, 4}, StarvedPixel{0, 3, 4},
                           0, {}};
    report.displays.resize(2);
    report.corrected_displays = {2};
    report.displays[0] = {3, 25};
    report.displays[1] = {3, 0};
    return report;
}

RunReport clean_run() {
    RunReport report;
    report.scenario = "clean";
    report.level = "rtl";
    report.core_mhz = 100.0;
    report.rate_limits = RateLimits{100e6, 50000.0, 60000.0, {70000.0}};
    report.core_cycles = 5000;
    report.raster_pixels = 2000;
    report.buffer_pixels = 512;
    report.frames.resize(1);
    report.frames[0].start_cycle = 100;
    report.frames[0].end_cycle = 2099;
    report.frames[0].latency_cycles = 2050;
    report.frames[0].pairs = {0};
    report.renderers.resize(1);
    report.renderers[0].name = "ball";
    report.renderers[0].bus.busy_cycles = 2000;
    report.renderers[0].bus.pixels_sent = 2000;
    report.composers.resize(1);
    report.composers[0].renderer = 1;
    report.composers[0].display = 1;
    report.composers[0].buffer_high_water = 512;
    report.displays.resize(1);
    report.displays[0].frames_shown = 1;
    return report;
}

std::vector<std::string> keys(const ordered_json& json) {
    std::vector<std::string> result;
    for (const auto& item : json.items()) result.push_back(item.key());
    return result;
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// A machine with more composers than a terminal has room for.
RunReport big_run(int renderers, int displays) {
    RunReport report = clean_run();
    report.renderers.clear();
    report.composers.clear();
    for (int renderer = 1; renderer <= renderers; ++renderer) {
        RendererCounters counters;
        counters.name = "r" + std::to_string(renderer);
        counters.bus.busy_cycles = 1000 + renderer;
        counters.bus.poll_cycles = 1000;
        report.renderers.push_back(counters);
        for (int display = 1; display <= displays; ++display) {
            ComposerCounters composer;
            composer.renderer = renderer;
            composer.display = display;
            composer.buffer_high_water = 10;
            composer.starved_pixels = 1;
            report.composers.push_back(composer);
        }
    }
    report.composers[3].buffer_high_water = 400;
    report.displays.assign(static_cast<std::size_t>(displays), DisplayCounters{1, 0});
    return report;
}

}  // namespace

TEST_CASE("report: starved pixels side by side are one run, and runs beyond those kept are still counted") {
    ComposerCounters counters;
    for (const StarvedPixel& pixel : {StarvedPixel{0, 3, 5}, StarvedPixel{0, 4, 5}, StarvedPixel{0, 6, 5},
                                      StarvedPixel{0, 7, 6}, StarvedPixel{1, 8, 6}, StarvedPixel{1, 9, 6}}) {
        counters.add_starved_pixel(pixel);
    }
    CHECK(counters.starved_pixels == 6);
    CHECK(counters.first_glitch == StarvedPixel{0, 3, 5});
    CHECK(counters.starved_runs ==
          std::vector<StarvedRun>{{0, 5, 3, 4}, {0, 5, 6, 6}, {0, 6, 7, 7}, {1, 6, 8, 9}});
    for (int y = 0; y < 2 * kStarvedRunsKept; ++y) counters.add_starved_pixel({2, 0, y});
    CHECK(counters.starved_run_count == 4 + 2 * kStarvedRunsKept);
    CHECK(static_cast<std::int64_t>(counters.starved_runs.size()) == kStarvedRunsKept);
}

TEST_CASE("report: every table row that is rejected is counted, and the messages of the first ones are kept",
          "[report]") {
    ValidatedTable table;
    for (int row = 0; row <= static_cast<int>(kRowMessagesKept) / 2; ++row) {
        table.rejected.push_back({row, RowDefect::kDisplay, "no " + std::to_string(row)});
    }
    RendererCounters counters;
    counters.add_rejected_rows(3, table);
    CHECK(counters.rejected_row_messages.size() == table.rejected.size());
    CHECK(counters.rejected_row_messages.back() == "pair 3, row " + std::to_string(kRowMessagesKept / 2) +
                                                       ": no " + std::to_string(kRowMessagesKept / 2));
    table.rejected.front().defect = RowDefect::kMultiple;
    counters.add_rejected_rows(4, table);
    CHECK(counters.rejected_row_messages.size() == kRowMessagesKept);
    CHECK(counters.total_rejected_rows() == static_cast<std::int64_t>(kRowMessagesKept) + 2);
    CHECK(counters.rejected_rows[static_cast<std::size_t>(RowDefect::kMultiple)] == 1);
}

TEST_CASE("report: names of causes, utilization without idle cycles, and what composition takes",
          "[report]") {
    CHECK(std::string(reject_cause_key(RejectCause::kGeometry)) == "geometry");
    CHECK(std::string(reject_cause_key(RejectCause::kMagic)) == "magic");
    CHECK(std::string(reject_cause_key(RejectCause::kVersion)) == "version");
    CHECK(std::string(reject_cause_key(RejectCause::kKind)) == "kind");
    CHECK(std::string(reject_cause_key(RejectCause::kCrc)) == "crc");
    CHECK(std::string(reject_cause_key(RejectCause::kPair)) == "pair");
    CHECK(BusCounters{}.utilization() == 0.0);
    BusCounters bus;
    bus.idle_cycles = 1000;
    CHECK(bus.utilization() == 0.0);
    bus.busy_cycles = 50;
    CHECK(bus.utilization() == 1.0);
    bus.table_cycles = 10;
    bus.page_miss_cycles = 15;
    bus.poll_cycles = 20;
    bus.lost_cycles = 5;
    CHECK(bus.utilization() == 0.5);
    RunReport report;
    CHECK(report.frames_shown() == 0);
    CHECK(report.composition_cycles() == 0);
    for (const std::int64_t shown : {3, 2, 4}) {
        report.displays.emplace_back();
        report.displays.back().frames_shown = shown;
    }
    CHECK(report.frames_shown() == 2);
    report.frames.resize(2);
    report.frames[0].start_cycle = 100;
    report.frames[0].end_cycle = 199;
    report.frames[1].start_cycle = 300;
    report.frames[1].end_cycle = 419;
    CHECK(report.composition_cycles() == 320);
}

TEST_CASE("totals over the run", "[report]") {
    const RunReport report = troubled_run();
    CHECK(report.total_starved_pixels() == 1234);
    CHECK(report.total_rejected() == 7);
    RendererCounters renderer = report.renderers.front();
    const std::int64_t without_slot_tables = renderer.total_rejected();
    renderer.rejected_slot_tables += 2;
    CHECK(renderer.total_rejected() == without_slot_tables + 2);
    const BusCounters bus = report.total_bus();
    CHECK(bus.busy_cycles == 9000);
    CHECK(bus.table_cycles == 20);
    CHECK(bus.page_miss_cycles == 990);
    CHECK(bus.refresh_cycles == 40);
    CHECK(bus.write_cycles == 25);
    CHECK(bus.grant_cycles == 35);
    CHECK(bus.poll_cycles == 2400);
    CHECK(bus.lost_cycles == 500);
    CHECK(bus.idle_cycles == 46990);
    CHECK(bus.page_misses == 165);
    CHECK(bus.pixels_sent == 8990);
    CHECK(bus.bursts == 294);
    CHECK(bus.recovered_slots == 7);
}

TEST_CASE("report: a check's result and depths that were clamped are there if there were any", "[report]") {
    RunReport report = clean_run();
    CHECK_FALSE(ordered_json::parse(report_json(report)).contains("check"));
    report.check = CheckRecord();
    report.check->rules = 7;
    report.check->pictures = 5;
    report.check->add("frame 0: a pixel");
    CHECK(ordered_json::parse(report_json(report))["check"].dump() ==
          R"({"rules":7,"pictures":5,"violations":1,"first_violations":["frame 0: a pixel"]})");
    report = clean_run();
    CHECK(ordered_json::parse(report_json(report))["clamped_depths"].dump() == "[]");
    CHECK(report_summary(report).find("clamped") == std::string::npos);
    report.clamped_depths = {{"a.exr", {1, 0}}, {"b.exr", {0, 7}}, {"c.exr", {2, 5}}};
    CHECK(ordered_json::parse(report_json(report))["clamped_depths"][0].dump() ==
          R"({"file":"a.exr","before_near_pixels":1,"behind_far_pixels":0})");
    const std::string lines =
        "\nclamped to depth_range:\n  a.exr: 1 pixel before near\n  b.exr: 7 pixels behind far\n"
        "  c.exr: 2 pixels before near, 5 pixels behind far\n";
    CHECK(report_summary(report).find(lines) != std::string::npos);
    report.level = "functional";
    CHECK(report_summary(report).find(lines) != std::string::npos);
}

TEST_CASE("the JSON report holds every counter under its key, in a fixed order", "[report]") {
    const RunReport report = troubled_run();
    const std::string text = report_json(report);
    const ordered_json json = ordered_json::parse(text);

    CHECK(text.substr(0, 29) == "{\n  \"scenario\": \"troubled\",\n ");
    CHECK(text.back() == '\n');
    CHECK(keys(json) == std::vector<std::string>{"scenario", "level", "core_cycles", "core_mhz",
                                                 "buffer_pixels", "rates", "bottleneck", "cost", "frames",
                                                 "renderers", "composers", "displays", "totals",
                                                 "clamped_depths", "watchdog"});
    CHECK(json["scenario"] == "troubled");
    CHECK(json["level"] == "rtl");
    CHECK(json["core_cycles"] == 30000);
    CHECK(json["core_mhz"] == 50.0);
    CHECK(json["buffer_pixels"] == 1024);

    REQUIRE(json["frames"].size() == 3);
    CHECK(
        json["frames"][0].dump() ==
        R"({"index":0,"start_cycle":1000,"end_cycle":10999,"swap_cycle":11000,"kept":false,"latency_cycles":10500,"pairs":[0,-1],)"
        R"("starved_pixels":[0,1204],"wrong_pixels":null})");
    CHECK(json["frames"][1]["latency_cycles"].is_null());

    REQUIRE(json["renderers"].size() == 2);
    const ordered_json& ball = json["renderers"][0];
    CHECK(keys(ball) == std::vector<std::string>{"name", "bus", "rejected_frames", "rejected_rows",
                                                 "rejected_row_messages", "repeated_frames", "dropped_frames",
                                                 "rejected_slot_tables", "injected_faults"});
    CHECK(ball["name"] == "ball");
    CHECK(ball["bus"].dump() ==
          R"({"busy_cycles":6000,"table_cycles":10,"page_miss_cycles":990,"refresh_cycles":40,)"
          R"("write_cycles":25,"grant_cycles":35,"poll_cycles":2400,)"
          R"("lost_cycles":500,"idle_cycles":20000,"page_misses":165,"pixels_sent":5990,"bursts":200,)"
          R"("recovered_slots":7,"utilization":0.6})");
    CHECK(ball["rejected_frames"].dump() ==
          R"({"geometry":0,"magic":1,"version":0,"kind":0,"crc":2,"pair":0})");
    CHECK(ball["rejected_rows"].dump() ==
          R"({"display":3,"duplicate":0,"multiple":0,"source":0,"destination":0,"buffer":0})");
    CHECK(ball["rejected_row_messages"].size() == 2);
    CHECK(ball["rejected_row_messages"][1] == "pair 0, row 4: display 7 is not 1..2");
    CHECK(ball["repeated_frames"] == 1);
    CHECK(json["renderers"][1]["dropped_frames"] == 4);

    REQUIRE(json["composers"].size() == 4);
    CHECK(json["composers"][1].dump() ==
          R"({"renderer":1,"display":2,"starved_pixels":30,"stalled_cycles":0,"buffer_high_water":992,)"
          R"("busready_drops":3,"late_pixels":5,"replayed_pixels":6000,"lost_pixels":0,"lost_tables":0,)"
          R"("first_glitch":{"frame":1,"x":12,"y":40},"starved_run_count":0,"starved_runs":[],)"
          R"("starved_runs_left_out":0})");
    CHECK(json["composers"][2]["stalled_cycles"] == 25);
    CHECK(json["composers"][2]["first_glitch"].is_null());

    CHECK(json["displays"].dump() ==
          R"([{"display":1,"corrected":false,"frames_shown":3,"stalled_cycles":25,"kept_frames":0,)"
          R"("starved_pixels":0,"wrong_pixels":null},)"
          R"({"display":2,"corrected":true,"frames_shown":3,"stalled_cycles":0,"kept_frames":0,)"
          R"("starved_pixels":1234,"wrong_pixels":null}])");

    const ordered_json& totals = json["totals"];
    CHECK(keys(totals) ==
          std::vector<std::string>{"bus", "rejected_frames", "rejected_rows", "repeated_frames",
                                   "dropped_frames", "rejected_slot_tables", "injected_faults",
                                   "starved_pixels", "stalled_cycles", "buffer_high_water", "busready_drops",
                                   "late_pixels", "replayed_pixels", "lost_pixels", "lost_tables",
                                   "frames_shown", "display_stalled_cycles", "kept_frames", "wrong_pixels"});
    CHECK(totals["bus"]["busy_cycles"] == 9000);
    CHECK(totals["bus"]["utilization"].get<double>() == Approx(9000.0 / 13010.0));
    CHECK(totals["rejected_frames"]["crc"] == 2);
    CHECK(totals["rejected_rows"]["display"] == 3);
    CHECK(totals["rejected_rows"]["buffer"] == 1);
    CHECK(totals["repeated_frames"] == 1);
    CHECK(totals["dropped_frames"] == 4);
    CHECK(totals["starved_pixels"] == 1234);
    CHECK(totals["stalled_cycles"] == 25);
    CHECK(totals["buffer_high_water"] == 1024);
    CHECK(totals["busready_drops"] == 16);
    CHECK(totals["late_pixels"] == 12);
    CHECK(totals["replayed_pixels"] == 6100);
    CHECK(totals["frames_shown"] == 6);
    CHECK(totals["display_stalled_cycles"] == 25);
}

TEST_CASE("what faults did is in the report always and in the summary if it happened", "[report]") {
    RunReport report = troubled_run();
    const std::string before = report_summary(report);
    for (const char* word : {"injected", "lost on the buses", "replaced by"})
        CHECK_FALSE(contains(before, word));
    report.renderers[0].injected_faults = 3;
    report.renderers[1].injected_faults = 4;
    report.composers[1].lost_pixels = 8;
    report.composers[2].lost_pixels = 5;
    report.displays[0].kept_frames = 1;
    report.displays[1].kept_frames = 1;  // the same frame
    CHECK(report_summary(report).substr(before.size() - 1) ==
          "; 13 pixels lost on the buses; 1 frame replaced by the picture before; 7 faults injected\n");
    report.composers[0].lost_tables = 1;
    CHECK(contains(report_summary(report), "; 13 pixels and 1 table lost on the buses; "));
    report.composers[1].lost_pixels = report.composers[2].lost_pixels = 0;
    report.composers[3].lost_tables = 2;
    CHECK(contains(report_summary(report), "; 3 tables lost on the buses; "));
    report.composers[1].lost_pixels = 8;
    report.composers[2].lost_pixels = 5;
    const ordered_json json = ordered_json::parse(report_json(report));
    CHECK(json["renderers"][0]["injected_faults"] == 3);
    CHECK(json["composers"][3]["lost_tables"] == 2);
    CHECK(json["totals"]["lost_tables"] == 3);
    CHECK(json["composers"][1]["lost_pixels"] == 8);
    CHECK(json["displays"][1]["kept_frames"] == 1);
    CHECK(json["totals"]["injected_faults"] == 7);
    CHECK(json["totals"]["lost_pixels"] == 13);
    CHECK(json["totals"]["kept_frames"] == 2);
}

TEST_CASE("a JSON report of a level without records has empty lists and all keys", "[report]") {
    RunReport report;
    report.scenario = "\xFFname";  // not UTF-8: the report is written all the same
    report.level = "functional";
    const ordered_json json = ordered_json::parse(report_json(report));
    CHECK(json["scenario"] == "\xEF\xBF\xBDname");
    for (const char* key : {"frames", "renderers", "composers", "displays"}) {
        INFO(key);
        CHECK(json[key] == ordered_json::array());
    }
    CHECK(json["core_cycles"] == 0);
    CHECK(json["totals"]["bus"]["utilization"] == 0.0);
}

TEST_CASE("the summary of a troubled run", "[report]") {
    const std::string expected = R"(troubled (rtl: 2 renderers, 2 displays)
frames      3 shown on every display, 3 composited
clocks      30000 core clocks at 50 MHz
frame rate  5000.00 frames/s composited, start of the first to start of the last
            4545.45 at the slowest, 11000 clocks up to the start of frame 1
            5555.56 frames/s shown, each new picture once, second swap to last
limits      displays 6000.00 Hz, slowest link 7000.00 pairs/s, raster 6000.00 frames/s
bottleneck  buffers: pixels starve; the bus of a renderer wi... works 11.1 % of the raster's clocks
latency     9100 to 10500 clocks (182.00 to 210.00 us), last DVI pixel to last composited pixel
corrected   the colours of display 2, as their pictures show

buses, in % of the clocks with something to send:
  bus               used %  poll %  pixels sent  page misses  recovered  repeated  dropped  rejected
  ball                60.0    24.0         5990          165          7         1        0         6
  a renderer wi...    99.7     0.0         3000            0          0         0        4         1
  all                 69.2    18.4         8990          165          7         1        4         7

buffer high water of 1024 pixels, by composer:
  display              1    2
  ball              1024  992
  a renderer wi...    64    0

starved:
  a renderer with a long name on display 2: 1204 pixels, first in frame 0 at x 3, y 4
  ball on display 2: 30 pixels, first in frame 1 at x 12, y 40

shown wrong: not known without pictures

stalled their column:
  a renderer with a long name on display 1: 25 clocks

rejected frames:
  ball: magic 1, crc 2

rejected table rows:
  ball: pair 0, row 2: display 9 is not 1..2
  ball: pair 0, row 4: display 7 is not 1..2
  ball: 1 further row
  a renderer with a long name: 1 further row

1234 pixels starved on display 2; columns stalled for 25 clocks; 3 frames and 4 table rows rejected
)";
    CHECK(report_summary(troubled_run()) == expected);
    RunReport without_slots = troubled_run();
    without_slots.renderers[0].rejected_slot_tables = 1;
    CHECK_THAT(report_summary(without_slots),
               Catch::Contains("3 frames, 4 table rows and 1 slot table rejected\n"));
}

TEST_CASE("the summary says how many pixels starved and are shown wrong, where and in which frames",
          "[report]") {
    RunReport report = troubled_run();
    report.frames[0].wrong_pixels = {0, 0};
    report.frames[1].wrong_pixels = {0, 0};
    report.frames[2].wrong_pixels = {0, 0};
    CHECK(contains(report_summary(report), "1234 pixels starved on display 2, 0 pixels shown wrong;"));
    CHECK_FALSE(contains(report_summary(report), "shown wrong:"));
    report.frames[0].wrong_pixels = {0, 700};
    report.frames[2].wrong_pixels = {1, 20};
    const std::string text = report_summary(report);
    CHECK(contains(
        text, "\nshown wrong:\n  display 1: 1 pixel in frame 2\n  display 2: 720 pixels in frames 0, 2\n"));
    CHECK(contains(text, "1234 pixels starved on display 2, 721 pixels shown wrong;"));
    const ordered_json json = ordered_json::parse(report_json(report));
    CHECK(json["totals"]["wrong_pixels"] == 721);
    CHECK(json["displays"][1]["wrong_pixels"] == 720);
    CHECK(json["frames"][2]["wrong_pixels"].dump() == "[1,20]");
}

TEST_CASE("a list of starved runs that is cut says so, and where", "[report]") {
    RunReport report = troubled_run();
    ComposerCounters& composer = report.composers[3];
    for (int n = 0; n < 2000; ++n) composer.add_starved_run({n / 1000, n % 1000, 0, 4});
    CHECK(
        contains(report_summary(report), "; the report lists the first 1024 of 2000 runs, up to frame 1\n"));
    const ordered_json json = ordered_json::parse(report_json(report));
    CHECK(json["composers"][3]["starved_runs"].size() == 1024);
    CHECK(json["composers"][3]["starved_runs_left_out"] == 976);
    CHECK(composer.starved_by_frame == std::vector<std::int64_t>{5000, 5000});
    CHECK(composer.starved_pixels_of(1) == 5000);
    CHECK(composer.starved_pixels_of(2) == 0);
}

TEST_CASE("the summary of a clean run of one frame", "[report]") {
    const std::string expected = R"(clean (rtl: 1 renderer, 1 display)
frames      1 shown on every display, 1 composited
clocks      5000 core clocks at 100 MHz
frame rate  none: a single frame has no interval
limits      displays 60000.00 Hz, 2 a frame, link 70000.00 pairs/s, raster 50000.00 frames/s
bottleneck  raster: 100.0 % of the clocks from first pixel to last
latency     2050 clocks (20.50 us), last DVI pixel to last composited pixel

buses, in % of the clocks with something to send:
  bus   used %  poll %  pixels sent  page misses  recovered  repeated  dropped  rejected
  ball   100.0     0.0         2000            0          0         0        0         0

buffer high water of 512 pixels, by composer:
  display    1
  ball     512

no pixel starved
)";
    CHECK(report_summary(clean_run()) == expected);
}

TEST_CASE("the summary of the functional level has no clocks, and that of a run without a frame says so",
          "[report]") {
    RunReport report = clean_run();
    report.level = "functional";
    report.frames.clear();
    report.composers.clear();
    CHECK(report_summary(report) ==
          "clean (functional: 1 renderer, 1 display, no clock)\n"
          "frames      1 shown on every display\n"
          "\n"
          "nothing rejected\n");

    report.renderers[0].rejected_rows[static_cast<std::size_t>(RowDefect::kSource)] = 1;
    report.renderers[0].rejected_row_messages = {"pair 0, row 0: too wide"};
    CHECK(report_summary(report) ==
          "clean (functional: 1 renderer, 1 display, no clock)\n"
          "frames      1 shown on every display\n"
          "\n"
          "rejected table rows:\n"
          "  ball: pair 0, row 0: too wide\n"
          "\n"
          "1 table row rejected\n");
    report = clean_run();
    report.frames.clear();
    report.displays[0].frames_shown = 0;
    const std::string text = report_summary(report);
    CHECK(contains(text, "0 shown on every display, 0 composited"));
    CHECK_FALSE(contains(text, "frame rate"));

    report = clean_run();
    report.frames[0].latency_cycles.reset();
    CHECK(contains(report_summary(report), "latency     none: no frame showed a new pair\n"));
}

TEST_CASE("the summary of a big machine stays short and narrow", "[report]") {
    const auto [renderers, displays] = GENERATE(table<int, int>({{17, 4}, {4, 9}, {200, 50}}));
    const RunReport report = big_run(renderers, displays);
    const std::string text = report_summary(report);
    INFO(text);

    const double mean = (10.0 * (renderers * displays - 1) + 400.0) / (renderers * displays);
    std::ostringstream line;
    line << "  mean " << std::fixed << std::setprecision(1) << mean << ", highest 400 (r1 on display 4)\n";
    CHECK(contains(text, line.str()));
    CHECK(contains(text, ", over " + std::to_string(renderers * displays) + " composers:\n"));
    CHECK(contains(text, "... and " + std::to_string(renderers * displays - 8) + " more in the report\n"));
    CHECK(contains(text, std::to_string(renderers * displays) + " pixels starved on displays 1, 2, 3, 4"));
    CHECK(contains(text, "used least: r1, 50.0 %; most: r" + std::to_string(renderers)) == (renderers > 16));
    CHECK(test::lines_of(text).size() < 40);
    for (const std::string& each : test::lines_of(text)) CHECK(each.size() <= 100);
}

TEST_CASE("the largest grid that is shown fits a terminal, and names are cut between characters",
          "[report]") {
    RunReport report = big_run(16, 8);
    for (RendererCounters& renderer : report.renderers) {
        renderer.name = "name of many characters";
        renderer.bus.pixels_sent = 999'999'999;
        renderer.bus.page_misses = 99'999'999;
        renderer.bus.recovered_slots = 9'999'999;
    }
    for (ComposerCounters& composer : report.composers) composer.buffer_high_water = 9'999'999;
    const std::string text = report_summary(report);
    INFO(text);
    CHECK(contains(text, "  name of many ...  "));
    for (const std::string& each : test::lines_of(text)) CHECK(each.size() <= 100);
    report = clean_run();
    for (int n = 0; n < 20; ++n) report.renderers[0].name += "\xC3\xA9";
    report.renderers[0].name.erase(0, 4);
    std::string thirteen;
    for (int n = 0; n < 13; ++n) thirteen += "\xC3\xA9";
    CHECK(contains(report_summary(report), "  " + thirteen + "...   100.0"));
}
