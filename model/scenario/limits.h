#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "formats/viewport_table.h"
#include "host/range.h"

namespace metabuffer {

/// What a scenario key takes. Bounds that the hardware does not set keep products of cycles and pixels far inside
/// 64 bits.
namespace limits {

constexpr IntegerRange kGridDisplays{1, 64};
constexpr IntegerRange kDisplayPixels{1, 4096};
constexpr std::array<int, 3> kSupersamples{1, 2, 4};
constexpr IntegerRange kChannel{0, 255};
constexpr IntegerRange kRasterPixels{1, std::numeric_limits<std::int16_t>::max()};  ///< dx, dy are int16
constexpr NumberRange kClockMhz{0.001, 10000.0};
constexpr NumberRange kDepth{-1e30, 1e30};
constexpr IntegerRange kPageWords{1, 1 << 24};
constexpr IntegerRange kPageMissCycles{0, 1'000'000};
constexpr IntegerRange kWordsPerCycle{1, 8};
constexpr std::array<int, 6> kBusWidthsBits{16, 32, 64, 128, 256, 512};
constexpr IntegerRange kBurstPixels{1, 65535};
constexpr IntegerRange kBufferPixels{1, 1 << 24};
constexpr IntegerRange kReadySpacePixels{1, 1 << 24};
constexpr IntegerRange kLinkTimeoutPairs{1, 1'000'000};
constexpr IntegerRange kWatchdogCycles{0, 1'000'000'000'000'000};
constexpr IntegerRange kFrames{1, 1'000'000};
constexpr IntegerRange kViewportPosition{-1'000'000'000, 1'000'000'000};
constexpr IntegerRange kViewportMultiple{1, kMaximumMultiple};
constexpr IntegerRange kUnsignedField{0, std::numeric_limits<std::uint16_t>::max()};
constexpr IntegerRange kSignedField{std::numeric_limits<std::int16_t>::min(),
                                    std::numeric_limits<std::int16_t>::max()};
constexpr IntegerRange kFaultPair{0, std::numeric_limits<std::uint32_t>::max()};
constexpr IntegerRange kDelayPairs{1, 1'000'000};
constexpr IntegerRange kImagePixels{1, 8192};  ///< per side
// Faults: the image, or its link, sets closer bounds where it knows them.
constexpr IntegerRange kFaultLines{1, kImagePixels.high};
constexpr IntegerRange kFaultByte{0, 3 * kImagePixels.high - 1};  ///< three bytes a pixel of the scanline
constexpr IntegerRange kFaultPosition{0, kImagePixels.high - 1};
constexpr IntegerRange kByteBits{1, 0xFF};
constexpr IntegerRange kLinkPixelBits{1, 0xFF'FFFF};
constexpr IntegerRange kFaultPpm{-100'000, 100'000};
constexpr IntegerRange kFaultDisplay{1, kGridDisplays.high* kGridDisplays.high};
constexpr IntegerRange kFaultFromCycle{0, 1'000'000'000'000'000};
constexpr IntegerRange kFaultCycles{1, 1'000'000'000'000'000};
constexpr IntegerRange kFaultBeats{1, 1'000'000'000};
constexpr IntegerRange kFaultPercent{1, 99};
constexpr IntegerRange kFaultSeed{0, 1'000'000'000'000'000};
constexpr std::int64_t kComposers = 65536;  ///< displays times renderers
constexpr IntegerRange kRendererCopies{1, kComposers};
constexpr std::int64_t kCopiedFrames = 1'000'000;  ///< copies times frames, over all renderers

}  // namespace limits
}  // namespace metabuffer
