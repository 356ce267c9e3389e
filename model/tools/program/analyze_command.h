#pragma once

#include <optional>

#include "tools/program/command.h"
#include "tools/program/scenario_options.h"

namespace metabuffer {

/// `metabuffer analyze`: what each renderer's table asks of its bus, what the bus can carry, and how much buffer is
/// enough so that no pixel starves. It calculates these and simulates nothing.
class AnalyzeCommand final : public Command {
  public:
    explicit AnalyzeCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    ScenarioOptions scenario_;
    std::optional<int> frame_;
    std::optional<double> frame_rate_hz_;
    bool details_ = false;
    bool json_ = false;
};

}  // namespace metabuffer
