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

bool run_to_end(const std::vector<rtl::Metabuffer*>& machines) {
    struct Running {
        rtl::Metabuffer* machine;
        std::int64_t pixels_sent;  ///< by its buses, when last looked at after the machine's end
    };
    std::vector<Running> all;
    for (rtl::Metabuffer* const machine : machines) all.push_back({machine, -1});
    // A chunk is longer than any bus of these tests waits for a page or a slot.
    const auto has_ended = [](Running& running) {
        if (!running.machine->finished()) return false;
        const RunReport report = running.machine->report();
        const std::int64_t sent = report.total_bus().pixels_sent;
        if (std::exchange(running.pixels_sent, sent) != sent) return false;
        // A watchdog ends a run before its frames: what is shown of them later can be compared too.
        if (report.watchdog.empty()) running.machine->stop_clocks();
        return true;
    };
    return simulate_until([&all, &has_ended] {
        all.erase(std::remove_if(all.begin(), all.end(), has_ended), all.end());
        return all.empty();
    });
}

bool run_to_end(const MachineRuns& runs) {
    std::vector<rtl::Metabuffer*> machines;
    for (const auto& run : runs) machines.push_back(&run->machine());
    const bool ended = run_to_end(machines);
    for (const auto& run : runs) run->read_drained_report();
    return ended;
}

}  // namespace metabuffer::test
