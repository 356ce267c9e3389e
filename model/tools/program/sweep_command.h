#pragma once

#include <string>

#include "tools/program/command.h"
#include "tools/program/exploration_run.h"

namespace metabuffer {

/// `metabuffer sweep`: runs every point of a sweep file at level tlm and keeps the results in a file.
class SweepCommand final : public Command {
  public:
    explicit SweepCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    std::string file_;
    std::string results_file_;
    ProcessOptions processes_;
    bool list_ = false;
    bool quiet_ = false;
};

}  // namespace metabuffer
