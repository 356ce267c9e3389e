#pragma once

#include <map>
#include <string>
#include <vector>

#include "simulation/trace_window.h"

namespace metabuffer::test {

/// Core cycles and composer of every event that a trace window can be put around, as text, by the window.
using WindowEvents = std::map<std::string, std::string>;

/// Every kind of event, and for frames each one of a run of so many and the first that it does not have.
inline std::vector<std::string> windows_around_events(int frames) {
    std::vector<std::string> windows{"first-busready-drop", "first-starved-pixel", "first-recovered-slot",
                                     "frames:0-" + std::to_string(frames - 1)};
    for (int frame = 0; frame <= frames; ++frame) {
        windows.push_back("startframe:" + std::to_string(frame));
        windows.push_back("frames:" + std::to_string(frame));
    }
    return windows;
}

/// The events of a machine of any level, when its run has finished.
template <typename Machine>
WindowEvents window_events_of(const Machine& machine, int frames) {
    WindowEvents events;
    for (const std::string& window : windows_around_events(frames)) {
        const auto event = event_of(parse_trace_window(window), machine);
        events[window] = event ? std::to_string(event->start.cycle) + " to " +
                                     std::to_string(event->last_cycle) + " in composer_" +
                                     std::to_string(event->start.renderer) + "_" +
                                     std::to_string(event->start.display)
                               : "never";
    }
    return events;
}

}  // namespace metabuffer::test
