#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "report/composer_record.h"
#include "report/cycle_span.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// The part of a run that a trace shows, as asked for.
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

    /// Its cycles, if they do not depend on what happens in the run.
    std::optional<CycleSpan> fixed_cycles() const;
    /// Its cycles, given those of its event: before_cycles more before it, after_cycles more after it.
    CycleSpan around(const CycleSpan& event) const;
};

/// Reads `all`, `cycles:A-B`, `frames:A-B`, `frames:A`, `startframe:K`, `first-busready-drop` or
/// `first-starved-pixel`. Throws InputError.
TraceWindow parse_trace_window(const std::string& text);

/// The cycles of the event that a window lies around, in a machine of any level; nothing if it has not happened yet, or if
/// the window has no event.
template <typename Machine>
std::optional<CycleSpan> event_of(const TraceWindow& window, const Machine& machine) {
    using Kind = TraceWindow::Kind;
    CycleSpan event{ComposerRecord::kNever, ComposerRecord::kNever};
    switch (window.kind) {
        case Kind::kAll:
        case Kind::kCycles:
            break;
        case Kind::kFrames:
            event.first = machine.startframe_cycle(static_cast<int>(window.first));
            event.last = machine.frame_end_cycle(static_cast<int>(window.last));
            break;
        case Kind::kStartFrame:
            event.first = event.last = machine.startframe_cycle(static_cast<int>(window.first));
            break;
        case Kind::kFirstBusreadyDrop:
            event.first = event.last = machine.first_busready_drop_cycle();
            break;
        case Kind::kFirstStarvedPixel:
            event.first = event.last = machine.first_starved_cycle();
            break;
    }
    if (event.first == ComposerRecord::kNever || event.last == ComposerRecord::kNever) return std::nullopt;
    return event;
}

/// Finds the cycles of a window that depends on the run; nothing if the run does not have its event. Call it before
/// this process elaborates anything.
using FindWindow =
    std::function<std::optional<CycleSpan>(const Scenario& scenario, const TraceWindow& window)>;

/// Makes a level's FindWindow: calls `search` in a separate process, where it runs a machine up to the window's event. A
/// trace must start before its event, so an earlier run has to find the event; every run is the same. If `search` throws,
/// there is no event: the real run meets the same error and reports it. Throws InputError.
std::optional<CycleSpan> scout(const TraceWindow& window,
                               const std::function<std::optional<CycleSpan>()>& search);

}  // namespace metabuffer
