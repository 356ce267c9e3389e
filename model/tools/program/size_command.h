#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/exploration/sweep_plan.h"
#include "tools/program/command.h"
#include "tools/program/exploration_run.h"
#include "tools/program/scenario_options.h"

namespace metabuffer {

/// `metabuffer size`: the smallest value of a key that meets a goal, over the values of other keys.
class SizeCommand final : public Command {
  public:
    explicit SizeCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    exploration::SweepDescription description() const;
    void check_frames(const exploration::SweepPlan& plan) const;

    ScenarioOptions scenario_;
    std::string minimize_;
    std::vector<std::string> over_;
    std::string goal_;
    std::optional<double> frame_rate_hz_;
    int checks_ = 0;
    std::string results_file_;
    ProcessOptions processes_;
    bool quiet_ = false;
};

}  // namespace metabuffer
