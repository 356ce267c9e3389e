#pragma once

#include <string>

#include "tools/program/command.h"
#include "tools/program/scenario_options.h"

namespace metabuffer {

/// `metabuffer view`: one run as a page for a browser.
class ViewCommand final : public Command {
  public:
    explicit ViewCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    ScenarioOptions scenario_;
    std::string output_file_;
    std::string title_;
    int embedded_mebibytes_ = 48;
    bool quiet_ = false;
};

}  // namespace metabuffer
