#include "scenario/rate_limits.h"

#include <catch2/catch.hpp>

#include "support/scenarios.h"

namespace metabuffer::test {
namespace {

/// A display frame of 180 x 115 clocks at 50 MHz, a raster of 200 x 200 at 100 MHz, and two links of pairs of 2 x (112 x
/// 40) and 2 x (144 x 64) clocks at 25 MHz.
Scenario machine() {
    Scenario scenario = small_scenario(100, 100, 2);
    scenario.displays.supersample = 2;
    scenario.clocks.core_mhz = 100.0;
    scenario.clocks.dvi_in_mhz = 25.0;
    scenario.clocks.dvi_out_mhz = 50.0;
    add_renderer(scenario, renderer_of({PixelImage(32, 24)}));
    add_renderer(scenario, renderer_of({PixelImage(64, 48)}));
    return scenario;
}

constexpr double kRaster = 100e6 / 40'000;
constexpr double kRefresh = 50e6 / (180 * 115);
constexpr double kFastLink = 25e6 / (2 * 112 * 40);
constexpr double kSlowLink = 25e6 / (2 * 144 * 64);

TEST_CASE("rate limits: raster, displays and links each by their own clocks in whole picoseconds") {
    const RateLimits limits = rate_limits(machine());
    CHECK(limits.core_hz == Approx(100e6));
    CHECK(limits.raster_hz == Approx(kRaster));
    CHECK(limits.refresh_hz == Approx(kRefresh));
    REQUIRE(limits.pairs_per_second.size() == 2);
    CHECK(limits.pairs_per_second[0] == Approx(kFastLink));
    CHECK(limits.pairs_per_second[1] == Approx(kSlowLink));
    CHECK(limits.slowest_pairs_per_second() == Approx(kSlowLink));
    Scenario scenario = machine();
    scenario.clocks.core_mhz = 66.0;  // 15151.5 ps
    CHECK(rate_limits(scenario).core_hz == Approx(1e12 / 15152).epsilon(1e-12));
    scenario = machine();
    Fault fault;
    fault.kind = FaultKind::kDrift;
    fault.renderer = 1;
    fault.ppm = 250'000;
    scenario.faults = {fault};
    CHECK(rate_limits(scenario).pairs_per_second[0] == Approx(kFastLink));
    CHECK(rate_limits(scenario).pairs_per_second[1] == Approx(kSlowLink * 1.25));
}

TEST_CASE(
    "rate limits: the slowest link in lockstep, all together else, and refreshes where a raster is longer") {
    Scenario scenario = machine();
    CHECK(rate_limits(scenario).composition_hz() == Approx(kSlowLink));
    CHECK(rate_limits(scenario).different_hz() == Approx(kSlowLink));
    scenario.pacing = Pacing::kFreeRunning;
    CHECK(rate_limits(scenario).composition_hz() == Approx(kRefresh));
    CHECK(rate_limits(scenario).different_hz() == Approx(kRefresh));
    scenario.clocks.dvi_in_mhz = 5.0;
    CHECK(rate_limits(scenario).composition_hz() == Approx(kRefresh));
    CHECK(rate_limits(scenario).different_hz() == Approx((kFastLink + kSlowLink) / 5));
    scenario = machine();
    scenario.clocks.dvi_in_mhz = 1000.0;
    CHECK(rate_limits(scenario).refreshes_per_frame() == 1);
    CHECK(rate_limits(scenario).displays_hz() == Approx(kRefresh));
    scenario.clocks.core_mhz = 95.0;  // 2375 frames/s, less than 2415.5 Hz
    CHECK(rate_limits(scenario).refreshes_per_frame() == 2);
    CHECK(rate_limits(scenario).composition_hz() == Approx(kRefresh / 2));
    scenario.clocks.core_mhz = 48.0;  // 1200 frames/s, less than half
    CHECK(rate_limits(scenario).refreshes_per_frame() == 3);
    CHECK(rate_limits(scenario).different_hz() == Approx(kRefresh / 3));
}

}  // namespace
}  // namespace metabuffer::test
