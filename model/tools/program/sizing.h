#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/report.h"
#include "scenario/scenario.h"
#include "scenario/scenario_loader.h"
#include "tools/exploration/explorer.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer {

/// The key of the buffers' size. Without a run, more is known about it than about other keys.
constexpr const char* kBufferKey = "composer.buffer_pixels";

/// A request to `metabuffer size`, with texts as on its command line.
struct SizeRequest {
    std::string file;  ///< the scenario's
    std::vector<ScenarioOverride> overrides;
    std::vector<std::string> minimize;    ///< KEY, KEY=FROM..TO, KEY=FROM..TO+STEP or KEY=A,B,C; one or two
    std::vector<std::string> over;        ///< KEY=VALUES
    std::string goal;                     ///< empty: the default goal
    std::optional<double> frame_rate_hz;  ///< the machine must reach it as well
    int checks = 16;                      ///< further values that are tried on both sides of the answer
};

/// One entry of `minimize`. Throws InputError.
exploration::SearchDescription minimized(const std::string& minimize);

/// The search for the last key of `minimize`, at each setting of `over`. Throws InputError.
exploration::SweepDescription describe_size(const SizeRequest& request);

/// Throws InputError if a run has too few frames for the requested rate. A rate is measured between frames, and the
/// first swap does not count, so no machine could meet the goal.
void check_frames(const SizeRequest& request, const exploration::SweepPlan& plan);

/// What arithmetic knows of a search without a run. It does not narrow a range that the user gives, but it may say that
/// no value can meet the goal.
exploration::KnownAnswer known_answer(const SizeRequest& request, const Scenario& scenario,
                                      const exploration::SearchDescription& search);

}  // namespace metabuffer
