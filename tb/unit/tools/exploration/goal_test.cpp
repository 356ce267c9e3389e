#include "tools/exploration/goal.h"

#include <catch2/catch.hpp>
#include <string>

#include "tools/exploration/figures.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer::exploration {
namespace {

/// A run that starved 7 pixels at 50 frames/s.
RunRecord starved_run() {
    RunRecord run;
    run.settings = {{"bus.width_bits", "64"}};
    run.figures.resize(figure_kinds().size());
    run.figures[figure_index("whole").value()] = std::int64_t{0};
    run.figures[figure_index("starved_pixels").value()] = std::int64_t{7};
    run.figures[figure_index("frames_per_second").value()] = 50.0;
    run.figures[figure_index("bottleneck").value()] = std::string("bus");
    return run;
}

TEST_CASE("goal: what a run misses are the figures of those parts that do not hold") {
    struct Row {
        std::string goal;
        std::string missed;
    };
    for (const Row& row :
         {Row{"whole and frames_per_second >= 60", "starved_pixels 7, frames_per_second 50"},
          Row{"(whole and bus.width_bits = 64) and frames_per_second >= 40", "starved_pixels 7"},
          Row{"starved_pixels between 0 and 5", "starved_pixels 7"},
          // Within the goal the text counts as 0; by itself it is neither true nor false.
          Row{"whole and bottleneck", "starved_pixels 7, bottleneck bus"}}) {
        CAPTURE(row.goal);
        const Goal goal(row.goal, goal_names({"bus.width_bits"}, "composer.buffer_pixels"), "test");
        CHECK_FALSE(goal.is_met_by(starved_run()));
        CHECK(goal.missed_by(starved_run()) == row.missed);
    }
    RunRecord stopped = starved_run();
    stopped.status = RunStatus::kWatchdog;
    stopped.reason = "nothing moved";
    const Goal goal("starved_pixels > 0", goal_names({}, "composer.buffer_pixels"), "test");
    CHECK(goal.is_met_by(starved_run()));
    CHECK_FALSE(goal.is_met_by(stopped));
    CHECK(goal.missed_by(stopped) == "nothing moved");
}

}  // namespace
}  // namespace metabuffer::exploration
