#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "program/exit_status.h"

namespace CLI {
class App;
}

namespace metabuffer {

/// `metabuffer run`: one scenario at one level; writes pictures and report, prints a summary.
class RunCommand {
  public:
    /// Adds the subcommand and its options.
    explicit RunCommand(CLI::App& program);

    /// Throws InputError and OutputError.
    ExitStatus execute();

  private:
    CLI::App* command_;
    std::string scenario_file_;
    std::string level_ = "rtl";
    std::string out_directory_;
    std::vector<std::string> overrides_;
    std::optional<int> frames_;
    std::string trace_file_;
    std::string trace_window_ = "startframe:0";
    std::optional<std::int64_t> trace_before_cycles_;
    std::optional<std::int64_t> trace_after_cycles_;
    std::vector<std::string> trace_blocks_;
    bool strict_ = false;
    bool quiet_ = false;
};

}  // namespace metabuffer
