#pragma once

#include <cstdint>

#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// What a renderer's bus does before and after a composer's BUSREADY, found by counting clocks. Written independently of
/// the formulas of model/scenario, which the levels use. The scenario must be valid.
struct BusTiming {
    explicit BusTiming(const Scenario& scenario);

    std::int64_t beat_pixels = 0;  ///< the most that a beat carries
    std::int64_t beat_cycles = 0;  ///< that a beat takes
    std::int64_t loop_cycles = 0;  ///< by which a beat and the answer to it are later than without registers
    /// That come of a burst which BUSREADY ends, with the beat at whose edge BUSREADY falls.
    std::int64_t in_flight_pixels = 0;
    /// From the edge at which BUSREADY falls to the last one that may bring a beat which announces more.
    std::int64_t cut_cycles = 0;
    std::int64_t longest_wait_cycles = 0;  ///< of a burst for its next word
    std::int64_t longest_gap_cycles = 0;   ///< from a beat of a burst to the next one
};

}  // namespace metabuffer::monitors
