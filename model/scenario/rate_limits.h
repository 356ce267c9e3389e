#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer {

/// The share by which a requested rate may be missed: clocks have whole picoseconds, and a frame begins at a core
/// clock.
constexpr double kRateTolerance = 0.001;

/// What displays, links and raster allow, in frames a second. The rates are those of the model's clocks, whose periods are
/// whole picoseconds: they may differ from the scenario's in the fifth digit.
struct RateLimits {
    double core_hz = 0.0;                  ///< clocks a second
    double raster_hz = 0.0;                ///< frames through the pipelines back to back
    double refresh_hz = 0.0;               ///< of the displays; all swap at the start of one of their frames
    std::vector<double> pairs_per_second;  ///< of each renderer's link, where a drift makes it fastest
    Pacing pacing = Pacing::kLockstep;

    double slowest_pairs_per_second() const;
    /// The least number of its own frames for which a display shows each composited frame: the next one is composited
    /// after the swap, and a swap is at the start of a frame of the display.
    std::int64_t refreshes_per_frame() const;

    /// Composited frames that displays and raster allow.
    double displays_hz() const;
    /// Different frames that the links can bring: in lockstep as many as the slowest link, since each frame has a new pair
    /// of every renderer; in free-running pacing as many as all links together.
    double links_hz() const;
    /// Frames that can be composited. In free-running pacing pairs may be shown again.
    double composition_hz() const { return pacing == Pacing::kLockstep ? different_hz() : displays_hz(); }
    /// Different frames that can be composited and shown.
    double different_hz() const { return std::min(displays_hz(), links_hz()); }
};

/// The scenario must have its images' sizes.
RateLimits rate_limits(const Scenario& scenario);

}  // namespace metabuffer
