#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "formats/viewport_table.h"
#include "host/range.h"

namespace metabuffer {

/// Bounds that several files use; scenario_keys.cpp has those of single keys. Bounds that the hardware does not set
/// keep products of cycles and pixels far inside 64 bits.
namespace limits {

constexpr IntegerRange kGridDisplays{1, 64};
constexpr IntegerRange kWordsPerCycle{1, 8};
constexpr std::array<int, 4> kMemoryBanks{1, 2, 4, 8};
/// All banks must close between two frames: within the fewest clocks from the request for a pair to the first activate,
/// which are a fast link's answer, the frame's start and one row.
constexpr IntegerRange kPrechargeCycles{0, 4};
constexpr IntegerRange kReadLatencyCycles{0, 8};
constexpr IntegerRange kRegisterStages{0, 4};
constexpr IntegerRange kRefreshIntervalCycles{0, 100'000'000};
constexpr IntegerRange kRefreshCycles{0, 1'000'000};
constexpr IntegerRange kPageWords{1, 1 << 24};
constexpr IntegerRange kGrantCycles{0, 255};
constexpr std::array<int, 6> kBusWidthsBits{16, 32, 64, 128, 256, 512};
constexpr IntegerRange kBufferPixels{1, 1 << 24};
constexpr IntegerRange kCycles{0, 1'000'000'000'000'000};
constexpr IntegerRange kFrames{1, 1'000'000};
constexpr IntegerRange kUnsignedField{0, std::numeric_limits<std::uint16_t>::max()};
constexpr IntegerRange kSignedField{std::numeric_limits<std::int16_t>::min(),
                                    std::numeric_limits<std::int16_t>::max()};
constexpr std::int64_t kComposers = 65536;         ///< displays times renderers
constexpr std::int64_t kCopiedFrames = 1'000'000;  ///< copies times frames, over all renderers

constexpr std::int64_t kNumberedFrames = 100'000;  ///< that ranges of frames make, over all renderers

}  // namespace limits
}  // namespace metabuffer
