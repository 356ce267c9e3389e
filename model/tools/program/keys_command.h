#pragma once

#include <string>

#include "tools/program/command.h"

namespace metabuffer {

/// `metabuffer keys`: what a scenario file may hold.
class KeysCommand final : public Command {
  public:
    /// Adds the subcommand and its options.
    explicit KeysCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    std::string prefix_;
    bool json_ = false;
};

}  // namespace metabuffer
