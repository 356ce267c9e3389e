#include "report/report_difference.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "report/report.h"

using namespace metabuffer;
using nlohmann::json;

namespace {

using Lines = std::vector<std::string>;

/// Two renderers, two displays, two frames, and a different number for every counter.
RunReport some_report() {
    RunReport report;
    report.scenario = "some";
    report.level = "rtl";
    report.core_mhz = 133.3;
    report.core_cycles = 5000;
    report.buffer_pixels = 64;
    report.frames = {{0, 100, 900, 950, false, 800, {0, -1}},
                     {1, 1000, 1900, 2000, false, std::nullopt, {1, 0}}};
    std::int64_t next = 1;
    for (const char* name : {"ball", "sea"}) {
        RendererCounters& renderer = report.renderers.emplace_back();
        renderer.name = name;
        BusCounters& bus = renderer.bus;
        for (std::int64_t* counter :
             {&bus.busy_cycles, &bus.table_cycles, &bus.page_miss_cycles, &bus.poll_cycles, &bus.lost_cycles,
              &bus.idle_cycles, &bus.page_misses, &bus.pixels_sent, &bus.bursts, &bus.recovered_slots}) {
            *counter = next++;
        }
        renderer.rejected_row_messages = {"pair 0, row 2: display 9"};
    }
    for (int renderer = 1; renderer <= 2; ++renderer) {
        for (int display = 1; display <= 2; ++display) {
            ComposerCounters& composer = report.composers.emplace_back();
            composer.renderer = renderer;
            composer.display = display;
            composer.late_pixels = next++;
            composer.buffer_high_water = next++;
        }
    }
    report.displays.resize(2);
    return report;
}

Lines differences(const RunReport& left, const RunReport& right) {
    return compare_reports(report_json(left), report_json(right)).differences;
}

/// The differences that one change in the right report makes, without those in the totals, which follow from the rest.
template <typename Change>
Lines differences_of(Change change) {
    RunReport right = some_report();
    change(right);
    Lines lines;
    for (const std::string& line : differences(some_report(), right)) {
        if (line.rfind("totals.", 0) != 0) lines.push_back(line);
    }
    return lines;
}

std::size_t leaves(const json& value) {
    if (!value.is_structured()) return 1;
    std::size_t count = 0;
    for (const json& item : value) count += leaves(item);
    return count;
}

}  // namespace

TEST_CASE("every value of a report is compared but for the level, and equal ones have no differences",
          "[report]") {
    RunReport right = some_report();
    right.level = "tlm";
    const ReportComparison comparison = compare_reports(report_json(some_report()), report_json(right));
    CHECK(comparison.differences.empty());
    CHECK(comparison.values == leaves(json::parse(report_json(right))) - 1);  // all but the level
    // Each leaf in turn is replaced, wherever it is.
    const json original = json::parse(report_json(some_report()));
    const json flat = original.flatten();  // empty lists are nulls in there
    std::size_t changed = 0;
    for (const auto& [path, value] : flat.items()) {
        const json::json_pointer pointer(path);
        if (path == "/level" || original.at(pointer).is_structured()) continue;
        INFO(path);
        json other = original;
        other.at(pointer) = value.is_string() ? json("different") : json(-77);
        CHECK(compare_reports(original.dump(), other.dump()).differences.size() == 1);
        ++changed;
    }
    CHECK(changed == leaves(original) - 1);
    CHECK(compare_reports("{}", R"({"level":"tlm"})").differences.empty());
    CHECK(compare_reports(R"({"level":"rtl"})", "{}").differences.empty());
    CHECK(compare_reports("{\"a\":\"K\u00fcche\"}", "{\"a\":1}").differences ==
          Lines{"a: rtl \"K\u00fcche\", tlm 1"});
}

