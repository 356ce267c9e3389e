#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "process_call.h"
#include "scenario/scenario_loader.h"

/// The work of the module's functions. Each is called in a process of its own, and throws what the program's commands
/// throw. The text of a good reply is JSON; bytes that are not UTF-8 are replaced.
namespace metabuffer::python {

/// A file, or a text in YAML whose paths are relative to the working directory.
struct Source {
    std::string file;  ///< with a text: its name in messages
    std::optional<std::string> text;
};

struct RunCall {
    Source scenario;
    std::vector<ScenarioOverride> overrides;
    std::string level;  ///< empty: the usual one
    bool images = true;
    bool check = false;
    int pictures =
        -1;  ///< descriptor of the file for them: by display, frame and row, 3 bytes (R, G, B) a pixel
};
/// The report and the other results of a run, by keys: class Result in python/metabuffer/_run.py explains them.
Reply run(const RunCall& call);

/// The program's own JSON of an analysis.
Reply analyze(const Source& scenario, const std::vector<ScenarioOverride>& overrides,
              std::optional<double> frame_rate_hz);

/// How an exploration runs, and the file for its results.
struct ExplorationCall {
    std::string results;
    std::optional<int> processes;  ///< none: the usual number
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
