#pragma once

#include "tools/program/command.h"

namespace metabuffer {

/// `metabuffer counters`: what a report counts, and the figures that sweeps make of it.
class CountersCommand final : public Command {
  public:
    /// Adds the subcommand and its options.
    explicit CountersCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    bool json_ = false;
};

}  // namespace metabuffer
