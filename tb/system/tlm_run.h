#pragma once

#include <memory>
#include <string>
#include <vector>

#include "machine_run.h"
#include "scenario/scenario.h"
#include "shown_pictures.h"
#include "tlm/metabuffer.h"
#include "window_events.h"

namespace metabuffer::test {

/// A transaction-level machine and everything that a run of it shows. Several can stand in one elaboration,
/// beside clocked machines.
class TlmRun {
  public:
    /// Without `images` the machine counts and shows nothing.
    TlmRun(const std::string& name, Scenario scenario, bool images = true);
    TlmRun(const TlmRun&) = delete;
    TlmRun& operator=(const TlmRun&) = delete;

    const Scenario& scenario() const { return scenario_; }
    bool has_images() const { return has_images_; }
    bool finished() const { return machine_->finished(); }
    /// The report at the clock in which the run finished.
    const RunReport& report() const { return report_; }
    /// The events that trace windows are put around, at that clock.
    const WindowEvents& window_events() const { return window_events_; }
    const ShownPictures& pictures() const { return shown_; }

  private:
    Scenario scenario_;
    bool has_images_;
    ShownPictures shown_;
    std::unique_ptr<tlm::Metabuffer> machine_;
    RunReport report_;
    WindowEvents window_events_;
};

using TlmRuns = std::vector<std::unique_ptr<TlmRun>>;

/// One scenario at both levels, and at level tlm once more without images.
struct LevelRuns {
    std::unique_ptr<MachineRun> rtl;
    std::unique_ptr<TlmRun> tlm;
    std::unique_ptr<TlmRun> counters_only;

    /// Machines of one elaboration need different names.
    LevelRuns(const std::string& name, const Scenario& scenario);
};

/// Runs both levels to their ends. False if one does not come there.
bool run_to_end(const TlmRuns& runs);
bool run_to_end(const std::vector<LevelRuns>& runs);

/// Each line is a counter, a picture, the event of a trace window or a run's end in which the levels differ; none if
/// they agree. Call it when the runs have finished, or never will.
std::vector<std::string> level_differences(const MachineRun& rtl, const TlmRun& tlm);
std::vector<std::string> level_differences(const LevelRuns& runs);
/// Checks that there are none. A failure describes the machine.
void check_levels(const LevelRuns& runs);

/// The first lines, for a test's message: more would hide them.
std::string first_lines(const std::vector<std::string>& lines);

}  // namespace metabuffer::test
