#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/program/command.h"
#include "tools/program/exploration_run.h"
#include "tools/program/scenario_options.h"

namespace metabuffer {

/// `metabuffer size`: the smallest value of a key at which a machine meets a goal, of two keys the front of both, at each
/// setting of others.
class SizeCommand final : public Command {
  public:
    explicit SizeCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    exploration::SweepDescription description() const;
    void check_frames(const exploration::SweepPlan& plan) const;
    exploration::Exploration run(const exploration::SweepPlan& plan,
                                 const std::optional<std::filesystem::path>& results) const;
    exploration::KnownAnswer known_of(const Scenario& scenario,
                                      const exploration::SearchDescription& search) const;
    ExitStatus size_one();
    ExitStatus size_front();
    bool print_stalling(const exploration::SweepDescription& asked,
                        const exploration::Exploration& exploration, std::size_t& simulations) const;

    ScenarioOptions scenario_;
    std::vector<std::string> minimize_;
    std::vector<std::string> over_;
    std::string goal_;
    std::optional<double> frame_rate_hz_;
    int checks_ = 0;
    std::string results_file_;
    ProcessOptions processes_;
    bool quiet_ = false;
};

}  // namespace metabuffer
