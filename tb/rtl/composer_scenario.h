#pragma once

#include "support/scenarios.h"

namespace metabuffer::test {

// The raster of these tests, small enough to be written down.
constexpr int kWidth = 6;
constexpr int kHeight = 4;
constexpr int kPixels = kWidth * kHeight;

struct ComposerSizes {
    int buffer = 16;
    int ready_space = 6;
    int beat = 1;  ///< pixels the bus moves at once
};

inline Scenario composer_scenario(const ComposerSizes& sizes = {},
                                  StarvationMode mode = StarvationMode::kGlitch) {
    Scenario scenario = small_scenario(kWidth, kHeight);
    scenario.composer.buffer_pixels = sizes.buffer;
    scenario.composer.ready_space_pixels = sizes.ready_space;
    scenario.composer.on_starvation = mode;
    scenario.bus.width_bits = 64 * sizes.beat;
    scenario.memory.words_per_cycle = sizes.beat;
    return scenario;
}

/// A segment that covers the whole raster.
inline ViewportRow whole_raster(int dcomp = 1) { return segment_row({kWidth, kHeight}, {}, 1, dcomp); }

}  // namespace metabuffer::test
