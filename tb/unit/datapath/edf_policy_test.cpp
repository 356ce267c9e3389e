#include "datapath/arbitration/edf_policy.h"

#include <catch2/catch.hpp>
#include <vector>

#include "datapath/segment.h"
#include "support/painted_segment.h"
#include "support/random_seed.h"

namespace metabuffer::edf_policy_test {
namespace {

using Kind = BusGrant::Kind;
using test::PaintedSegment;

constexpr test::Size kRaster{40, 30};

TEST_CASE("edf: grants the row whose next pixel painting needs first, the earlier row on a tie") {
    const auto seed = test::random_seed(151);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    EdfPolicy policy;
    int polls = 0;
    int ties = 0;
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<Segment> segments;
        std::vector<PaintedSegment> painted;
        const int rows = random.between(1, 6);
        for (int i = 0; i < rows; ++i) {
            // Now and then the same segment twice, so that there are ties.
            const ViewportRow row = i > 0 && random.one_in(4) ? segments.back().row()
                                                              : test::random_valid_row(random, kRaster, 6);
            segments.emplace_back(row, kRaster.width, kRaster.height);
            painted.emplace_back(row, kRaster);
        }
        policy.start_frame({}, segments.size());
        for (int clock = 0; clock < 50; ++clock) {
            INFO("trial " << trial << ", clock " << clock);
            std::vector<BusRequest> requests(segments.size());
            std::vector<int> next(segments.size());
            for (std::size_t i = 0; i < segments.size(); ++i) {
                requests[i].pending = !random.one_in(4);
                requests[i].ready = !random.one_in(3);
                next[i] = random.between(0, static_cast<int>(painted[i].first.size()) - 1);
                if (i > 0 && segments[i].row() == segments[i - 1].row() && random.one_in(2)) {
                    next[i] = next[i - 1];
                }
                requests[i].deadline = segments[i].first_use(next[i]);
            }
            int wanted = -1;
            std::int64_t deadline = 0;
            for (std::size_t i = segments.size(); i-- > 0;) {
                if (!requests[i].pending || !requests[i].ready) continue;
                const std::int64_t first = painted[i].first[static_cast<std::size_t>(next[i])];
                ties += wanted >= 0 && first == deadline ? 1 : 0;
                if (wanted < 0 || first <= deadline) {
                    wanted = static_cast<int>(i);
                    deadline = first;
                }
            }
            const BusGrant grant = policy.pick(requests);
            REQUIRE(grant.row == wanted);
            REQUIRE(grant.kind == (wanted < 0 ? Kind::kPoll : Kind::kBurst));
            REQUIRE(grant.recovered_slots == 0);
            polls += wanted < 0 ? 1 : 0;
        }
    }
    // The sample is large enough.
    CHECK(polls > 100);
    CHECK(ties > 100);
}

TEST_CASE("edf: has no slot table") {
    EdfPolicy policy;
    policy.start_frame({}, 0);
    CHECK(policy.slot() == 0);
}

}  // namespace
}  // namespace metabuffer::edf_policy_test
