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
    std::filesystem::path sweep;    ///< the sweep's file
    std::filesystem::path results;  ///< where the merged results go; its folder is one that all nodes share
    std::int64_t shards = 1;        ///< tasks of the job array
    std::vector<std::string> site_options;  ///< for sbatch: "--partition=long"
    std::string launcher;  ///< words of the shell before the program: "apptainer exec site.sif"
    int hand_in_seconds = 60;
    bool waits = true;  ///< false: ends once the jobs have been submitted
    bool quiet = false;
};

/// Submits an array of jobs, each of which runs a shard, and a job that merges when all have ended; waits for them and
/// shows how far they are. Results on the way lie in the folder RESULTS.parts. What lies there, or in the results, is not
/// run again, and jobs that are at work already are waited for. Ctrl-C cancels them. plan: of one of the shards.
/// Throws InputError for results of another sweep, OutputError if Slurm does not take the jobs.
ExitStatus run_on_slurm(const exploration::SweepPlan& plan, const SlurmRequest& request,
                        const ProcessOptions& processes);

}  // namespace metabuffer
