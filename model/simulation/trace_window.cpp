#include "simulation/trace_window.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <exception>
#include <limits>
#include <string_view>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/text.h"
#include "scenario/limits.h"

namespace metabuffer {
namespace {

constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLargestFrame = limits::kFrames.high - 1;
constexpr std::int64_t kLargestCycle = 1'000'000'000'000'000;

std::optional<std::int64_t> parse_count(std::string_view text, std::int64_t largest) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < 0 || value > largest) {
        return std::nullopt;
    }
    return value;
}

/// "A-B", or "A" for A-A where that is allowed.
bool parse_range(std::string_view text, std::int64_t largest, bool single_allowed, TraceWindow& window) {
    const std::size_t dash = text.find('-');
    if (dash == std::string_view::npos && !single_allowed) {
        return false;
    }
    const auto first = parse_count(text.substr(0, dash), largest);
    const auto last = dash == std::string_view::npos ? first : parse_count(text.substr(dash + 1), largest);
    if (!first || !last || *last < *first) {
        return false;
    }
    window.first = *first;
    window.last = *last;
    return true;
}

}  // namespace

std::optional<CycleSpan> TraceWindow::fixed_cycles() const {
    if (kind == Kind::kAll) return CycleSpan{0, kForever};
    if (kind == Kind::kCycles) return CycleSpan{first, last};
    return std::nullopt;
}

CycleSpan TraceWindow::around(const CycleSpan& event) const {
    return {std::max<std::int64_t>(0, event.first - before_cycles),
            event.last > kForever - after_cycles ? kForever : event.last + after_cycles};
}

TraceWindow parse_trace_window(const std::string& text) {
    using Kind = TraceWindow::Kind;
    TraceWindow window;
    window.text = text;
    const std::size_t colon = text.find(':');
    const std::string kind = text.substr(0, colon);
    const std::string rest = colon == std::string::npos ? "" : text.substr(colon + 1);
    bool good = false;
    if (kind == "cycles") {
        window.kind = Kind::kCycles;
        good = parse_range(rest, kLargestCycle, false, window);
    } else if (kind == "frames") {
        window.kind = Kind::kFrames;
        good = parse_range(rest, kLargestFrame, true, window);
    } else if (kind == "startframe") {
        window.kind = Kind::kStartFrame;
        good = rest.find('-') == std::string::npos && parse_range(rest, kLargestFrame, true, window);
    } else if (colon == std::string::npos) {
        good = true;
        if (kind == "all") {
            window.kind = Kind::kAll;
        } else if (kind == "first-busready-drop") {
            window.kind = Kind::kFirstBusreadyDrop;
        } else if (kind == "first-starved-pixel") {
            window.kind = Kind::kFirstStarvedPixel;
        } else if (kind == "first-recovered-slot") {
            window.kind = Kind::kFirstRecoveredSlot;
        } else {
            good = false;
        }
    }
    if (!good) {
        throw InputError(
            "--trace-window " + text +
            ": not a window; use all, cycles:A-B, frames:A-B, startframe:K, first-busready-drop, "
            "first-starved-pixel or first-recovered-slot");
    }
    return window;
}

std::string event_text(const TraceWindow& window, const WindowEvent& event, const Scenario& scenario) {
    using Kind = TraceWindow::Kind;
    std::string what = "STARTFRAME of frame " + std::to_string(window.first);
    if (window.kind == Kind::kFirstBusreadyDrop) what = "first BUSREADY drop in a burst";
    if (window.kind == Kind::kFirstRecoveredSlot) what = "first recovered slot";
    if (window.kind == Kind::kFirstStarvedPixel) {
        what = scenario.composer.may_stall() ? "first stall" : "first starved pixel";
    }
    const MachineEvent& start = event.start;
    return what + " at core clock " + std::to_string(start.cycle) + " in composer_" +
           std::to_string(start.renderer) + "_" + std::to_string(start.display) + " (renderer " +
           text::one_line(scenario.renderers[static_cast<std::size_t>(start.renderer - 1)].name) +
           ", column of display " + std::to_string(start.display) + ")";
}

WindowSearch scout(const std::function<WindowSearch()>& run) {
    ChildProcess process([&run](const ChildProcess::Sender& sender) {
        WindowSearch search;
        try {
            search = run();
        } catch (const std::exception&) {  // the real run reports it
        }
        sender.send(&search, sizeof search);
    });
    std::string bytes;
    while (!process.ended()) process.receive(bytes);
    WindowSearch search;
    if (!process.complaint().empty() || bytes.size() != sizeof search) {
        throw InputError("--trace: the run that finds the clock of the event " +
                         (process.complaint().empty() ? "sent no answer" : process.complaint()));
    }
    std::memcpy(&search, bytes.data(), sizeof search);
    return search;
}

}  // namespace metabuffer
