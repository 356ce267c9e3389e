#include "tools/program/analyze_command.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "host/errors.h"
#include "tools/analysis/analysis_report.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/program/number_option.h"
#include "tools/program/option_ranges.h"

namespace metabuffer {
namespace {

constexpr const char* kAnalyzeFooter =
    "First the answers: the frame rate that displays, links, raster and buses allow, the bottleneck, and the "
    "buffer with\n"
    "which no pixel starves in any frame: a bound that is always enough, though less may be "
    "(docs/analysis.md derives it).\n"
    "Then a line for each renderer, of its table of most work; with --details each table, and the tasks of "
    "the "
    "paper's section\n"
    "5.1 (C pixels in each T clocks, by D), what they need and what the bus carries, the slot table, and "
    "each "
    "composer.\n"
    "Examples:\n"
    "  metabuffer analyze scenarios/case-4.yaml\n"
    "  metabuffer analyze scenarios/paper-figure.yaml --set bus.width_bits=64 --frame-rate-hz 60 --json\n"
    "Exit status: 0 done, whatever the answer; 2 bad input.";

}  // namespace

AnalyzeCommand::AnalyzeCommand(CLI::App& program)
    : Command(program, "analyze", "Bandwidth and buffer of a scenario by arithmetic, without running it"),
      scenario_(command()) {
    command()
        .add_option("--frame", frame_,
                    "Only the tables of this frame, from 0 (default: every different table)")
        ->check(CLI::Range(0, 999'999));
    command()
        .add_option("--frame-rate-hz", frame_rate_hz_,
                    "Frames a second to be carried (default: as fast as the raster goes)")
        ->check(number_within(kFrameRatesHz));
    command().add_flag("--details", details_,
                       "Each table in full, too: tasks, supply, slot table, composers");
    command().add_flag("--json", json_, "Print JSON, with all details");
    command().footer(kAnalyzeFooter);
}

ExitStatus AnalyzeCommand::execute() {
    const Scenario scenario = scenario_.load();
    if (frame_ && *frame_ >= scenario.frames) {
        throw InputError("--frame " + std::to_string(*frame_) + ": the run has " +
                         std::to_string(scenario.frames) + (scenario.frames == 1 ? " frame" : " frames") +
                         ", counted from 0; use less, or --frames");
    }
    const analysis::Analysis result = analysis::analyze(scenario, {frame_, frame_rate_hz_});
    std::cout << (json_ ? analysis_json(result) : analysis_text(result, details_)) << std::flush;
    if (!std::cout) throw OutputError("metabuffer: standard output cannot be written");
    return kExitDone;
}

}  // namespace metabuffer