TEST_CASE("a difference is one line with its key path and names, or numbers of what has none", "[report]") {
    CHECK(differences_of([](RunReport& report) { report.core_cycles = 5001; }) ==
          Lines{"core_cycles: rtl 5000, tlm 5001"});
    CHECK(differences_of([](RunReport& report) { report.core_mhz = 133.25; }) ==
          Lines{"core_mhz: rtl 133.3, tlm 133.25"});
    CHECK(differences_of([](RunReport& report) { report.composers[1].starved_pixels = 13; }) ==
          Lines{"composers[renderer ball, display 2].starved_pixels: rtl 0, tlm 13",
                "displays[2].starved_pixels: rtl 0, tlm 13"});
    CHECK(differences_of([](RunReport& report) { report.renderers[1].bus.idle_cycles += 2; }) ==
          Lines{"renderers[sea].bus.idle_cycles: rtl 16, tlm 18"});
    CHECK(differences_of([](RunReport& report) { report.displays[1].frames_shown = 3; }) ==
          Lines{"displays[2].frames_shown: rtl 0, tlm 3"});
    CHECK(differences_of([](RunReport& report) { report.frames[1].end_cycle = 7; }) ==
          Lines{"frames[1].end_cycle: rtl 1900, tlm 7"});
    CHECK(differences_of([](RunReport& report) { report.frames[0].pairs[1] = 0; }) ==
          Lines{"frames[0].pairs[renderer sea]: rtl -1, tlm 0"});
    CHECK(differences_of([](RunReport& report) { report.frames[1].latency_cycles = 0; }) ==
          Lines{"frames[1].latency_cycles: rtl null, tlm 0"});
    CHECK(
        compare_reports(R"({"a": [1], "b": {}, "c": "1", "d": 0})", R"({"a": 1, "b": [], "c": 1, "d": 0.0})")
            .differences == Lines{"a: rtl [1], tlm 1", "b: rtl {}, tlm []", R"(c: rtl "1", tlm 1)"});
    RunReport left = some_report();
    left.renderers[0].name = "two\nlines";
    RunReport right = left;
    right.renderers[0].dropped_frames = 1;
    CHECK(differences(left, right) ==
          Lines{"renderers[two lines].dropped_frames: rtl 0, tlm 1", "totals.dropped_frames: rtl 0, tlm 1"});
    left = some_report();
    for (RendererCounters& renderer : left.renderers) renderer.name.clear();
    right = left;
    right.renderers[1].dropped_frames = 1;
    CHECK(differences(left, right) ==
          Lines{"renderers[2].dropped_frames: rtl 0, tlm 1", "totals.dropped_frames: rtl 0, tlm 1"});
    const ComparedNames names{"before", "after"};
    CHECK(compare_reports(R"({"a": 1})", R"({"a": 2})", names).differences == Lines{"a: before 1, after 2"});
    const ColourImage picture(2, 1);
    CHECK(picture_difference(1, 0, nullptr, &picture, names) == "display_1 frame 0: shown by after only");
    // Renderers without a name, composers of no renderer that there is, or without numbers.
    const auto report = [](int x) {
        const std::string value = "\"x\":" + std::to_string(x) + "}";
        return R"({"renderers":[{"name":5,)" + value + R"(],"composers":[{"renderer":2,"display":1,)" +
               value + R"(,{"display":1,)" + value + R"(,{"renderer":"a","display":1,)" + value + "]}";
    };
    CHECK(compare_reports(report(1), report(2)).differences ==
          Lines{"renderers[1].x: rtl 1, tlm 2", "composers[renderer 2, display 1].x: rtl 1, tlm 2",
                "composers[1].x: rtl 1, tlm 2", "composers[2].x: rtl 1, tlm 2"});
    CHECK(compare_reports(R"({"renderers":[{"name":"a"}]})", R"({"renderers":[{"name":"a"},{"name":"b"}]})")
              .differences == Lines{"renderers[1]: only in tlm"});
}

TEST_CASE("what only one report has is reported, of a list of texts the first, and no report is refused",
          "[report]") {
    CHECK(differences_of([](RunReport& report) { report.frames.pop_back(); }) ==
          Lines{"frames[1]: only in rtl"});
    CHECK(differences_of([](RunReport& report) { report.displays.emplace_back(); }) ==
          Lines{"displays[3]: only in tlm"});
    CHECK(differences_of([](RunReport& report) { report.frames[0].pairs.push_back(4); }) ==
          Lines{"frames[0].pairs[2]: rtl none, tlm 4"});
    CHECK(
        differences_of([](RunReport& report) {
            report.composers[0].first_glitch = StarvedPixel{0, 3, 4};
        }) ==
        Lines{R"(composers[renderer ball, display 1].first_glitch: rtl null, tlm {"frame":0,"x":3,"y":4})"});
    const ReportComparison other_keys = compare_reports(R"({"a": 1, "level": 1})", R"({"b": {"c": 2}})");
    CHECK(other_keys.differences == Lines{"a: rtl 1, tlm none", "b: only in tlm"});
    CHECK(other_keys.values == 2);
    CHECK(differences_of([](RunReport& report) { report.watchdog = {"composer_1_1 waits for a pixel"}; }) ==
          Lines{R"(watchdog[0]: rtl none, tlm "composer_1_1 waits for a pixel")"});
    RunReport left = some_report();
    left.watchdog = {"a", "b", "c"};
    RunReport right = left;
    right.watchdog = {"a", "c"};
    CHECK(differences(left, right) ==
          Lines{R"(watchdog[1]: rtl "b", tlm "c"; 2 entries differ, rtl has 3 and tlm 2)"});
    CHECK(differences_of([](RunReport& report) {
              report.renderers[0].rejected_row_messages[0] = "pair 1, row 2: display 9";
          }) == Lines{R"(renderers[ball].rejected_row_messages[0]: rtl "pair 0, row 2: display 9", tlm )"
                      R"("pair 1, row 2: display 9")"});
    CHECK_THROWS_AS(compare_reports("", "{}"), std::invalid_argument);
    CHECK_THROWS_AS(compare_reports("{}", "[1]"), std::invalid_argument);
}

TEST_CASE("pictures differ by pixels or size or by not being there", "[report]") {
    ColourImage left(20, 10, 0x102030);
    ColourImage right = left;
    CHECK_FALSE(picture_difference(2, 0, &left, &right).has_value());
    CHECK_FALSE(picture_difference(2, 0, nullptr, nullptr).has_value());
    right.at(12, 5) = 0x0A2031;
    CHECK(picture_difference(2, 0, &left, &right) ==
          "display_2 frame 0: 1 pixel differs at 12,5: rtl #102030, tlm #0A2031");
    right.at(3, 7) = 0;
    CHECK(picture_difference(1, 14, &left, &right) ==
          "display_1 frame 14: 2 pixels differ, first at 12,5: rtl #102030, tlm #0A2031");
    const ColourImage turned(10, 20, 0x102030);
    CHECK(picture_difference(1, 0, &left, &turned) == "display_1 frame 0: rtl 20x10, tlm 10x20 pixels");
    const ColourImage wider(21, 10, 0x102030);
    CHECK(picture_difference(1, 0, &left, &wider) == "display_1 frame 0: rtl 20x10, tlm 21x10 pixels");
    CHECK(picture_difference(1, 0, &left, nullptr) == "display_1 frame 0: shown by rtl only");
    CHECK(picture_difference(1, 0, nullptr, &left) == "display_1 frame 0: shown by tlm only");
}
