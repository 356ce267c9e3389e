#include "datapath/arbitration/arbitration_table.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "datapath/segment.h"
#include "formats/slot_payload.h"
#include "support/random_seed.h"
#include "support/rows.h"

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

TEST_CASE(
    "arbitration: every policy loses slots if its row says so, and otherwise grants none only if nobody is "
    "ready") {
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

/// Checks the first row: whatever the others request, each rotation of the table gives it all its slots.
TEST_CASE(
    "arbitration: under a policy that is proved to do so, a composer that stays ready gets each of its "
    "slots") {
    test::Random random(test::random_seed(162));
    for (const ArbitrationRow& policy : kArbitrationTable) {
        if (policy.proof != BufferProof::kSlots) continue;
        INFO(policy.name);
        REQUIRE(policy.slot_table != nullptr);
        const auto arbiter = make_policy(policy.value);
        for (int trial = 0; trial < 50; ++trial) {
            const ViewportTable rows = random_table(random);
            const std::vector<Segment> segments = segments_of(rows);
            const std::vector<int> table = policy.slot_table(rows, kSlotTableLimit);
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

TEST_CASE(
    "arbitration: under a policy that is proved to do so, the ready composer whose pixel is needed first "
    "goes first") {
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

TEST_CASE("arbitration: the host sends the policy's slot table, and the machine accepts it") {
    const auto seed = test::random_seed(164);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    constexpr std::size_t kPlenty = 4096;
    for (const ArbitrationRow& policy : kArbitrationTable) {
        INFO(policy.name);
        for (int trial = 0; trial < 100; ++trial) {
            ValidatedTable table{random_table(random), {}};
            for (int index = 0; random.one_in(2); ++index)
                table.rejected.push_back({index, RowDefect::kSource, ""});
            const SentSlots taken =
                sent_slots(policy.value, table, slot_payload(policy.value, table, kPlenty));
            CHECK_FALSE(taken.rejected);
            CHECK(taken.slots == slots_of(policy.value, table.rows));
        }
    }
}

/// A host has room for a scanline at most.
TEST_CASE("arbitration: with little room the host sends fewer slots, with none it sends no table") {
    const auto seed = test::random_seed(165);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    int shorter = 0;
    for (int trial = 0; trial < 500; ++trial) {
        const ValidatedTable table{random_table(random), {}};
        const std::size_t room = static_cast<std::size_t>(random.between(0, 40));
        const std::vector<std::uint8_t> payload = slot_payload(Arbitration::kIrsa, table, room);
        CHECK(payload.size() <= room);
        const SentSlots taken = sent_slots(Arbitration::kIrsa, table, payload);
        CHECK(taken.rejected == (slots_in_payload(room, table.rows.size()) < table.rows.size()));
        if (!taken.rejected) shorter += taken.slots != slots_of(Arbitration::kIrsa, table.rows) ? 1 : 0;
    }
    CHECK(shorter > 0);
}

TEST_CASE("arbitration: where there is room for a slot each, each row has one") {
    // In proportion the first row would have two of the four slots that there is room for, one too many.
    const ValidatedTable table{{{1, 0, 0, 60, 1, 0, 0, 1},
                                {2, 0, 0, 1, 1, 0, 0, 5},
                                {3, 0, 0, 1, 1, 0, 0, 5},
                                {4, 0, 0, 1, 1, 0, 0, 5}},
                               {}};
    constexpr std::size_t kRoom = 5;
    REQUIRE(slots_in_payload(kRoom, 4) == 4);
    const SentSlots taken =
        sent_slots(Arbitration::kIrsa, table, slot_payload(Arbitration::kIrsa, table, kRoom));
    CHECK_FALSE(taken.rejected);
    CHECK(taken.slots == std::vector<int>{0, 1, 2, 3});
}

TEST_CASE("arbitration: without a good slot table from the host each row has a slot") {
    const ValidatedTable table{{{1, 0, 0, 9, 1, 0, 0, 1}, {2, 0, 0, 3, 1, 0, 0, 1}}, {}};
    for (const Arbitration policy :
         {Arbitration::kIrsa, Arbitration::kSlotAllocation, Arbitration::kRoundRobin}) {
        const SentSlots none = sent_slots(policy, table, {});
        CHECK(none.rejected);
        CHECK(none.slots == std::vector<int>{0, 1});
        CHECK(sent_slots(policy, table, encode_slots({0, 0}, 2)).rejected);
        // Without rows no slot table is missing.
        CHECK_FALSE(sent_slots(policy, {}, {}).rejected);
    }
    CHECK_FALSE(sent_slots(Arbitration::kEdf, table, {}).rejected);
    CHECK(slot_payload(Arbitration::kEdf, table, 100).empty());
    CHECK(slot_payload(Arbitration::kIrsa, {}, 100).empty());
}

}  // namespace
}  // namespace metabuffer
