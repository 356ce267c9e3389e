#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "report/cycle_span.h"
#include "report/machine_event.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// The part of a run that a trace shows, as asked for.
struct TraceWindow {
    enum class Kind : std::uint8_t {
        kAll,
        kCycles,              ///< core cycles first..last
        kFrames,              ///< from STARTFRAME of frame first to the last pixel of frame last
        kStartFrame,          ///< around STARTFRAME of frame first
        kFirstBusreadyDrop,   ///< around the first BUSREADY drop in a burst
        kFirstStarvedPixel,   ///< around the first starved pixel or stalled clock
        kFirstRecoveredSlot,  ///< around the first burst for which the arbiter has passed over slots
    };
    static constexpr std::int64_t kDefaultBeforeCycles = 200;
    static constexpr std::int64_t kDefaultAfterCycles = 2000;

    std::string text;  ///< as it was asked for
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

/// Reads `all`, `cycles:A-B`, `frames:A-B`, `frames:A`, `startframe:K`, `first-busready-drop`, `first-starved-pixel` or
/// `first-recovered-slot`. Throws InputError.
TraceWindow parse_trace_window(const std::string& text);

/// What a window lies around.
struct WindowEvent {
    MachineEvent start;
    std::int64_t last_cycle = ComposerRecord::kNever;  ///< start.cycle, but for frames their end

    CycleSpan cycles() const { return {start.cycle, last_cycle}; }
};

/// A window's event in a machine of any level; nothing if it has not happened yet, or if the window has no event.
template <typename Machine>
std::optional<WindowEvent> event_of(const TraceWindow& window, const Machine& machine) {
    using Kind = TraceWindow::Kind;
    MachineEvent start;
    std::optional<std::int64_t> last_cycle;
    switch (window.kind) {
        case Kind::kAll:
        case Kind::kCycles:
            break;
        case Kind::kFrames:
            start = machine.startframe(static_cast<int>(window.first));
            last_cycle = machine.frame_end_cycle(static_cast<int>(window.last));
            break;
        case Kind::kStartFrame:
            start = machine.startframe(static_cast<int>(window.first));
            break;
        case Kind::kFirstBusreadyDrop:
            start = machine.first_busready_drop();
            break;
        case Kind::kFirstStarvedPixel:
            start = machine.first_starved();
            break;
        case Kind::kFirstRecoveredSlot:
            start = machine.first_recovered_slot();
            break;
    }
    const WindowEvent event{start, last_cycle.value_or(start.cycle)};
    if (!start.happened() || event.last_cycle == ComposerRecord::kNever) return std::nullopt;
    return event;
}

/// The event in words: what it is, its core clock, its composer with renderer and column.
std::string event_text(const TraceWindow& window, const WindowEvent& event, const Scenario& scenario);

/// What a search for a window's event has found.
struct WindowSearch {
    std::optional<WindowEvent> event;
    bool whole_run = false;  ///< without an event: the run came to its end, by no error and no watchdog
};

/// Searches for a window's event in a separate process, where `run` runs a machine up to the event. A trace must start
/// before its event, so an earlier run has to find the event; every run is the same. If `run` throws, there is no event:
/// the real run meets the same error and reports it. Call it before this process elaborates anything. Throws InputError.
WindowSearch scout(const std::function<WindowSearch()>& run);

}  // namespace metabuffer
