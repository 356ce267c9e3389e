#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "report/report.h"

namespace metabuffer {
namespace {

/// At 1 MHz, with displays of 100 Hz, a raster of 200 frames/s and links of 150 and 400 pairs/s.
RunReport run_of(const std::vector<FrameRecord>& frames) {
    RunReport report;
    report.level = "tlm";
    report.core_mhz = 1.0;
    RateLimits limits;
    limits.core_hz = 1e6;
    limits.raster_hz = 200.0;
    limits.refresh_hz = 100.0;
    limits.pairs_per_second = {150.0, 400.0};
    report.rate_limits = limits;
    report.frames = frames;
    for (std::size_t f = 0; f < frames.size(); ++f) report.frames[f].index = static_cast<int>(f);
    return report;
}

/// Starts and swaps are in clocks; pair: of the one renderer.
FrameRecord frame(std::int64_t start, std::int64_t swap, int pair, bool kept = false) {
    FrameRecord record;
    record.start_cycle = start;
    record.end_cycle = start + 5000;
    record.swap_cycle = swap;
    record.kept = kept;
    record.pairs = {pair};
    return record;
}

TEST_CASE("frame rates: from start to start and from the second swap on, of as many frames as that takes") {
    CHECK_FALSE(run_of({}).frame_rates().composition_hz);
    const FrameRates one = run_of({frame(0, 10'000, 0)}).frame_rates();
    CHECK_FALSE(one.composition_hz);
    CHECK_FALSE(one.slowest_interval);
    CHECK_FALSE(one.display_hz);
    CHECK_FALSE(one.held_hz());
    const FrameRates two = run_of({frame(0, 10'000, 0), frame(20'000, 30'000, 1)}).frame_rates();
    CHECK(two.composition_hz == 50.0);
    CHECK(two.slowest_interval->cycles == 20'000);
    CHECK_FALSE(two.display_hz);
    CHECK_FALSE(two.held_hz());
    const FrameRates rates = run_of({frame(0, 10'000, 0), frame(10'000, 20'000, 1), frame(22'500, 40'000, 2),
                                     frame(40'000, 60'000, 3)})
                                 .frame_rates();
    CHECK(rates.composition_hz == Approx(3e6 / 40'000));
    CHECK(rates.slowest_interval->cycles == 17'500);
    CHECK(rates.slowest_interval->frame == 3);
    CHECK(rates.slowest_interval->hz == Approx(1e6 / 17'500));
    CHECK(rates.display_hz == Approx(2e6 / 40'000));
    CHECK(rates.held_hz() == rates.display_hz);  // the least of the three
    // Of two that are as long, the first.
    CHECK(run_of({frame(0, 1, 0), frame(9'000, 2, 1), frame(18'000, 3, 2)})
              .frame_rates()
              .slowest_interval->frame == 1);
}

TEST_CASE(
    "frame rates: no rate is more than displays allow, a picture counts once, and a replaced one never") {
    const FrameRates rates =
        run_of({frame(4'000, 10'000, 0), frame(10'000, 20'000, 1), frame(20'000, 30'000, 2)}).frame_rates();
    CHECK(rates.composition_hz == 100.0);  // and not 125
    CHECK(rates.display_hz == 100.0);
    CHECK(rates.slowest_interval->cycles == 10'000);
    CHECK(rates.held_hz() == 100.0);
    const FrameRates two = run_of({frame(4'000, 10'000, 0), frame(10'000, 20'000, 1)}).frame_rates();
    CHECK(two.composition_hz == 100.0);
    CHECK(two.slowest_interval->cycles == 6'000);
    CHECK(two.slowest_interval->hz == 100.0);
    const std::vector<FrameRecord> all{frame(0, 10'000, 0), frame(10'000, 20'000, 1),
                                       frame(20'000, 30'000, 2), frame(30'000, 40'000, 3),
                                       frame(40'000, 60'000, 4)};
    CHECK(run_of(all).frame_rates().display_hz == Approx(3e6 / 40'000));
    std::vector<FrameRecord> repeated = all;
    repeated[3].pairs = {2};
    CHECK(run_of(repeated).frame_rates().display_hz == Approx(2e6 / 40'000));
    std::vector<FrameRecord> kept = all;
    kept[3].kept = true;
    CHECK(run_of(kept).frame_rates().display_hz == Approx(2e6 / 40'000));
    // A pair whose frame was replaced is new when it comes again.
    kept[4].pairs = {3};
    CHECK(run_of(kept).frame_rates().display_hz == Approx(2e6 / 40'000));
    CHECK(run_of(kept).frame_rates().composition_hz == Approx(4e6 / 40'000));
}

TEST_CASE("frame rates: report and summary have them, with what the machine allows") {
    RunReport report = run_of({frame(0, 10'000, 0), frame(20'000, 30'000, 1)});
    const auto two = nlohmann::ordered_json::parse(report_json(report))["rates"];
    CHECK(two.dump() ==
          R"({"frames_per_second":null,"composition_hz":50.0,"slowest_interval_cycles":20000,)"
          R"("slowest_interval_frame":1,"display_hz":null,"raster_hz":200.0,"refresh_hz":100.0,)"
          R"("pairs_per_second":[150.0,400.0]})");
    report.frames.push_back(frame(40'000, 50'000, 2));
    report.frames[2].index = 2;
    const auto three = nlohmann::ordered_json::parse(report_json(report));
    CHECK(three["rates"]["frames_per_second"] == 50.0);
    CHECK(three["rates"]["display_hz"] == 50.0);
    CHECK(three["frames"][2]["swap_cycle"] == 50'000);
    CHECK(three["frames"][2]["kept"] == false);
    report.rate_limits.reset();
    const auto untimed = nlohmann::ordered_json::parse(report_json(report))["rates"];
    CHECK(untimed["composition_hz"].is_null());
    CHECK(untimed["refresh_hz"].is_null());
    CHECK(untimed["pairs_per_second"].empty());
    report = run_of({frame(0, 10'000, 0)});
    report.displays.resize(1);
    const auto has = [&report](const std::string& text) {
        INFO(report_summary(report));
        CHECK(report_summary(report).find(text) != std::string::npos);
    };
    has("frame rate  none: a single frame has no interval\n"
        "limits      displays 100.00 Hz, slowest link 150.00 pairs/s, raster 200.00 frames/s\n");
    report.frames = run_of({frame(0, 10'000, 0), frame(20'000, 30'000, 1)}).frames;
    has("frame rate  50.00 frames/s composited, start of the first to start of the last\n"
        "            50.00 at the slowest, 20000 clocks up to the start of frame 1\n"
        "            none shown: two frames have one swap after the first\n");
    report.frames = run_of({frame(0, 10'000, 0), frame(20'000, 30'000, 1), frame(50'000, 60'000, 2)}).frames;
    has("frame rate  40.00 frames/s composited, start of the first to start of the last\n"
        "            33.33 at the slowest, 30000 clocks up to the start of frame 2\n"
        "            33.33 frames/s shown, each new picture once, second swap to last\n");
    report.rate_limits->pairs_per_second = {150.0};
    has("displays 100.00 Hz, link 150.00 pairs/s, raster");
}

}  // namespace
}  // namespace metabuffer
