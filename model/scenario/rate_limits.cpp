#include "scenario/rate_limits.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "scenario/derived_timing.h"

namespace metabuffer {
namespace {

constexpr double kPicosecondsPerSecond = 1e12;

/// How often a second something happens that takes `clocks` clocks.
double rate_of(std::int64_t clocks, std::int64_t period_picoseconds) {
    return kPicosecondsPerSecond / (static_cast<double>(clocks) * static_cast<double>(period_picoseconds));
}

}  // namespace

double RateLimits::slowest_pairs_per_second() const {
    return *std::min_element(pairs_per_second.begin(), pairs_per_second.end());
}

std::int64_t RateLimits::refreshes_per_frame() const {
    return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(refresh_hz / raster_hz)));
}

double RateLimits::displays_hz() const { return refresh_hz / static_cast<double>(refreshes_per_frame()); }

double RateLimits::links_hz() const {
    return pacing == Pacing::kLockstep
               ? slowest_pairs_per_second()
               : std::accumulate(pairs_per_second.begin(), pairs_per_second.end(), 0.0);
}

RateLimits rate_limits(const Scenario& scenario) {
    const DisplayConfig& displays = scenario.displays;
    const std::int64_t core_period = clock_period_picoseconds(scenario.clocks.core_mhz);
    RateLimits limits;
    limits.core_hz = rate_of(1, core_period);
    limits.raster_hz =
        rate_of(std::int64_t{displays.raster_width_pixels()} * displays.raster_height_pixels(), core_period);
    limits.refresh_hz =
        rate_of(displays.timing().frame_clocks(), clock_period_picoseconds(scenario.clocks.dvi_out_mhz));
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        limits.pairs_per_second.push_back(
            rate_of(pair_clocks(scenario.renderers[r]), shortest_link_period_picoseconds(scenario, r)));
    }
    limits.pacing = scenario.pacing;
    return limits;
}

}  // namespace metabuffer
