#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "scenario/fault_kinds.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// How an enumerator is written in scenario files, reports and on the command line.
template <typename Enum>
struct EnumName {
    Enum value;
    const char* name;
};

/// The names of one enumeration, in the order in which messages list them. A row of kTable has a value and a name, and may
/// have more.
template <typename Enum>
struct EnumNames;

/// As many rows as are listed.
template <typename Enum, std::size_t kCount>
constexpr std::array<EnumName<Enum>, kCount> name_table(const EnumName<Enum> (&rows)[kCount]) {
    std::array<EnumName<Enum>, kCount> table{};
    for (std::size_t i = 0; i < kCount; ++i) table[i] = rows[i];
    return table;
}

template <>
struct EnumNames<Composition> {
    static constexpr const char* kWhat = "a composition";
    static constexpr const auto& kTable = kCompositionTable;
};

template <>
struct EnumNames<DepthFormat> {
    static constexpr const char* kWhat = "a depth format";
    static constexpr const auto& kTable = kDepthFormatTable;
};

template <>
struct EnumNames<Arbitration> {
    static constexpr const char* kWhat = "an arbitration";
    static constexpr const auto& kTable = kArbitrationTable;
};

template <>
struct EnumNames<DepthIntegers> {
    static constexpr const char* kWhat = "a meaning of whole numbers";
    static constexpr auto kTable =
        name_table<DepthIntegers>({{DepthIntegers::kScaled, "scaled"}, {DepthIntegers::kRaw, "raw"}});
};

template <>
struct EnumNames<DepthBits> {
    static constexpr const char* kWhat = "a place of depth bits";
    static constexpr auto kTable =
        name_table<DepthBits>({{DepthBits::kChannel, "channel"}, {DepthBits::kRgb24, "rgb24"}});
};

template <>
struct EnumNames<ColourEncoding> {
    static constexpr const char* kWhat = "a colour encoding";
    static constexpr auto kTable =
        name_table<ColourEncoding>({{ColourEncoding::kAsIs, "as-is"}, {ColourEncoding::kSrgb, "srgb"}});
};

template <>
struct EnumNames<StarvationMode> {
    static constexpr const char* kWhat = "a starvation mode";
    static constexpr auto kTable =
        name_table<StarvationMode>({{StarvationMode::kGlitch, "glitch"}, {StarvationMode::kStall, "stall"}});
};

template <>
struct EnumNames<Smoothing> {
    static constexpr const char* kWhat = "a smoothing";
    static constexpr const auto& kTable = kSmoothingTable;
};

template <>
struct EnumNames<MemoryPorts> {
    static constexpr const char* kWhat = "a kind of memory ports";
    static constexpr auto kTable =
        name_table<MemoryPorts>({{MemoryPorts::kDual, "dual"}, {MemoryPorts::kShared, "shared"}});
};

template <>
struct EnumNames<LinkLayer> {
    static constexpr const char* kWhat = "a layer of the links";
    static constexpr auto kTable =
        name_table<LinkLayer>({{LinkLayer::kPixel, "pixel"}, {LinkLayer::kTmds, "tmds"}});
};

template <>
struct EnumNames<TmdsChannel> {
    static constexpr const char* kWhat = "a channel";
    static constexpr auto kTable = name_table<TmdsChannel>(
        {{TmdsChannel::kBlue, "blue"}, {TmdsChannel::kGreen, "green"}, {TmdsChannel::kRed, "red"}});
};

template <>
struct EnumNames<SlotTableMaker> {
    static constexpr const char* kWhat = "a maker of slot tables";
    static constexpr auto kTable =
        name_table<SlotTableMaker>({{SlotTableMaker::kHost, "host"}, {SlotTableMaker::kBuilt, "built"}});
};

template <>
struct EnumNames<Pacing> {
    static constexpr const char* kWhat = "a pacing";
    static constexpr auto kTable =
        name_table<Pacing>({{Pacing::kLockstep, "lockstep"}, {Pacing::kFreeRunning, "free-running"}});
};

template <>
struct EnumNames<FaultKind> {
    static constexpr const char* kWhat = "a kind of fault";
    static constexpr const auto& kTable = kFaultKinds;
};

template <>
struct EnumNames<FrameKind> {
    static constexpr const char* kWhat = "a frame of a pair";
    static constexpr auto kTable =
        name_table<FrameKind>({{FrameKind::kColour, "colour"}, {FrameKind::kDepth, "depth"}});
};

template <>
struct EnumNames<LostBeats> {
    static constexpr const char* kWhat = "a kind of beat";
    static constexpr auto kTable = name_table<LostBeats>(
        {{LostBeats::kPixels, "pixels"}, {LostBeats::kTable, "table"}, {LostBeats::kAny, "any"}});
};

/// The enumerator's name; "?" for a value that is no enumerator.
template <typename Enum>
constexpr const char* to_string(Enum value) {
    for (const auto& entry : EnumNames<Enum>::kTable) {
        if (entry.value == value) return entry.name;
    }
    return "?";
}

/// The enumerator of that name, if there is one.
template <typename Enum>
constexpr std::optional<Enum> from_name(std::string_view name) {
    for (const auto& entry : EnumNames<Enum>::kTable) {
        if (name == entry.name) return entry.value;
    }
    return std::nullopt;
}

template <typename Enum>
std::vector<std::string> enum_names() {
    std::vector<std::string> names;
    names.reserve(EnumNames<Enum>::kTable.size());
    for (const auto& entry : EnumNames<Enum>::kTable) names.emplace_back(entry.name);
    return names;
}

}  // namespace metabuffer
