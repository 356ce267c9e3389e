#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "formats/control_scanline.h"
#include "host/enum_table.h"
#include "host/range.h"
#include "scenario/scenario.h"

/// One row of traits for each kind of fault: all that is known of it outside of the code that carries it out.
namespace metabuffer {

/// Where a fault happens.
enum class FaultLocation : std::uint8_t {
    kFrame,       ///< in one frame of a pair on the renderer's link
    kLink,        ///< on the link, from a pair on
    kCharacters,  ///< in the characters of one frame of a pair on the link, which has layer tmds
    kRow,         ///< inside the machine, in a renderer's row, from a core clock on
    kMachine,     ///< in the machine as a whole, from a core clock on: no renderer is named
};

/// What a fault does to the frame that it names.
enum class FaultEffect : std::uint8_t {
    kNone,      ///< nothing: the frame is unchanged, but may come at another time
    kHeader,    ///< its control scanline says something else
    kGeometry,  ///< it has another shape
    kPixels,    ///< its pixels differ
    kAbsence,   ///< it is not sent
};

/// A key that goes with a kind.
struct FaultKeyOfKind {
    const char* name = nullptr;   ///< null: there is none
    IntegerRange range = {1, 0};  ///< narrower than the key's own, unless empty
    bool required = false;        ///< of this kind, though others have a default
};

struct FaultTraits {
    static constexpr std::size_t kMostKeys = 6;
    static constexpr int kNoOffset = -1;

    FaultKind value = FaultKind::kCrc;
    const char* name = nullptr;
    const char* meaning = nullptr;
    FaultLocation location = FaultLocation::kFrame;
    FaultEffect effect = FaultEffect::kNone;
    /// Besides `kind` and, if it names one, `renderer`; in the order of files.
    std::array<FaultKeyOfKind, kMostKeys> keys{};
    /// Offset of the control scanline's byte that is inverted, for kinds that do only that.
    int control_offset = kNoOffset;

