#pragma once

#include <string>

#include "tools/program/command.h"

namespace metabuffer {

/// `metabuffer export`: the results of a sweep or a search as CSV or JSON.
class ExportCommand final : public Command {
  public:
    /// Adds the subcommand and its options.
    explicit ExportCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    std::string format() const;

    std::string results_file_;
    std::string format_;       ///< empty if it is not given
    std::string output_file_;  ///< empty: standard output
    std::string condition_;
    std::string columns_;  ///< expressions with commas in between; empty: all columns
    bool runs_ = false;
};

}  // namespace metabuffer
