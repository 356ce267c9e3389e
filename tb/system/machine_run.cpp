#include "machine_run.h"

#include <algorithm>
#include <utility>

namespace metabuffer::test {
namespace {

const sc_core::sc_time kChunk(100.0, sc_core::SC_US);
const sc_core::sc_time kFarTooLong(2.0, sc_core::SC_SEC);

}  // namespace

MachineRun::MachineRun(const std::string& name, Scenario scenario, rtl::ClockGating gating)
    : scenario_(std::move(scenario)),
      machine_(std::make_unique<rtl::Metabuffer>(name.c_str(), scenario_, gating)),
      monitors_(std::make_unique<monitors::MachineMonitors>((name + "_monitors").c_str(), scenario_,
                                                            *machine_, violations_)),
      shown_(scenario_),
      glitches_(scenario_.renderers.size() * static_cast<std::size_t>(scenario_.displays.count())),
      located_(glitches_.size()),
      coverage_(*machine_, scenario_) {
    machine_->on_frame_shown([this](const DisplayedFrame& displayed) {
        shown_.take(displayed.frame, displayed.display, displayed.picture);
    });
    machine_->on_glitch(
        [this](int renderer, int display, const Glitch& glitch) { take_glitch(renderer, display, glitch); });
    machine_->on_finished([this] {
        report_ = machine_->report();
        window_events_ = window_events_of(*machine_, scenario_.frames);
        coverage_.finished(report_);
        monitors_->finish(report_);
    });
    violations_.on_violation([name](const monitors::Violation& violation) {
        SC_REPORT_ERROR(("/metabuffer/monitor/" + violation.rule).c_str(),
                        (name + ": " + to_string(violation)).c_str());
    });
}

std::size_t MachineRun::composer(int renderer, int display) const {
    return static_cast<std::size_t>((renderer - 1) * scenario_.displays.count() + display - 1);
}

void MachineRun::take_glitch(int renderer, int display, const Glitch& glitch) {
    const int width = scenario_.displays.raster_width_pixels();
    const int height = scenario_.displays.raster_height_pixels();
    if (glitch.frame < 0 || glitch.frame >= scenario_.frames || glitch.x < 0 || glitch.x >= width ||
        glitch.y < 0 || glitch.y >= height) {
        glitches_malformed_ = true;
        return;
    }
    std::vector<bool>& flags = glitches_.at(composer(renderer, display));
    flags.resize(static_cast<std::size_t>(scenario_.frames) * static_cast<std::size_t>(width) *
                 static_cast<std::size_t>(height));
    const auto flag = static_cast<std::size_t>((glitch.frame * height + glitch.y) * width + glitch.x);
    glitches_malformed_ = glitches_malformed_ || flags[flag];
    flags[flag] = true;
    ++located_[composer(renderer, display)];
}

bool MachineRun::has_glitch(int renderer, int display, const Glitch& glitch) const {
    const std::vector<bool>& flags = glitches_.at(composer(renderer, display));
    const int width = scenario_.displays.raster_width_pixels();
    const int height = scenario_.displays.raster_height_pixels();
    const auto flag = static_cast<std::size_t>((glitch.frame * height + glitch.y) * width + glitch.x);
    return flag < flags.size() && flags[flag];
}

std::int64_t MachineRun::glitches_located(int renderer, int display) const {
    return located_.at(composer(renderer, display));
}

bool simulate_until(const std::function<bool()>& condition) {
    while (!condition()) {
        if (sc_core::sc_time_stamp() > kFarTooLong) return false;
        sc_core::sc_start(kChunk);
    }
    return true;
}

void drain_buses(const std::function<std::int64_t()>& pixels_sent) {
    // A chunk is longer than any bus of these tests waits for a page or a slot.
    std::int64_t sent = -1;
    std::int64_t sent_before = -2;
    while (sent != sent_before) {
        sc_core::sc_start(kChunk);
        sent_before = sent;
        sent = pixels_sent();
    }
}

bool run_to_end(MachineRuns& runs) {
    const bool finished = simulate_until([&runs] {
        return std::all_of(runs.begin(), runs.end(), [](const auto& run) { return run->finished(); });
    });
    if (!finished) return false;
    drain_buses([&runs] {
        std::int64_t sent = 0;
        for (const auto& run : runs) {
            run->read_drained_report();
            sent += run->drained_report().total_bus().pixels_sent;
        }
        return sent;
    });
    return true;
}

}  // namespace metabuffer::test
