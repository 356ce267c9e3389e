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

/// Runs a scenario at a level, which the program chooses. Called once in a process. An InputError that it throws is the
/// scenario's fault, any other exception the model's.
using Simulate = std::function<Simulation(const Scenario& scenario, bool pictures)>;

/// What one simulation is made from.
struct RunRequest {
    std::shared_ptr<const ScenarioTemplate> scenario;
    std::vector<ScenarioOverride> overrides;
    std::vector<Setting> settings;  ///< for the record
    bool pictures = false;
    bool wrong_pixels = false;  ///< are asked for; the run then makes pictures, too
};

/// One simulation in a process of its own, which also makes the scenario. So whatever happens comes back as a record.
class RunProcess {
  public:
    /// Throws InputError if no process can be started for it.
    RunProcess(const Simulate& simulate, RunRequest request);

    int descriptor() const { return process_->descriptor(); }
    bool ended() const { return process_ == nullptr || process_->ended(); }
    /// Real time since it began.
    double seconds() const;
    /// Ends it: its record is that of a crash with this reason.
    void give_up(const std::string& reason);
    /// Reads what the process has sent so far.
    void receive() { process_->receive(received_); }
    /// Only once it has ended.
    RunRecord record() const;

  private:
    RunRequest request_;
    double started_seconds_;
    std::unique_ptr<ChildProcess> process_;
    std::string received_;
    std::string given_up_;  ///< why it was given up, if it was
};

}  // namespace metabuffer::exploration
