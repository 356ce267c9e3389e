#include "tools/program/sweep_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

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
    "Exit status: 0 every point has ended, failed ones too; 2 bad input, or no point makes a scenario; 130\n"
    "stopped by Ctrl-C.";

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

}  // namespace

SweepCommand::SweepCommand(CLI::App& program)
    : Command(program, "sweep", "Run a scenario over ranges of its keys; keep the results in a file") {
    command().add_option("SWEEP", file_, "The sweep, a YAML file")->required();
    command().add_option("-o,--out", results_file_, "The results, an SQLite file (default: out/NAME.db)");
    add_options(command(), processes_);
    command().add_flag("--list", list_, "Print the points and run nothing");
    command().add_flag("--quiet", quiet_, "Print no summary and no progress");
    command().footer(kSweepFooter);
}

ExitStatus SweepCommand::execute() {
    const exploration::SweepPlan plan = make_plan(exploration::load_sweep(file_));
    if (list_) {
        print_points(plan);
        return kExitDone;
    }
    const std::filesystem::path results = results_file_.empty()
                                              ? std::filesystem::path("out") / (plan.name + ".db")
                                              : std::filesystem::path(results_file_);
    const exploration::Exploration exploration = run_exploration(plan, results, processes_, quiet_);
    if (!quiet_) {
        print_pace(exploration);
        if (plan.filtered_points > 0) std::cout << plan.filtered_points << " points filtered out\n";
        print_outcomes(exploration);
        std::cout << "results in " << results.string() << std::endl;
    }
    return judge(exploration);
}

}  // namespace metabuffer
