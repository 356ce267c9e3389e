#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "process_call.h"
#include "scenario/scenario_loader.h"

/// What the module's functions have the program do, each to be called in a process of its own. They throw what its
/// commands throw. A text that a reply holds is JSON unless it is said otherwise; bytes that are not UTF-8 are replaced.
namespace metabuffer::python {

/// A file, or a text in YAML whose paths are relative to the working directory.
struct Source {
    std::string file;  ///< of a text: its name in messages
    std::optional<std::string> text;
};

struct RunCall {
    Source scenario;
    std::vector<ScenarioOverride> overrides;
    std::string level;  ///< empty: the usual one
    bool images = true;
    bool check = false;
    int pictures = -1;  ///< where they go: a file, 3 bytes a pixel (red, green, blue), rows, frames, displays
};
/// The report and what else a run leaves, by keys: see core.cpp's docstring of run.
Reply run(const RunCall& call);

/// The program's own JSON of an analysis.
Reply analyze(const Source& scenario, const std::vector<ScenarioOverride>& overrides,
              std::optional<double> frame_rate_hz);

/// How an exploration runs, and where it leaves its results.
struct ExplorationCall {
    std::string results;
    std::optional<int> processes;  ///< none: one for each processor
    std::optional<double> time_limit_seconds;
    std::string level;  ///< empty: the usual one
    bool quiet = false;
};
/// The table of the results, as results() has it.
Reply sweep(const Source& sweep, const ExplorationCall& call);

struct SizeCall {
    std::string scenario;  ///< the file
    std::vector<ScenarioOverride> overrides;
    std::string minimize;
    std::vector<std::string> over;
    std::string goal;  ///< empty: the usual one
    std::optional<double> frame_rate_hz;
    std::optional<int> checks;
};
Reply size(const SizeCall& call, const ExplorationCall& exploration);

/// The columns, rows and units of a results file, and what it was made from.
Reply results(const std::string& file, const std::string& where, const std::string& columns);

}  // namespace metabuffer::python
