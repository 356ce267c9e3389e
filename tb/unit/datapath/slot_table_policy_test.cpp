#include "datapath/arbitration/slot_table_policy.h"

#include <catch2/catch.hpp>
#include <deque>
#include <vector>

#include "datapath/slot_table.h"
#include "support/random_seed.h"
#include "support/rows.h"

namespace metabuffer::slot_table_policy_test {
namespace {

using Kind = BusGrant::Kind;

constexpr test::Size kRaster{64, 48};

ViewportTable random_table(test::Random& random) {
    return test::random_valid_rows(random, random.between(1, 8), kRaster, 5);
}

/// At least one is pending; readiness comes and goes.
std::vector<BusRequest> random_requests(test::Random& random, std::size_t rows) {
    std::vector<BusRequest> requests(rows);
    const int odds = random.between(1, 4);
    for (BusRequest& request : requests) {
        request.pending = !random.one_in(4);
        request.ready = random.one_in(odds);
    }
    requests[static_cast<std::size_t>(random.between(0, static_cast<int>(rows) - 1))].pending = true;
    return requests;
}

bool usable(const std::vector<BusRequest>& requests, int row) {
    return requests[static_cast<std::size_t>(row)].pending && requests[static_cast<std::size_t>(row)].ready;
}

/// The same by a ring that turns slot by slot: its front is the present slot.
class SlotRing {
  public:
    explicit SlotRing(const std::vector<int>& table) : slots_(table.begin(), table.end()) {}

    BusGrant with_recovery(const std::vector<BusRequest>& requests) {
        const std::deque<int> before = slots_;
        for (int passed = 0; passed < static_cast<int>(before.size()); ++passed) {
            const int row = turn();
            if (usable(requests, row)) return {Kind::kBurst, row, passed};
        }
        slots_ = before;
        return {};
    }
    BusGrant without_recovery(const std::vector<BusRequest>& requests) {
        const int row = turn();
        return {usable(requests, row) ? Kind::kBurst : Kind::kLost, row, 0};
    }

  private:
    int turn() {
        const int row = slots_.front();
        slots_.pop_front();
        slots_.push_back(row);
        return row;
    }
    std::deque<int> slots_;
};

void check_against_ring(std::vector<int> (*make_table)(const ViewportTable& rows, int limit_slots),
                        IdleSlots idle_slots, std::uint64_t default_seed) {
    const auto seed = test::random_seed(default_seed);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    SlotTablePolicy policy(idle_slots);
    int polls = 0;
    for (int trial = 0; trial < 100; ++trial) {
        const ViewportTable rows = random_table(random);
        SlotRing ring(make_table(rows, kSlotTableLimit));
        policy.start_frame(make_table(rows, kSlotTableLimit), rows.size());
        REQUIRE(policy.slot() == 0);
        for (int clock = 0; clock < 200; ++clock) {
            INFO("trial " << trial << ", clock " << clock);
            const std::vector<BusRequest> requests = random_requests(random, rows.size());
            const BusGrant got = policy.grant(requests);
            const int slot = policy.slot();
            REQUIRE(policy.grant(requests).row == got.row);  // an answer that is not taken changes nothing
            REQUIRE(policy.slot() == slot);
            policy.take(got);
            const BusGrant wanted = idle_slots == IdleSlots::kRecovered ? ring.with_recovery(requests)
                                                                        : ring.without_recovery(requests);
            REQUIRE(got.kind == wanted.kind);
            REQUIRE(got.row == wanted.row);
            REQUIRE(got.recovered_slots == wanted.recovered_slots);
            polls += got.kind == Kind::kPoll ? 1 : 0;
        }
    }
    // The sample is large enough: with recovery it has polled, without recovery it never does.
    CHECK((polls > 100) == (idle_slots == IdleSlots::kRecovered));
}

TEST_CASE(
    "irsa: a slot that its owner cannot use goes to the next in the table at once, and a poll does not "
    "advance the table") {
    check_against_ring(slot_table, IdleSlots::kRecovered, 141);
}
TEST_CASE("slot-allocation: the slot's owner or nobody, and the table moves on either way") {
    check_against_ring(slot_table, IdleSlots::kLost, 142);
}
TEST_CASE("round-robin: one slot each, idle ones recovered") {
    check_against_ring(equal_slot_table, IdleSlots::kRecovered, 143);
}

TEST_CASE("irsa: with everyone ready each composer gets its C / T share of every round") {
    // The paper's case 4: halves and quarters of a screen doubled, l = w / 4 of w = 64.
    ViewportTable rows;
    for (const int sdx : {8, 24, 32, 8, 24, 32}) {
        rows.push_back(test::segment_row({sdx, 1}, {}, 2, static_cast<int>(rows.size() + 1)));
    }
    SlotTablePolicy policy(IdleSlots::kRecovered);
    policy.start_frame(slot_table(rows), rows.size());
    std::vector<BusRequest> requests(rows.size());
    for (BusRequest& request : requests) request.pending = request.ready = true;
    std::vector<int> granted(rows.size(), 0);
    for (int slot = 0; slot < 16 * 10; ++slot) {
        const BusGrant grant = policy.pick(requests);
        REQUIRE(grant.kind == Kind::kBurst);
        REQUIRE(grant.recovered_slots == 0);
        ++granted[static_cast<std::size_t>(grant.row)];
    }
    CHECK(granted == std::vector<int>{10, 30, 40, 10, 30, 40});
}

TEST_CASE("irsa: a composer that is not ready loses its slot and no more, the others share its time") {
    SlotTablePolicy policy(IdleSlots::kRecovered);
    policy.start_frame({0, 1, 2}, 3);
    std::vector<BusRequest> requests(3);
    for (BusRequest& request : requests) request.pending = request.ready = true;
    CHECK(policy.pick(requests).row == 0);
    requests[1].ready = false;
    const BusGrant recovered = policy.pick(requests);
    CHECK(recovered.row == 2);
    CHECK(recovered.recovered_slots == 1);
    requests[1].ready = true;
    CHECK(policy.pick(requests).row == 0);
    CHECK(policy.pick(requests).row == 1);
}

}  // namespace
}  // namespace metabuffer::slot_table_policy_test
