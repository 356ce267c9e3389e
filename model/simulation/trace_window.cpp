#include "simulation/trace_window.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <exception>
#include <limits>
#include <string_view>

#include "host/child_process.h"
#include "host/errors.h"

namespace metabuffer {
namespace {

constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLargestFrame = 1'000'000;
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
        } else {
            good = false;
        }
    }
    if (!good) {
        throw InputError(
            "--trace-window " + text +
            ": not a window; use all, cycles:A-B, frames:A-B, startframe:K, first-busready-drop or "
            "first-starved-pixel");
    }
    return window;
}

std::optional<CycleSpan> scout(const TraceWindow& window,
                               const std::function<std::optional<CycleSpan>()>& search) {
    constexpr CycleSpan kNotFound{0, -1};
    ChildProcess process([&search, kNotFound](const ChildProcess::Sender& sender) {
        CycleSpan event = kNotFound;
        try {
            event = search().value_or(kNotFound);
        } catch (const std::exception&) {  // the real run reports it
        }
        sender.send(&event, sizeof event);
    });
    std::string bytes;
    while (!process.ended()) process.receive(bytes);
    CycleSpan event;
    if (!process.complaint().empty() || bytes.size() != sizeof event) {
        throw InputError("--trace: the run that finds the clock of the event " +
                         (process.complaint().empty() ? "sent no answer" : process.complaint()));
    }
    std::memcpy(&event, bytes.data(), sizeof event);
    if (event.last < event.first) return std::nullopt;
    return window.around(event);
}

}  // namespace metabuffer