    /// The frame's content differs from the pair's and must be made separately.
    constexpr bool changes_frame() const {
        return effect == FaultEffect::kHeader || effect == FaultEffect::kGeometry ||
               effect == FaultEffect::kPixels;
    }
    /// It happens at single clocks, which only level rtl simulates.
    constexpr bool only_at_level_rtl() const { return location != FaultLocation::kFrame; }
    constexpr bool names_renderer() const { return location != FaultLocation::kMachine; }
    /// It is in the bits of a link, which only links.layer tmds has.
    constexpr bool needs_tmds() const {
        return location == FaultLocation::kCharacters || value == FaultKind::kTmdsNoise;
    }
};

namespace fault_kinds {

constexpr FaultKeyOfKind kPair{"pair"};
constexpr FaultKeyOfKind kFrame{"frame"};
constexpr FaultKeyOfKind kLines{"lines"};
constexpr FaultKeyOfKind kDisplay{"display"};
constexpr FaultKeyOfKind kFromCycle{"from_cycle"};
constexpr FaultKeyOfKind kCycles{"cycles"};
constexpr FaultKeyOfKind kChannel{"channel"};
constexpr FaultKeyOfKind kAtLine{"at_line"};
constexpr FaultKeyOfKind kAtClock{"at_clock"};

}  // namespace fault_kinds

// clang-format off
inline constexpr std::array kFaultKinds{
    FaultTraits{FaultKind::kMagic, "magic", "the control scanline's magic is not MBUF", FaultLocation::kFrame,
                FaultEffect::kHeader, {fault_kinds::kPair, fault_kinds::kFrame}, kControlMagicOffset},
    FaultTraits{FaultKind::kVersion, "version", "the control scanline's version is not 1", FaultLocation::kFrame,
                FaultEffect::kHeader, {fault_kinds::kPair, fault_kinds::kFrame}, kControlVersionOffset},
    FaultTraits{FaultKind::kKind, "kind", "its kind is neither colour nor depth (and its CRC holds)",
                FaultLocation::kFrame, FaultEffect::kHeader, {fault_kinds::kPair, fault_kinds::kFrame}},
    FaultTraits{FaultKind::kCrc, "crc", "its CRC-32 does not match", FaultLocation::kFrame, FaultEffect::kHeader,
                {fault_kinds::kPair, fault_kinds::kFrame}, kControlCrcOffset},
    FaultTraits{FaultKind::kNumber, "number", "its frame number is one more than the pair's (and its CRC holds)",
                FaultLocation::kFrame, FaultEffect::kHeader, {fault_kinds::kPair, fault_kinds::kFrame}},
    FaultTraits{FaultKind::kShortLine, "short_line", "the last image scanline is a pixel short", FaultLocation::kFrame,
                FaultEffect::kGeometry, {fault_kinds::kPair, fault_kinds::kFrame}},
    FaultTraits{FaultKind::kLongLine, "long_line", "the last image scanline is a pixel long", FaultLocation::kFrame,
                FaultEffect::kGeometry, {fault_kinds::kPair, fault_kinds::kFrame}},
    FaultTraits{FaultKind::kShortFrame, "short_frame", "the last `lines` image scanlines are missing",
                FaultLocation::kFrame, FaultEffect::kGeometry,
                {fault_kinds::kPair, fault_kinds::kFrame, fault_kinds::kLines}},
    FaultTraits{FaultKind::kLongFrame, "long_frame", "there are `lines` image scanlines too many",
                FaultLocation::kFrame, FaultEffect::kGeometry,
                {fault_kinds::kPair, fault_kinds::kFrame, fault_kinds::kLines}},
    FaultTraits{FaultKind::kMissing, "missing", "the frame is not sent", FaultLocation::kFrame, FaultEffect::kAbsence,
                {fault_kinds::kPair, fault_kinds::kFrame}},
    FaultTraits{FaultKind::kDelay, "delay", "the link is silent for `delay_pairs` pair times before the frame",
                FaultLocation::kFrame, FaultEffect::kNone,
                {fault_kinds::kPair, fault_kinds::kFrame, FaultKeyOfKind{"delay_pairs"}}},
    FaultTraits{FaultKind::kRepeated, "repeated", "the frame is sent twice", FaultLocation::kFrame, FaultEffect::kNone,
                {fault_kinds::kPair, fault_kinds::kFrame}},
    FaultTraits{FaultKind::kOtherPair, "other_pair",
                "the frame is that of the next pair: number, table and image", FaultLocation::kFrame,
                FaultEffect::kHeader, {fault_kinds::kPair, fault_kinds::kFrame}},
    FaultTraits{FaultKind::kControlByte, "control_byte", "one byte of the control scanline is changed by `bits`",
                FaultLocation::kFrame, FaultEffect::kHeader,
                {fault_kinds::kPair, fault_kinds::kFrame, FaultKeyOfKind{"byte"},
                 FaultKeyOfKind{"bits", {1, 0xFF}}}},
    FaultTraits{FaultKind::kPixelBits, "pixel_bits", "`bits` of the image pixel at (x, y) are flipped on the link",
                FaultLocation::kFrame, FaultEffect::kPixels,
                {fault_kinds::kPair, fault_kinds::kFrame, FaultKeyOfKind{"bits"}, FaultKeyOfKind{"x"},
                 FaultKeyOfKind{"y"}}},
    FaultTraits{FaultKind::kDrift, "drift", "from the pair on, the link's clock runs `ppm` millionths fast",
                FaultLocation::kLink, FaultEffect::kNone, {fault_kinds::kPair, FaultKeyOfKind{"ppm"}}},
    FaultTraits{FaultKind::kBusreadyLow, "busready_low", "BUSREADY of a composer is low for `cycles`",
                FaultLocation::kRow, FaultEffect::kNone,
                {fault_kinds::kDisplay, fault_kinds::kFromCycle, fault_kinds::kCycles}},
    FaultTraits{FaultKind::kPipereadyLow, "pipeready_low", "PIPEREADY of a composer is low for `cycles`",
                FaultLocation::kRow, FaultEffect::kNone,
                {fault_kinds::kDisplay, fault_kinds::kFromCycle, fault_kinds::kCycles}},
    FaultTraits{FaultKind::kLostBeat, "lost_beat",
                "the bus loses its next `beats` beats of kind `of` on their way to one composer",
                FaultLocation::kRow, FaultEffect::kNone,
                {fault_kinds::kDisplay, fault_kinds::kFromCycle, FaultKeyOfKind{"beats"}, FaultKeyOfKind{"of"}}},
    FaultTraits{FaultKind::kRandomStalls, "random_stalls",
                "each handshake of the renderer's row is held back in `percent` of the clocks, for `cycles`",
                FaultLocation::kRow, FaultEffect::kNone,
                {fault_kinds::kFromCycle, fault_kinds::kCycles, FaultKeyOfKind{"percent"},
                 FaultKeyOfKind{"seed"}}},
    FaultTraits{FaultKind::kReset, "reset",
                "the whole machine is in reset for `cycles`, and then begins again with pair 0 and frame 0",
                FaultLocation::kMachine, FaultEffect::kNone,
                {fault_kinds::kFromCycle, FaultKeyOfKind{"cycles", {1, 1'000'000}, true}}},
    FaultTraits{FaultKind::kTmdsBits, "tmds_bits",
                "`bits` of one character are flipped, on a link of layer tmds",
                FaultLocation::kCharacters, FaultEffect::kNone,
                {fault_kinds::kPair, fault_kinds::kFrame, FaultKeyOfKind{"bits", {1, kTmdsCharacterMask}},
                 fault_kinds::kChannel, fault_kinds::kAtLine, fault_kinds::kAtClock}},
    FaultTraits{FaultKind::kTmdsSlip, "tmds_slip",
                "from the character on, those of the channel begin `late_bits` later than the link's words",
                FaultLocation::kCharacters, FaultEffect::kNone,
                {fault_kinds::kPair, fault_kinds::kFrame, fault_kinds::kChannel, fault_kinds::kAtLine,
                 fault_kinds::kAtClock, FaultKeyOfKind{"late_bits"}}},
    FaultTraits{FaultKind::kTmdsSkew, "tmds_skew",
                "from the character on, the channel comes `late_characters` later than the link's clock",
                FaultLocation::kCharacters, FaultEffect::kNone,
                {fault_kinds::kPair, fault_kinds::kFrame, fault_kinds::kChannel, fault_kinds::kAtLine,
                 fault_kinds::kAtClock, FaultKeyOfKind{"late_characters"}}},
    FaultTraits{FaultKind::kTmdsNoise, "tmds_noise",
                "each bit of the renderer's link is flipped at a rate of `per_billion`, for `cycles`",
                FaultLocation::kRow, FaultEffect::kNone,
                {fault_kinds::kFromCycle, fault_kinds::kCycles, FaultKeyOfKind{"seed"},
                 FaultKeyOfKind{"per_billion"}}},
};
// clang-format on

static_assert(is_in_order(kFaultKinds));

constexpr const FaultTraits& fault_traits(FaultKind kind) { return row_of(kFaultKinds, kind); }

}  // namespace metabuffer
