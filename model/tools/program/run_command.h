#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "simulation/trace_window.h"
#include "tools/program/command.h"
#include "tools/program/level_run.h"
#include "tools/program/scenario_options.h"
#include "tools/program/starvation_advice.h"

namespace CLI {
class Option;
}  // namespace CLI

namespace metabuffer {

class PictureSink;

/// `metabuffer run`: one scenario at one level; writes pictures and report, prints a summary.
class RunCommand final : public Command {
  public:
    /// Adds the subcommand and its options.
    explicit RunCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    void add_trace_options();
    /// Adds --print-request for scripts/run. It prints a line for each of scenario, level, out, trace and quiet, as the
    /// command line has them, so no script needs to know which word is an option's value. Add it after all other
    /// options, since their values are set in the order in which they are added.
    void add_request_option();
    /// The requested level; without one, the level that the trace or the check needs, else tlm.
    RunLevel level() const;
    void check_trace(RunLevel level) const;
    void check_schedule_options() const;
    /// The requested window; without one, the first STARTFRAME for a waveform and the whole run for a schedule.
    TraceWindow trace_window() const;
    /// What the options request. Throws InputError if they cannot be combined.
    LevelRequest request() const;
    bool wants_pictures() const;
    LevelOutcome run(const Scenario& scenario, const LevelRequest& request, PictureSink& pictures) const;
    void print_summary(const LevelOutcome& outcome, const std::optional<StarvationAdvice>& advice,
                       const std::string& directory) const;

    ScenarioOptions scenario_;
    std::string level_;  ///< empty if it is not given
    std::string out_directory_;
    std::string trace_file_;
    const CLI::Option* window_option_ = nullptr;
    const CLI::Option* modules_option_ = nullptr;
    std::vector<const CLI::Option*> around_options_;  ///< clocks around a window's event
    std::string trace_window_;                        ///< if window_option_ is given
    std::optional<std::int64_t> trace_before_cycles_;
    std::optional<std::int64_t> trace_after_cycles_;
    std::vector<std::string> trace_blocks_;
    std::string pictures_;
    bool no_images_ = false;
    bool check_ = false;
    bool strict_ = false;
    bool quiet_ = false;
};

}  // namespace metabuffer
