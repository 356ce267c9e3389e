#pragma once

#include "tools/program/command.h"
#include "tools/program/scenario_options.h"

namespace metabuffer {

/// `metabuffer compare`: one scenario at levels rtl and tlm; prints every counter and every picture in which
/// they differ.
class CompareCommand final : public Command {
  public:
    /// Adds the subcommand and its options.
    explicit CompareCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    ScenarioOptions scenario_;
    bool no_images_ = false;
    bool quiet_ = false;
};

}  // namespace metabuffer
