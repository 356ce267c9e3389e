#pragma once

#include "program/exit_status.h"
#include "program/scenario_options.h"

namespace CLI {
class App;
}

namespace metabuffer {

/// `metabuffer compare`: one scenario at levels rtl and tlm; prints every counter and every picture in which
/// they differ.
class CompareCommand {
  public:
    /// Adds the subcommand and its options.
    explicit CompareCommand(CLI::App& program);

    /// Whether the command line names this command.
    bool chosen() const;
    /// Throws InputError. Call it before this process elaborates anything.
    ExitStatus execute();

  private:
    CLI::App* command_;
    ScenarioOptions scenario_;
    bool no_images_ = false;
    bool quiet_ = false;
};

}  // namespace metabuffer
