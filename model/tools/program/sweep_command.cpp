#include "tools/program/sweep_command.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iostream>

#include "host/errors.h"
#include "host/text.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer {
namespace {

constexpr const char* kSweepFooter =
    "A sweep file names a scenario and axes over its keys: see docs/exploration.md. Each point runs in a "
    "process\n"
    "of its own, and is in the results for good when it has ended: after Ctrl-C, or a kill, the same command "
    "goes\n"
    "on where it stopped. A point that fails is kept with its reason.\n"
    "Examples:\n"
    "  metabuffer sweep scenarios/studies/small-buffers.yaml\n"
    "  metabuffer report out/small-buffers.db -o out/small-buffers.html\n"
    "  metabuffer sweep large.yaml --shard 3/16 -o part-3.db; metabuffer merge part-*.db -o all.db\n"
    "  metabuffer sweep large.yaml --slurm 16 -o all.db --sbatch=--partition=long\n"
    "docs/cluster.md has more on shards and Slurm.\n"
    "Exit status: 0 every point has ended, failed ones too; 2 bad input, or no point makes a scenario; 3\n"
    "--strict and a point has no result; 130 stopped by Ctrl-C.";

void print_points(const exploration::SweepPlan& plan) {
    for (const exploration::Point& point : plan.points) {
        const char* separator = "";
        for (const exploration::Setting& setting : point.settings) {
            std::cout << separator << setting.key << '=' << setting.value;
            separator = " ";
        }
        std::cout << '\n';
    }
}

/// "3/8": the third of eight. Throws InputError.
exploration::Shard parse_shard(const std::string& text) {
    const std::size_t slash = text.find('/');
    std::int64_t number = 0;
    std::int64_t count = 0;
    if (slash == std::string::npos || !CLI::detail::lexical_cast(text.substr(0, slash), number) ||
        !CLI::detail::lexical_cast(text.substr(slash + 1), count) || number < 1 || count < number ||
        count > exploration::kMostPoints) {
        throw InputError("--shard: " + text::quoted(text) +
                         " is no shard; use K/N, from 1/N to N/N, N at most " +
                         std::to_string(exploration::kMostPoints));
    }
    return {number - 1, count};
}

}  // namespace

SweepCommand::SweepCommand(CLI::App& program)
    : Command(program, "sweep", "Run a scenario over ranges of its keys; keep the results in a file") {
    command().add_option("SWEEP", file_, "The sweep, a YAML file")->required();
    command().add_option("-o,--out", results_file_, "The results, an SQLite file (default: out/NAME.db)");
    add_options(command(), processes_);
    command().add_flag("--list", list_, "Print the points and run nothing");
    command().add_flag("--quiet", quiet_, "Print no summary and no progress");
    command().add_flag(
        "--strict", strict_,
        "Exit with 3 if a point has no result: invalid, failed, crashed or ended by the watchdog");
    add_cluster_options();
    command().footer(kSweepFooter);
}

void SweepCommand::add_cluster_options() {
    CLI::Option* const shard = command().add_option_function<std::string>(
        "--shard", [this](const std::string& text) { shard_ = parse_shard(text); },
        "K/N: only the points of shard K of N, from 1 to N");
    CLI::Option* const parts =
        command()
            .add_option("--parts", parts_folder_,
                        "Hand results in to this folder, which computers may share, instead of to -o")
            ->needs(shard)
            ->excludes(command().get_option("--out"));
    command()
        .add_option("--hand-in", slurm_.hand_in_seconds,
                    "Seconds after which what is new is handed in to the folder of --parts, or of --slurm")
        ->capture_default_str()
        ->check(CLI::Range(1, 86'400));
    CLI::Option* const slurm =
        command()
            .add_option(
                "--slurm", slurm_shards_,
                "Cut the sweep into so many shards, run them as jobs of Slurm, and merge them into -o")
            ->check(CLI::Range(std::int64_t{1}, exploration::kMostPoints))
            ->excludes(shard)
            ->excludes(parts)
            ->excludes(command().get_option("--strict"));
    command()
        .add_option("--sbatch", slurm_.site_options,
                    "An option for sbatch, as --sbatch=--partition=long; may be repeated")
        ->needs(slurm)
        ->allow_extra_args(false);
    command()
        .add_option("--launcher", slurm_.launcher,
                    "Words of the shell before the program in a job, as 'apptainer exec site.sif'")
        ->needs(slurm);
    command().add_flag("!--no-wait", slurm_.waits, "End once the jobs have been submitted")->needs(slurm);
}

std::filesystem::path SweepCommand::results_of(const exploration::SweepPlan& plan) const {
    return results_file_.empty() ? std::filesystem::path("out") / (plan.name + ".db")
                                 : std::filesystem::path(results_file_);
}

ExitStatus SweepCommand::run(const exploration::SweepPlan& plan) const {
    const bool has_parts = !parts_folder_.empty();
    const std::filesystem::path results = has_parts ? std::filesystem::path(parts_folder_) : results_of(plan);
    const exploration::Exploration exploration =
        has_parts ? run_shard(plan, results, std::chrono::seconds(slurm_.hand_in_seconds), processes_, quiet_)
                  : run_exploration(plan, results, processes_, quiet_, false);
    if (!quiet_) {
        print_pace(exploration);
        if (plan.points.filtered() > 0) std::cout << plan.points.filtered() << " points filtered out\n";
        print_outcomes(exploration);
        std::cout << "results in " << results.string() << std::endl;
    }
    return judge(exploration, strict_);
}

ExitStatus SweepCommand::run_by_slurm() {
    const exploration::SweepDescription description = exploration::load_sweep(file_);
    // Only the plan of the whole sweep shows whether the filter lets any point through.
    if (!description.filter.empty()) make_plan(description);
    // The plan of one shard is enough to check the rest of the sweep.
    const exploration::SweepPlan plan = make_plan(description, {0, slurm_shards_});
    slurm_.sweep = file_;
    slurm_.results = results_of(plan);
    slurm_.shards = slurm_shards_;
    slurm_.quiet = quiet_;
    return run_on_slurm(plan, slurm_, processes_);
}

ExitStatus SweepCommand::execute() {
    if (command().count("--hand-in") > 0 && parts_folder_.empty() && slurm_shards_ == 0) {
        throw InputError(
            "--hand-in: only results of --parts and --slurm are handed in; use one of these, or leave it "
            "out");
    }
    if (slurm_shards_ > 0 && !list_) return run_by_slurm();
    const exploration::SweepPlan plan = make_plan(exploration::load_sweep(file_), shard_);
    if (list_) {
        print_points(plan);
        return kExitDone;
    }
    return run(plan);
}

}  // namespace metabuffer
