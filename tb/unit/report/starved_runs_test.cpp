#include <catch2/catch.hpp>

#include "report/report.h"
#include "support/random_seed.h"

namespace metabuffer::test {
namespace {

void check_same(const ComposerCounters& by_run, const ComposerCounters& by_pixel) {
    REQUIRE(by_run.starved_pixels == by_pixel.starved_pixels);
    REQUIRE(by_run.starved_run_count == by_pixel.starved_run_count);
    REQUIRE(by_run.starved_runs == by_pixel.starved_runs);
    REQUIRE(by_run.first_glitch == by_pixel.first_glitch);
    REQUIRE(by_run.last_glitch == by_pixel.last_glitch);
}

TEST_CASE("a run of starved pixels counts as each of its pixels does, and ends with its row", "[report]") {
    const auto seed = random_seed(521);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (int trial = 0; trial < 30; ++trial) {
        INFO("trial " << trial);
        ComposerCounters by_run;
        ComposerCounters by_pixel;
        for (int frame = 0; frame < 3; ++frame) {
            for (int y = 0; y < 60; ++y) {
                int x = random.between(0, 9);
                while (x < 100) {
                    const StarvedRun run{frame, y, x, x + (random.one_in(2) ? 0 : random.between(0, 12))};
                    by_run.add_starved_run(run);
                    for (; x <= run.x_last; ++x) by_pixel.add_starved_pixel({frame, x, y});
                    x += random.between(1, 20);  // one pixel between two runs at least
                }
                if (y % 20 == 0) check_same(by_run, by_pixel);
            }
        }
        check_same(by_run, by_pixel);
        REQUIRE(by_run.starved_run_count > kStarvedRunsKept);  // the runs beyond are counted and not kept
        REQUIRE(static_cast<std::int64_t>(by_run.starved_runs.size()) == kStarvedRunsKept);
    }
    ComposerCounters by_run;
    ComposerCounters by_pixel;
    for (const StarvedRun& run :
         {StarvedRun{0, 4, 9, 9}, StarvedRun{0, 5, 10, 10}, StarvedRun{1, 5, 11, 11}}) {
        by_run.add_starved_run(run);
        by_pixel.add_starved_pixel({run.frame, run.x_first, run.y});
    }
    CHECK(by_run.starved_run_count == 3);
    check_same(by_run, by_pixel);
}

}  // namespace
}  // namespace metabuffer::test
