#include "datapath/arbitration/arbitration_table.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "datapath/segment.h"
#include "support/random_seed.h"
#include "unit/datapath/painted_segment.h"

namespace metabuffer {
namespace {

using Kind = BusGrant::Kind;

constexpr test::Size kRaster{64, 48};

ViewportTable random_table(test::Random& random) {
    return test::random_valid_rows(random, random.between(2, 8), kRaster, 5);
}

std::vector<Segment> segments_of(const ViewportTable& rows) {
    std::vector<Segment> segments;
    for (const ViewportRow& row : rows) segments.emplace_back(row, kRaster.width, kRaster.height);
    return segments;
}

std::vector<BusRequest> random_requests(test::Random& random, const std::vector<Segment>& segments) {
    std::vector<BusRequest> requests;
    for (const Segment& segment : segments) {
        const int next = random.between(0, static_cast<int>(segment.pixels()) - 1);
        requests.push_back({!random.one_in(4), random.one_in(3), segment.first_use(next)});
    }
    requests.front().pending = true;
    return requests;
}

bool usable(const BusRequest& request) { return request.pending && request.ready; }

TEST_CASE("arbitration: every policy loses slots if its row says so, and else rests only with nobody ready") {
    test::Random random(test::random_seed(161));
    for (const ArbitrationRow& policy : kArbitrationTable) {
        INFO(policy.name);
        const auto arbiter = make_policy(policy.value);
        int lost = 0;
        for (int trial = 0; trial < 50; ++trial) {
            const ViewportTable rows = random_table(random);
            const std::vector<Segment> segments = segments_of(rows);
            arbiter->start_frame(slots_of(policy.value, rows), rows.size());
            for (int clock = 0; clock < 100; ++clock) {
                const std::vector<BusRequest> requests = random_requests(random, segments);
                const BusGrant grant = arbiter->pick(requests);
                lost += grant.kind == Kind::kLost ? 1 : 0;
                if (grant.kind == Kind::kBurst) {
                    REQUIRE(usable(requests[static_cast<std::size_t>(grant.row)]));
                } else if (policy.idle_slots == IdleSlots::kRecovered) {
                    REQUIRE(std::none_of(requests.begin(), requests.end(), usable));
                }
            }
        }
        CHECK((lost > 0) == loses_slots(policy.value));
    }
}

/// Of the first row: however the others come and go, rotations of the table bring it all slots that it has in them.
TEST_CASE("arbitration: where it is proved to, a composer that stays ready gets each of its slots") {
    test::Random random(test::random_seed(162));
    for (const ArbitrationRow& policy : kArbitrationTable) {
        if (policy.proof != BufferProof::kSlots) continue;
        INFO(policy.name);
        REQUIRE(policy.slot_table != nullptr);
        const auto arbiter = make_policy(policy.value);
        for (int trial = 0; trial < 50; ++trial) {
            const ViewportTable rows = random_table(random);
            const std::vector<Segment> segments = segments_of(rows);
            const std::vector<int> table = policy.slot_table(rows);
            const auto slots = std::count(table.begin(), table.end(), 0);
            REQUIRE(slots > 0);
            arbiter->start_frame(table, rows.size());
            std::int64_t own = 0;
            std::int64_t passed = 0;
            while (passed < 10 * static_cast<std::int64_t>(table.size())) {
                std::vector<BusRequest> requests = random_requests(random, segments);
                requests.front().pending = requests.front().ready = true;
                const BusGrant grant = arbiter->pick(requests);
                passed += grant.recovered_slots + 1;
                own += grant.kind == Kind::kBurst && grant.row == 0 ? 1 : 0;
            }
            CHECK(own >= 10 * slots);
        }
    }
}

TEST_CASE("arbitration: where it is proved to, the ready composer whose pixel is needed first goes first") {
    test::Random random(test::random_seed(163));
    for (const ArbitrationRow& policy : kArbitrationTable) {
        if (policy.proof != BufferProof::kDeadlines) continue;
        INFO(policy.name);
        const auto arbiter = make_policy(policy.value);
        for (int trial = 0; trial < 500; ++trial) {
            const ViewportTable rows = random_table(random);
            const std::vector<Segment> segments = segments_of(rows);
            arbiter->start_frame(slots_of(policy.value, rows), rows.size());
            const std::vector<BusRequest> requests = random_requests(random, segments);
            const BusGrant grant = arbiter->pick(requests);
            if (grant.kind != Kind::kBurst) continue;
            const std::int64_t first = requests[static_cast<std::size_t>(grant.row)].deadline;
            for (const BusRequest& request : requests) {
                if (usable(request)) CHECK(first <= request.deadline);
            }
        }
    }
}

}  // namespace
}  // namespace metabuffer
