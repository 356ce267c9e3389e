#include "report/bottleneck.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace metabuffer {
namespace {

/// Two renderers, one display, three frames. A frame takes 1000 raster clocks and one for the second composer, and has
/// a new pair. The first bus works 100 clocks a frame, the second one 300.
RunReport run() {
    RunReport report;
    report.rate_limits = RateLimits{1e6, 1000.0, 500.0, {400.0, 400.0}};
    report.raster_pixels = 1000;
    report.renderers.resize(2);
    report.renderers[0].name = "ball";
    report.renderers[0].bus.busy_cycles = 300;
    report.renderers[1].name = "sea";
    report.renderers[1].bus.busy_cycles = 600;
    report.renderers[1].bus.page_miss_cycles = 250;
    report.renderers[1].bus.table_cycles = 50;
    report.renderers[1].bus.poll_cycles = 9000;
    report.displays.resize(1);
    report.composers.resize(2);
    report.composers[0].renderer = report.composers[0].display = report.composers[1].display = 1;
    report.composers[1].renderer = 2;
    for (int f = 0; f < 3; ++f) {
        FrameRecord frame;
        frame.index = f;
        frame.start_cycle = 2000 * f;
        frame.end_cycle = frame.start_cycle + 1000;
        frame.swap_cycle = frame.start_cycle + 1995;
        frame.latency_cycles = 1001;
        report.frames.push_back(frame);
    }
    return report;
}

std::int64_t cycles(const RunReport& report, Resource resource) {
    return find_bottleneck(report)->cycles[static_cast<std::size_t>(resource)];
}

std::string name(const RunReport& report) { return resource_name(find_bottleneck(report)->what()); }

TEST_CASE(
    "bottleneck: every clock from the first frame's start to the last one's end is assigned to one "
    "resource") {
    const RunReport report = run();
    CHECK(cycles(report, Resource::kRaster) == 3 * 1001);
    CHECK(cycles(report, Resource::kDisplays) == 2 * 999);
    CHECK(find_bottleneck(report)->total_cycles() == report.composition_cycles());
    CHECK(name(report) == "raster");
    CHECK(find_bottleneck(report)->share() == Approx(3003.0 / 5001.0));
}

TEST_CASE(
    "bottleneck: displays if the next frame begins with the swap, links until its pair has come, else "
    "supply") {
    RunReport report = run();
    for (FrameRecord& frame : report.frames) {
        frame.start_cycle *= 2;
        frame.end_cycle = frame.start_cycle + 1000;
        frame.swap_cycle = frame.start_cycle + 3990;  // 10 clocks: the handshakes of two renderers
    }
    CHECK(cycles(report, Resource::kDisplays) == 2 * 2999);
    CHECK(name(report) == "displays");
    for (FrameRecord& frame : report.frames) --frame.swap_cycle;
    CHECK(cycles(report, Resource::kDisplays) == 0);
    report = run();
    for (FrameRecord& frame : report.frames) {
        frame.start_cycle *= 4;
        frame.end_cycle = frame.start_cycle + 1000;
        frame.swap_cycle = frame.end_cycle + 100;
        frame.latency_cycles = 1501;  // the pair was there 501 clocks before the start
    }
    CHECK(cycles(report, Resource::kLinks) == 2 * (6999 - 500));
    CHECK(cycles(report, Resource::kBuffers) == 2 * 500);
    CHECK(name(report) == "links");
    // A frame without a new pair waited for none.
    report.frames[2].latency_cycles.reset();
    CHECK(cycles(report, Resource::kLinks) == 6999 - 500);
    CHECK(cycles(report, Resource::kBuffers) == 500 + 6999);
    report = run();
    report.frames[2].end_cycle += 5000;
    report.composers[1].stalled_cycles = 5000;
    CHECK(cycles(report, Resource::kBuffers) == 5000);
    CHECK(find_bottleneck(report)->supply_renderer == "sea");
    CHECK(find_bottleneck(report)->bus_load == Approx(900.0 / 3000));
    CHECK(name(report) == "buffers");
}

TEST_CASE("bottleneck: a bus that works for longer than the raster is the bottleneck, or its memory is") {
    RunReport report = run();
    report.composers[0].starved_pixels = 3;
    CHECK(find_bottleneck(report)->supply_renderer == "ball");
    CHECK(name(report) == "buffers");  // the bus has time to spare
    BusCounters& bus = report.renderers[0].bus;
    bus.busy_cycles = bus.pixels_sent = 3300;
    CHECK(name(report) == "bus");
    CHECK(find_bottleneck(report)->share() == Approx(1.1));
    // Each is counted alone: the bus with its pixels, tables and arbiter, the memory with its pixels and what must come
    // before.
    bus.table_cycles = 200;
    bus.grant_cycles = 150;
    bus.lost_cycles = 50;
    bus.page_miss_cycles = 200;
    bus.refresh_cycles = 100;
    bus.write_cycles = 101;
    CHECK(name(report) == "memory");
    bus.write_cycles = 100;
    CHECK(name(report) == "bus");
    bus.write_cycles = 101;
    report.memory_words_per_cycle = 2;
    CHECK(name(report) == "bus");
    // A bus that could carry more words than the memory reads is not the bottleneck.
    report.bus_width_bits = 256;
    CHECK(name(report) == "memory");
}

TEST_CASE("bottleneck: none without frames or clocks") {
    RunReport report = run();
    report.rate_limits.reset();
    CHECK_FALSE(find_bottleneck(report));
    report = run();
    report.frames.clear();
    CHECK_FALSE(find_bottleneck(report));
    // Buses have worked for frames that are not in the report.
    report = run();
    report.watchdog = {"composer_1_1 waits"};
    CHECK_FALSE(find_bottleneck(report));
    report = run();
    report.is_reset = true;
    CHECK_FALSE(find_bottleneck(report));
}

TEST_CASE("bottleneck: report and summary name it, and what else took time") {
    RunReport report = run();
    const auto json = nlohmann::ordered_json::parse(report_json(report))["bottleneck"];
    CHECK(json["resource"] == "raster");
    CHECK(json["cycles"].dump() ==
          R"({"raster":3003,"displays":1998,"links":0,"memory":0,"bus":0,"buffers":0})");
    CHECK(json["worst_renderer"] == "sea");
    CHECK(report_summary(report).find(
              "bottleneck  raster: 60.0 % of the clocks from first pixel to last, displays 40.0 %\n") !=
          std::string::npos);
    report.composers[0].starved_pixels = 3;
    CHECK(report_summary(report).find(
              "bottleneck  buffers: pixels starve; the bus of ball works 10.0 % of the raster's clocks\n") !=
          std::string::npos);
    report.frames.clear();
    CHECK(nlohmann::ordered_json::parse(report_json(report))["bottleneck"].is_null());
}

}  // namespace
}  // namespace metabuffer
