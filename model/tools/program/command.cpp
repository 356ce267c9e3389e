#include "tools/program/command.h"

#include <CLI/CLI.hpp>

namespace metabuffer {

Command::Command(CLI::App& program, const std::string& name, const std::string& description)
    : command_(program.add_subcommand(name, description)) {}

std::string Command::name() const { return command_->get_name(); }

bool Command::chosen() const { return command_->parsed(); }

}  // namespace metabuffer
