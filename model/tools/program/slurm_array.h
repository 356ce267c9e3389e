#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/exploration/sweep_plan.h"
#include "tools/program/exit_status.h"
#include "tools/program/exploration_run.h"

namespace metabuffer {

/// A sweep as jobs of the scheduler Slurm.
struct SlurmRequest {
    std::filesystem::path sweep;            ///< the sweep's file
    std::filesystem::path results;          ///< where the merged results go, in a folder that all nodes share
    std::int64_t shards = 1;                ///< tasks of the job array
    std::vector<std::string> site_options;  ///< for sbatch: "--partition=long"
    std::string launcher;  ///< words of the shell before the program: "apptainer exec site.sif"
    int hand_in_seconds = 60;
    bool waits = true;  ///< false: ends once the jobs have been submitted
    bool quiet = false;
};

/// Submits an array of jobs, each of which runs a shard, and a job that merges when all have ended. Waits for them and
/// shows their progress. Until they are merged, results are in the folder RESULTS.parts. Points that are there, or in
/// the results, are not run again. If jobs of the sweep are at work already, it waits for these. Ctrl-C cancels the
/// jobs. `plan`: that of one of the shards. Throws InputError for results of another sweep, OutputError if Slurm does
/// not accept the jobs.
ExitStatus run_on_slurm(const exploration::SweepPlan& plan, const SlurmRequest& request,
                        const ProcessOptions& processes);

}  // namespace metabuffer
