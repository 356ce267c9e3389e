#include "tools/program/sizing.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "host/errors.h"
#include "host/text.h"
#include "scenario/rate_limits.h"
#include "scenario/scenario_template.h"
#include "tools/analysis/analysis_report.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/exploration/value.h"

namespace metabuffer {
namespace {

using exploration::Axis;
using exploration::SearchDescription;

constexpr const char* kCoreClockKey = "clocks.core_mhz";

/// Splits "KEY=REST"; REST is empty without a '='.
std::pair<std::string, std::string> split_assignment(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) return {text, ""};
    return {text.substr(0, equals), text.substr(equals + 1)};
}

double number_in(const std::string& text, const std::string& where) {
    const exploration::Value value = exploration::value_of(text);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    if (const auto* number = std::get_if<double>(&value)) return *number;
    throw InputError(where + ": " + text::quoted(text) +
                     " is not a number; use FROM..TO, like 16..4096, or FROM..TO+STEP, like 60..100+0.5");
}

/// Whether a change of the key leaves raster, displays and links as they are.
bool leaves_limits(const std::string& key) {
    const auto begins = [&key](const char* map) { return key.rfind(map, 0) == 0; };
    return begins("composer.") || begins("bus.") || begins("memory.");
}

}  // namespace

SearchDescription minimized(const std::string& minimize) {
    const std::string where = "--minimize " + minimize;
    const auto [key, range] = split_assignment(minimize);
    if (range.empty()) return exploration::describe_search(key, std::nullopt, std::nullopt, where);
    const std::size_t dots = range.find("..");
    if (dots != std::string::npos) {
        const std::string rest = range.substr(dots + 2);
        const std::size_t plus = rest.find('+', 1);
        std::optional<double> step;
        if (plus != std::string::npos) step = number_in(rest.substr(plus + 1), where);
        return exploration::describe_search(key, number_in(range.substr(0, dots), where),
                                            number_in(rest.substr(0, plus), where), where, step);
    }
    SearchDescription search = exploration::describe_search(key, std::nullopt, std::nullopt, where);
    if (search.step > 0.0) throw InputError(where + ": takes fractions; use FROM..TO+STEP, like 60..100+0.5");
    std::vector<std::int64_t>& candidates = search.candidates;
    candidates.clear();
    for (const std::string& value : exploration::parse_values(range, where)) {
        const double number = number_in(value, where);
        if (number != std::floor(number))
            throw InputError(where + ": " + text::quoted(value) + " is not a whole number");
        candidates.push_back(static_cast<std::int64_t>(number));
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    return search;
}

exploration::SweepDescription describe_size(const SizeRequest& request) {
    exploration::SweepDescription description;
    description.scenario = request.file;
    description.name = std::filesystem::path(request.file).stem().string();
    description.fixed = request.overrides;
    for (const std::string& over : request.over) {
        const auto [key, values] = split_assignment(over);
        const std::string where = "--over " + over;
        if (values.empty())
            throw InputError(where + ": has no values; use KEY=VALUES, like bus.width_bits=32,64");
        description.axes.push_back(Axis{{key}, {exploration::parse_values(values, where)}, {where}});
    }
    description.search = minimized(request.minimize.back());
    description.search->checks = request.checks;
    if (!request.goal.empty()) {
        description.search->goal = request.goal;
        description.search->where = "--goal " + request.goal;
    }
    if (request.frame_rate_hz) {
        // A rate that misses the requested one only because clocks are rounded is good enough.
        description.search->goal = "(" + description.search->goal +
                                   ") and frames_per_second >= " + text::number(1.0 - kRateTolerance) +
                                   " * " + text::number(*request.frame_rate_hz);
    }
    return description;
}

void check_frames(const SizeRequest& request, const exploration::SweepPlan& plan) {
    if (!request.frame_rate_hz) return;
    const ScenarioTemplate scenario(request.file);
    for (const exploration::Point& point : plan.points) {
        int frames = kFramesForRates;
        try {
            frames = std::stoi(scenario.settings(plan.overrides_of(point.settings)).at("frames"));
        } catch (const InputError&) {
            continue;  // running the point reports what is wrong with it
        }
        if (frames < kFramesForRates) {
            throw InputError("--frame-rate-hz: a run of " + text::counted(frames, "frame") +
                             " has no rate; use --frames " + std::to_string(kFramesForRates) + " or more");
        }
        if (exploration::find_setting(point.settings, "frames") == nullptr) return;  // the same for all
    }
}

exploration::KnownAnswer known_answer(const SizeRequest& request, const Scenario& scenario,
                                      const SearchDescription& search) {
    exploration::KnownAnswer known;
    const bool of_buffers = search.key == kBufferKey;
    const bool of_core_clock = search.key == kCoreClockKey;
    if (!of_core_clock && !leaves_limits(search.key)) return known;
    const double asked = request.frame_rate_hz.value_or(0.0) * (1.0 - kRateTolerance);
    analysis::Analysis analysis;
    std::string too_slow;
    if (of_core_clock) {
        // The core clock changes the rate of the raster, but not the rates of links and displays.
        const RateLimits limits = rate_limits(scenario);
        if (limits.links_hz() < asked) too_slow = "the links";
        if (limits.refresh_hz < asked) too_slow = "the displays";
    } else {
        analysis = analysis::analyze(scenario, {std::nullopt, request.frame_rate_hz});
        if (request.frame_rate_hz) too_slow = analysis::too_slow_for(analysis, asked, of_buffers);
    }
    if (!too_slow.empty()) {
        known.hopeless = "no " + search.key + " brings " + text::number(*request.frame_rate_hz) +
                         " frames/s: too slow for it: " + too_slow;
        return known;
    }
    const bool has_range =
        std::any_of(request.minimize.begin(), request.minimize.end(),
                    [&search](const std::string& text) { return text.rfind(search.key + "=", 0) == 0; });
    if (!of_buffers || has_range || !request.goal.empty()) return known;
    known.least = analysis.least_buffer_pixels;
    const std::int64_t whole = analysis.whole_buffer_pixels;
    if (request.frame_rate_hz) {
        known.most = 2 * whole;  // a buffer can hold pixels of two frames
    } else {
        const bool has_bound = analysis.safe_buffer_is_legal.value_or(false);
        known.enough = has_bound ? std::min(whole, *analysis.safe_buffer_pixels) : whole;
    }
    return known;
}

}  // namespace metabuffer
