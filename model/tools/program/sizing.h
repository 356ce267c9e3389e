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

/// The key of the buffers' size, of which more is known without a run than of others.
constexpr const char* kBufferKey = "composer.buffer_pixels";

/// What `metabuffer size` is asked for, the texts as on its command line.
struct SizeRequest {
    std::string file;  ///< the scenario's
    std::vector<ScenarioOverride> overrides;
    std::vector<std::string> minimize;    ///< KEY, KEY=FROM..TO, KEY=FROM..TO+STEP or KEY=A,B,C; one or two
    std::vector<std::string> over;        ///< KEY=VALUES
    std::string goal;                     ///< empty: the usual one
    std::optional<double> frame_rate_hz;  ///< to be met, too
    int checks = 16;  ///< further values looked at on both sides of the one that was found
};

/// One entry of `minimize`. Throws InputError.
exploration::SearchDescription minimized(const std::string& minimize);

/// The search for the last key of `minimize`, at each setting of `over`. Throws InputError.
exploration::SweepDescription describe_size(const SizeRequest& request);

/// A rate is between frames, and the first swap tells nothing: with fewer no machine meets the goal. Throws InputError.
void check_frames(const SizeRequest& request, const exploration::SweepPlan& plan);

/// What arithmetic knows of a search. A range that the user gives is looked at as it is, as long as there is hope.
exploration::KnownAnswer known_answer(const SizeRequest& request, const Scenario& scenario,
                                      const exploration::SearchDescription& search);

}  // namespace metabuffer
