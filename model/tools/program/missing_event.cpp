#include "tools/program/missing_event.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "host/errors.h"
#include "scenario/limits.h"
#include "scenario/scenario_loader.h"
#include "tlm/run.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/program/level_run.h"

namespace metabuffer {
namespace {

/// A scenario with other settings, and the options that make it.
struct Change {
    Scenario scenario;
    std::string options;

    void ready_space(int pixels) {
        scenario.composer.ready_space_pixels = pixels;
        note("composer.ready_space_pixels", std::to_string(pixels));
    }
    void buffer(std::int64_t pixels) {
        scenario.composer.buffer_pixels = static_cast<int>(pixels);
        note("composer.buffer_pixels", std::to_string(pixels));
    }
    void bus_width(int bits) {
        const int before = default_ready_space_pixels(scenario.bus, scenario.memory);
        scenario.bus.width_bits = bits;
        note("bus.width_bits", std::to_string(bits));
        if (scenario.composer.ready_space_pixels == before) {
            scenario.composer.ready_space_pixels = default_ready_space_pixels(scenario.bus, scenario.memory);
        }
    }
    void arbitration(Arbitration policy) {
        scenario.bus.arbitration = policy;
        note("bus.arbitration", to_string(policy));
    }

  private:
    void note(const std::string& key, const std::string& value) {
        options += (options.empty() ? "--set " : " --set ") + key + "=" + value;
    }
};

/// Why the event does not happen, and changes that may bring it about, the smallest first.
struct Explanation {
    std::string why;
    std::vector<Change> changes;
};

Explanation no_busready_drop(const Scenario& scenario, std::int64_t least_buffer) {
    const ComposerConfig& composer = scenario.composer;
    Explanation text;
    text.why = composer.ready_space_pixels >= scenario.bus.burst_pixels
                   ? "BUSREADY never drops in a burst, since a composer takes a slot only with room for "
                     "composer.ready_space_pixels, " +
                         std::to_string(composer.ready_space_pixels) + ", and no burst is longer"
                   : "BUSREADY never drops in a burst, since no buffer (composer.buffer_pixels: " +
                         std::to_string(composer.buffer_pixels) + ") is full before a burst for it ends";
    Change change{scenario, {}};
    change.ready_space(in_flight_pixels(scenario.bus, scenario.memory));
    text.changes.push_back(change);
    change.buffer(least_buffer);
    text.changes.push_back(change);
    return text;
}

Explanation no_starved_pixel(const Scenario& scenario, std::int64_t least_buffer) {
    Explanation text;
    text.why = "no pixel starves, since bus and memory bring each one in time with a bus.width_bits of " +
               std::to_string(scenario.bus.width_bits) + " and composer.buffer_pixels of " +
               std::to_string(scenario.composer.buffer_pixels);
    Change change{scenario, {}};
    for (auto bits = limits::kBusWidthsBits.rbegin(); bits != limits::kBusWidthsBits.rend(); ++bits) {
        if (*bits >= scenario.bus.width_bits) continue;
        change = Change{scenario, {}};
        change.bus_width(*bits);
        text.changes.push_back(change);
    }
    change.buffer(least_buffer);
    text.changes.push_back(change);
    return text;
}

Explanation no_recovered_slot(const Scenario& scenario, std::int64_t least_buffer) {
    const ArbitrationRow& policy = arbitration_row(scenario.bus.arbitration);
    const std::string named = std::string("bus.arbitration ") + policy.name;
    Explanation text;
    const auto has_one_row = [](const RendererFrame& frame) { return frame.table.size() < 2; };
    if (std::all_of(scenario.renderers.begin(), scenario.renderers.end(), [&](const Renderer& renderer) {
            return std::all_of(renderer.frames.begin(), renderer.frames.end(), has_one_row);
        })) {
        text.why =
            "no slot is recovered, since no table has rows for two displays; use a viewport that covers "
            "several";
        return text;
    }
    Change change{scenario, {}};
    if (policy.slot_table == nullptr || policy.idle_slots == IdleSlots::kLost) {
        text.why = "no slot is recovered, since " + named +
                   (policy.slot_table == nullptr ? " has no slots" : " lets those that are not used pass");
        change.arbitration(Arbitration::kIrsa);
        text.changes.push_back(change);
    } else {
        text.why = "no slot is recovered, since each composer takes its slots while it has pixels to come";
    }
    change.buffer(least_buffer);
    text.changes.push_back(change);
    return text;
}

/// The first change with which the event happens; null if none is found.
const Change* working(const std::vector<Change>& changes, const TraceWindow& window) {
    using Clock = std::chrono::steady_clock;
    // No trial begins later, so that a large machine's refusal does not take minutes.
    const Clock::time_point end = Clock::now() + std::chrono::seconds(5);
    for (const Change& change : changes) {
        try {
            check_scenario(change.scenario);
            if (tlm::find_event(change.scenario, window).event) return &change;
        } catch (const InputError&) {
            // No valid scenario.
        }
        if (Clock::now() >= end) break;
    }
    return nullptr;
}

Explanation explanation(const Scenario& scenario, const TraceWindow& window) {
    using Kind = TraceWindow::Kind;
    const std::int64_t least_buffer = analysis::analyze(scenario).least_buffer_pixels;
    if (window.kind == Kind::kFirstBusreadyDrop) return no_busready_drop(scenario, least_buffer);
    if (window.kind == Kind::kFirstStarvedPixel) return no_starved_pixel(scenario, least_buffer);
    return no_recovered_slot(scenario, least_buffer);
}

}  // namespace

std::string missing_event_text(const Scenario& scenario, const TraceWindow& window) {
    using Kind = TraceWindow::Kind;
    if (window.kind == Kind::kStartFrame || window.kind == Kind::kFrames) {
        const std::int64_t last = window.kind == Kind::kFrames ? window.last : window.first;
        return "frame " + std::to_string(last) + " does not happen, since the run ends with frame " +
               std::to_string(scenario.frames - 1) + "; it does with --frames " + std::to_string(last + 1);
    }
    const Explanation text = explanation(scenario, window);
    if (text.changes.empty()) return text.why;
    if (!level_tlm_knows_clocks(scenario)) return text.why + "; it may with " + text.changes.front().options;
    const Change* const change = working(text.changes, window);
    return text.why + (change != nullptr ? "; it does with " + change->options
                                         : "; none of the changes that were tried brings it about");
}

}  // namespace metabuffer
