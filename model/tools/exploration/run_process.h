#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "formats/image.h"
#include "host/child_process.h"
#include "report/report.h"
#include "scenario/scenario_template.h"
#include "tools/exploration/results_database.h"

namespace metabuffer::exploration {

struct Simulation {
    RunReport report;
    std::vector<ColourImage> pictures;  ///< the last frame on each display; empty if they were not asked for
};

/// Runs a scenario: the level that the program hands in. Called once in a process. What it throws is the model's
/// fault, but for an InputError.
using Simulate = std::function<Simulation(const Scenario& scenario, bool pictures)>;

/// What one simulation is made from.
struct RunRequest {
    std::shared_ptr<const ScenarioTemplate> scenario;
    std::vector<ScenarioOverride> overrides;
    std::vector<Setting> settings;  ///< go to the record
    bool pictures = false;
    bool wrong_pixels = false;  ///< are asked for, which takes pictures too
};

/// One simulation in a process of its own, scenario and all, so that whatever happens there comes back as a record.
class RunProcess {
  public:
    /// Throws InputError if this computer has no process for it.
    RunProcess(const Simulate& simulate, RunRequest request);

    int descriptor() const { return process_->descriptor(); }
    bool ended() const { return process_ == nullptr || process_->ended(); }
    /// Real time since it began.
    double seconds() const;
    /// Ends it: its record is that of a crash with this reason.
    void give_up(const std::string& reason);
    /// Reads what is there.
    void receive() { process_->receive(received_); }
    /// Once it has ended.
    RunRecord record() const;

  private:
    RunRequest request_;
    double started_seconds_;
    std::unique_ptr<ChildProcess> process_;
    std::string received_;
    std::string given_up_;  ///< why, if it was
};

}  // namespace metabuffer::exploration
