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
      starved_pixels_(scenario_.renderers.size() * static_cast<std::size_t>(scenario_.displays.count())),
      located_(starved_pixels_.size()),
      coverage_(*machine_, scenario_) {
    machine_->on_frame_shown([this](const DisplayedFrame& displayed) {
        shown_.take(displayed.frame, displayed.display, displayed.picture);
    });
    machine_->on_starved_pixel([this](int renderer, int display, const StarvedPixel& pixel) {
        take_starved_pixel(renderer, display, pixel);
    });
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

void MachineRun::take_starved_pixel(int renderer, int display, const StarvedPixel& pixel) {
    const int width = scenario_.displays.raster_width_pixels();
    const int height = scenario_.displays.raster_height_pixels();
    if (pixel.frame < 0 || pixel.frame >= scenario_.frames || pixel.x < 0 || pixel.x >= width ||
        pixel.y < 0 || pixel.y >= height) {
        starved_pixels_malformed_ = true;
        return;
    }
    std::vector<bool>& flags = starved_pixels_.at(composer(renderer, display));
    flags.resize(static_cast<std::size_t>(scenario_.frames) * static_cast<std::size_t>(width) *
                 static_cast<std::size_t>(height));
    const auto flag = static_cast<std::size_t>((pixel.frame * height + pixel.y) * width + pixel.x);
    starved_pixels_malformed_ = starved_pixels_malformed_ || flags[flag];
    flags[flag] = true;
    ++located_[composer(renderer, display)];
}

bool MachineRun::has_starved_pixel(int renderer, int display, const StarvedPixel& pixel) const {
    const std::vector<bool>& flags = starved_pixels_.at(composer(renderer, display));
    const int width = scenario_.displays.raster_width_pixels();
    const int height = scenario_.displays.raster_height_pixels();
    const auto flag = static_cast<std::size_t>((pixel.frame * height + pixel.y) * width + pixel.x);
    return flag < flags.size() && flags[flag];
}

std::int64_t MachineRun::starved_pixels_located(int renderer, int display) const {
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
