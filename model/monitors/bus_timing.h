#pragma once

#include <cstdint>

#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// What a renderer's bus does before and after a composer's BUSREADY, found by counting clocks. Written independently of
/// the formulas of model/scenario, which the levels use. The scenario must be valid.
struct BusTiming {
    explicit BusTiming(const Scenario& scenario);

    std::int64_t beat_pixels = 0;  ///< the most that a beat carries
    std::int64_t beat_cycles = 0;  ///< of a beat
    std::int64_t loop_cycles = 0;  ///< that read latency and registers add from a beat to the answer to it
    /// The most that still come of a burst when BUSREADY ends it, the beat at that edge included.
    std::int64_t in_flight_pixels = 0;
    /// From the edge at which BUSREADY falls to the last edge that may bring a beat with more pixels to come.
    std::int64_t cut_cycles = 0;
    std::int64_t longest_wait_cycles = 0;  ///< of a burst for its next word
    std::int64_t longest_gap_cycles = 0;   ///< from a beat of a burst to the next one
};

}  // namespace metabuffer::monitors
