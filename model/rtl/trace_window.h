#pragma once

#include <cstdint>
#include <string>

namespace metabuffer::rtl {

/// Core cycles first..last, both included.
struct CycleRange {
    std::int64_t first = 0;
    std::int64_t last = 0;
};

/// The part of a run that a waveform shows, as asked for.
struct TraceWindow {
    enum class Kind : std::uint8_t {
        kAll,
        kCycles,             ///< core cycles first..last
        kFrames,             ///< from STARTFRAME of frame first to the last pixel of frame last
        kStartFrame,         ///< around STARTFRAME of frame first
        kFirstBusreadyDrop,  ///< around the first BUSREADY drop in a burst
        kFirstStarvedPixel,  ///< around the first starved pixel or stalled clock
    };
    static constexpr std::int64_t kDefaultBeforeCycles = 200;
    static constexpr std::int64_t kDefaultAfterCycles = 2000;

    Kind kind = Kind::kStartFrame;
    std::int64_t first = 0;
    std::int64_t last = 0;
    std::int64_t before_cycles = kDefaultBeforeCycles;  ///< not for kAll and kCycles
    std::int64_t after_cycles = kDefaultAfterCycles;
};

/// Reads `all`, `cycles:A-B`, `frames:A-B`, `frames:A`, `startframe:K`, `first-busready-drop` or
/// `first-starved-pixel`. Throws InputError.
TraceWindow parse_trace_window(const std::string& text);

}  // namespace metabuffer::rtl
