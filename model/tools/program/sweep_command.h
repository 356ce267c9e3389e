#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/program/command.h"
#include "tools/program/exploration_run.h"
#include "tools/program/slurm_array.h"

namespace metabuffer {

/// `metabuffer sweep`: runs every point of a sweep file, at level tlm or rtl, and keeps the results in a file.
class SweepCommand final : public Command {
  public:
    explicit SweepCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    void add_cluster_options();
    ExitStatus run(const exploration::SweepPlan& plan) const;
    ExitStatus run_by_slurm();
    std::filesystem::path results_of(const exploration::SweepPlan& plan) const;

    std::string file_;
    std::string results_file_;
    exploration::Shard shard_;
    std::string parts_folder_;
    SlurmRequest slurm_;
    std::int64_t slurm_shards_ = 0;  ///< 0: not by Slurm
    ProcessOptions processes_;
    bool list_ = false;
    bool quiet_ = false;
    bool strict_ = false;
};

}  // namespace metabuffer
