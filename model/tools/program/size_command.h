#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/program/command.h"
#include "tools/program/exploration_run.h"
#include "tools/program/scenario_options.h"
#include "tools/program/size_margin.h"
#include "tools/program/sizing.h"

namespace metabuffer {

/// `metabuffer size`: the smallest value of a key at which a machine meets a goal, or for two keys the front of both,
/// at each setting of other keys.
class SizeCommand final : public Command {
  public:
    explicit SizeCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    exploration::Exploration run(const exploration::SweepPlan& plan, const SizeRequest& request,
                                 const std::optional<std::filesystem::path>& results) const;
    ExitStatus size_one();
    ExitStatus size_front();
    bool try_margins(const std::vector<SizedMachine>& machines) const;
    bool print_stalling(const exploration::SweepDescription& asked,
                        const exploration::Exploration& exploration, std::size_t& simulations) const;

    ScenarioOptions scenario_;
    SizeRequest request_;
    std::string results_file_;
    int margin_steps_ = 0;
    ProcessOptions processes_;
    bool quiet_ = false;
};

}  // namespace metabuffer
