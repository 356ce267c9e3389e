#pragma once

#include <string>

#include "tools/program/exit_status.h"

namespace CLI {
class App;
}

namespace metabuffer {

/// A subcommand of the program.
class Command {
  public:
    Command(const Command&) = delete;
    Command& operator=(const Command&) = delete;
    virtual ~Command() = default;

    std::string name() const;
    /// Whether the command line names this command.
    bool chosen() const;
    /// Throws InputError and OutputError. Call it before SystemC elaborates anything in this process.
    virtual ExitStatus execute() = 0;

  protected:
    /// Adds the subcommand, which keeps references to this object.
    Command(CLI::App& program, const std::string& name, const std::string& description);

    CLI::App& command() const { return *command_; }

  private:
    CLI::App* command_;
};

}  // namespace metabuffer
