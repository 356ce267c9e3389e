#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "coverage_recorder.h"
#include "monitors/machine_monitors.h"
#include "monitors/violation.h"
#include "rtl/metabuffer.h"
#include "scenario/scenario.h"
#include "shown_pictures.h"
#include "window_events.h"

namespace metabuffer::test {

/// A clocked machine and everything that a run of it shows, under all monitors: a violation ends the test with an
/// error that names machine, rule, signal, clock and frame. Several can stand in one elaboration and run side by side;
/// each has its own clocks.
class MachineRun {
  public:
    MachineRun(const std::string& name, Scenario scenario, rtl::ClockGating gating = rtl::ClockGating::kOn);
    MachineRun(const MachineRun&) = delete;
    MachineRun& operator=(const MachineRun&) = delete;

    const Scenario& scenario() const { return scenario_; }
    const rtl::Metabuffer& machine() const { return *machine_; }
    rtl::Metabuffer& machine() { return *machine_; }
    const monitors::MachineMonitors& monitors() const { return *monitors_; }
    bool finished() const { return machine_->finished(); }

    /// The report at the clock in which the run finished.
    const RunReport& report() const { return report_; }
    /// The events that trace windows are put around, at that clock.
    const WindowEvents& window_events() const { return window_events_; }
    /// The report after run_to_end(), which includes what the buses still had to send.
    const RunReport& drained_report() const { return drained_report_; }

    /// What a display (from 1) showed of a frame (from 0); null if it never did.
    const ColourImage* picture(int frame, int display) const { return shown_.picture(frame, display); }
    /// How often a frame was shown first: 1 for each frame and display of a whole run.
    int times_shown(int frame, int display) const { return shown_.times_shown(frame, display); }

    /// Whether renderer and display (from 1) reported that raster pixel as starved.
    bool has_starved_pixel(int renderer, int display, const StarvedPixel& pixel) const;
    std::int64_t starved_pixels_located(int renderer, int display) const;
    /// A pixel was located twice, or outside the raster or the run.
    bool starved_pixels_malformed() const { return starved_pixels_malformed_; }

    void read_drained_report() { drained_report_ = machine_->report(); }

  private:
    std::size_t composer(int renderer, int display) const;
    void take_starved_pixel(int renderer, int display, const StarvedPixel& pixel);

    Scenario scenario_;
    std::unique_ptr<rtl::Metabuffer> machine_;
    monitors::ViolationLog violations_;
    std::unique_ptr<monitors::MachineMonitors> monitors_;
    ShownPictures shown_;
    std::vector<std::vector<bool>> starved_pixels_;  ///< by composer: one flag a raster pixel and frame
    std::vector<std::int64_t> located_;              ///< by composer
    bool starved_pixels_malformed_ = false;
    RunReport report_;
    WindowEvents window_events_;
    RunReport drained_report_;
    coverage::CoverageRecorder coverage_;
};

/// Runs the simulation until the condition holds. False if it does not after a time in which any machine of
/// these tests has finished.
bool simulate_until(const std::function<bool()>& condition);

using MachineRuns = std::vector<std::unique_ptr<MachineRun>>;

/// Runs the machines side by side until each has finished and its buses stand still: in `glitch` mode the last frame may
/// be shown before its late pixels have been sent. Then its clocks stop, unless a watchdog has ended it. False if one has
/// not come there after a time in which any machine of these tests does.
bool run_to_end(const std::vector<rtl::Metabuffer*>& machines);
bool run_to_end(const MachineRuns& runs);

}  // namespace metabuffer::test
