#pragma once

#include <string>
#include <vector>

#include "tools/program/command.h"

namespace metabuffer {

/// `metabuffer merge`: joins the parts of a sweep that was cut into shards, in one file of results, and says what is
/// missing.
class MergeCommand final : public Command {
  public:
    explicit MergeCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    std::vector<std::string> parts_;
    std::string results_file_;
    bool quiet_ = false;
};

}  // namespace metabuffer
