#pragma once

namespace metabuffer {

/// The pins of a renderer's bus besides the data pins, by what a beat says on them (docs/replacing-a-block.md).
struct BusSideBand {
    static constexpr int kKindBits = 2;
    static constexpr int kLastBits = 1;
    static constexpr int kFrameBits = 32;
    static constexpr int kCountBits = 4;
    static constexpr int kDestinationBits = 16;
    static constexpr int kRemainingBits = 16;
    static constexpr int kFirstBits = 32;
    static constexpr int kAllBits =
        kKindBits + kLastBits + kFrameBits + kCountBits + kDestinationBits + kRemainingBits + kFirstBits;
    /// BUSREADY and TABLEREADY.
    static constexpr int kHandshakesPerComposer = 2;
};

}  // namespace metabuffer
