#pragma once

#include <string>
#include <vector>

#include "tools/program/command.h"

namespace metabuffer {

/// `metabuffer report`: files of results as one page for a browser.
class ReportCommand final : public Command {
  public:
    explicit ReportCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    std::vector<std::string> results_files_;
    std::string output_file_;
    std::string condition_;
    std::string title_;
    int embedded_mebibytes_ = 24;
};

}  // namespace metabuffer
