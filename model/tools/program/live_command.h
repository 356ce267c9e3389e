#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/program/command.h"
#include "tools/program/level_run.h"
#include "tools/program/scenario_options.h"

namespace metabuffer {

/// `metabuffer live`: runs a scenario whose live renderers get their images from applications, and shows the wall.
class LiveCommand final : public Command {
  public:
    explicit LiveCommand(CLI::App& program);
    ExitStatus execute() override;

  private:
    std::filesystem::path socket_of(const Scenario& scenario) const;

    ScenarioOptions scenario_;
    std::string level_ = to_string(RunLevel::kTlm);
    std::string socket_;
    std::string out_directory_;
    std::string record_directory_;
    std::string stream_file_;
    std::string pictures_ = "last";
    double wait_seconds_ = 10.0;
    bool no_window_ = false;
    bool real_time_ = false;
    bool strict_ = false;
    bool quiet_ = false;
};

}  // namespace metabuffer
