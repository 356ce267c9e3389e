#include "tools/analysis/slot_share.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "datapath/arbitration/slot_table_policy.h"
#include "datapath/slot_table.h"
#include "support/random_seed.h"

using namespace metabuffer;
using namespace metabuffer::analysis;

namespace {

ViewportTable random_rows(test::Random& random) {
    ViewportTable rows(static_cast<std::size_t>(random.between(1, 6)));
    std::uint16_t display = 0;
    for (ViewportRow& row : rows) {
        row = {++display, 0, 0, static_cast<std::uint16_t>(random.between(1, 40)),
               1000,      0, 0, static_cast<std::uint16_t>(random.between(1, 4))};
    }
    return rows;
}

/// Plays a bus with delays: bursts of `cycles` clocks, after each of which its composer is passed over. Returns, for each
/// grant of `row`, the clocks that others have had since its burst before beyond the first `passed_over_cycles`, or -1
/// for the first; and the grants that the rival has had by then.
struct DelayedGrant {
    std::int64_t clocks = -1;
    std::int64_t rivals = 0;
};

std::vector<DelayedGrant> play_delayed(test::Random& random, const ViewportTable& rows, std::size_t row,
                                       std::size_t rival, const std::vector<double>& cycles,
                                       std::int64_t passed_over_cycles) {
    constexpr std::size_t kGrants = 200;
    SlotTablePolicy policy(IdleSlots::kRecovered);
    policy.start_frame(slot_table(rows), rows.size());
    std::vector<std::int64_t> ready_from(rows.size(), 0);
    std::vector<DelayedGrant> grants;
    std::int64_t rivals = 0;
    for (std::int64_t now = 0; grants.size() < kGrants;) {
        std::vector<BusRequest> requests(rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const bool always = i == row || i == rival;
            requests[i] = {true, (always || random.one_in(2)) && ready_from[i] <= now, 0};
        }
        const BusGrant grant = policy.pick(requests);
        if (grant.kind == BusGrant::Kind::kPoll) {
            ++now;
            continue;
        }
        const auto granted = static_cast<std::size_t>(grant.row);
        if (granted == row) grants.push_back({grants.empty() ? -1 : now - ready_from[row], rivals});
        rivals += granted == rival ? 1 : 0;
        now += static_cast<std::int64_t>(cycles[granted]);
        ready_from[granted] = now + passed_over_cycles;
    }
    return grants;
}

/// Plays the arbiter itself: `row` and `rival` are always ready, the others now and then. After each burst its composer
/// is passed over for one clock if `passed_over`, and the bus polls if nobody else is ready.
struct PlayedBus {
    std::vector<std::size_t> grants;  ///< rows
    std::int64_t polls = 0;
};

PlayedBus play(test::Random& random, const ViewportTable& rows, std::size_t row, std::size_t rival,
               bool passed_over, int grants) {
    SlotTablePolicy policy(IdleSlots::kRecovered);
    policy.start_frame(slot_table(rows), rows.size());
    PlayedBus bus;
    int last = -1;
    while (static_cast<int>(bus.grants.size()) < grants) {
        std::vector<BusRequest> requests(rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const bool always = i == row || i == rival;
            requests[i] = {true, (always || random.one_in(2)) && static_cast<int>(i) != last, 0};
        }
        const BusGrant grant = policy.pick(requests);
        last = -1;
        if (grant.kind == BusGrant::Kind::kPoll) {
            ++bus.polls;
            continue;
        }
        bus.grants.push_back(static_cast<std::size_t>(grant.row));
        if (passed_over) last = grant.row;
    }
    return bus;
}

}  // namespace

TEST_CASE("a composer that stays ready waits no longer than its slots say", "[analysis][random]") {
    test::Random random(test::random_seed(21));
    for (int round = 0; round < 300; ++round) {
        const ViewportTable rows = random_rows(random);
        const bool passed_over = random.one_in(3);
        const SlotShares shares(slot_table(rows), rows.size(),
                                passed_over ? RepeatedSlot::kSkipped : RepeatedSlot::kGranted);
        const auto row = static_cast<std::size_t>(random.between(0, static_cast<int>(rows.size()) - 1));
        std::vector<double> cycles(rows.size());
        for (double& each : cycles) each = random.between(1, 50);
        const SlotShares::Wait wait = shares.wait(row, cycles, 0.0);
        const PlayedBus bus = play(random, rows, row, row, passed_over, 400);
        // From any grant on, what the others take before the row's first, second, ... grant. The row itself may have
        // had the grant before and be passed over.
        for (std::size_t start = 0; start < bus.grants.size(); start += 3) {
            double others = 0.0;
            std::size_t own = 0;
            for (std::size_t at = start; at < bus.grants.size(); ++at) {
                if (bus.grants[at] != row) {
                    others += cycles[bus.grants[at]];
                    continue;
                }
                ++own;
                CHECK(others <= wait.rate * static_cast<double>(own) + wait.spread + 1e-6);
                if (own < wait.most.size()) CHECK(others <= wait.most[own] + 1e-6);
            }
        }
    }
}

TEST_CASE("a rival that stays ready gets its share beside a composer", "[analysis][random]") {
    test::Random random(test::random_seed(22));
    for (int round = 0; round < 300; ++round) {
        const ViewportTable rows = random_rows(random);
        if (rows.size() < 2) continue;
        const bool passed_over = random.one_in(3);
        const SlotShares shares(slot_table(rows), rows.size(),
                                passed_over ? RepeatedSlot::kSkipped : RepeatedSlot::kGranted);
        const SlotShares::Fairness fairness = shares.fairness(0, 1);
        const PlayedBus bus = play(random, rows, 0, 1, passed_over, 400);
        for (std::size_t start = 0; start < bus.grants.size(); start += 3) {
            std::int64_t own = 0;
            std::int64_t rivals = 0;
            for (std::size_t at = start; at < bus.grants.size(); ++at) {
                rivals += bus.grants[at] == 1 ? 1 : 0;
                if (bus.grants[at] != 0) continue;
                ++own;
                CHECK(static_cast<double>(rivals) >=
                      fairness.rate * static_cast<double>(own) - fairness.loss - 1e-6);
            }
        }
    }
}

TEST_CASE(
    "on a bus with delays a composer waits for the slots before its next one, and a rival has its share",
    "[analysis][random]") {
    const std::uint64_t seed = test::random_seed(23);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int round = 0; round < 300; ++round) {
        const ViewportTable rows = random_rows(random);
        if (rows.size() < 2) continue;
        const SlotShares shares(slot_table(rows), rows.size(), RepeatedSlot::kDelayed);
        std::vector<double> cycles(rows.size());
        for (double& each : cycles) each = random.between(1, 30);
        const SlotShares::Wait wait = shares.wait(0, cycles, 0.0);
        const SlotShares::Fairness fairness = shares.fairness(0, 1);
        const std::vector<DelayedGrant> grants =
            play_delayed(random, rows, 0, 1, cycles, random.between(1, 20));
        double longest = 0.0;
        double lacking = 0.0;
        for (std::size_t n = 0; n < grants.size(); ++n) {
            longest = std::max(longest, static_cast<double>(grants[n].clocks));
            for (std::size_t from = 0; from < n; from += 5) {
                const auto own = static_cast<double>(n - from + 1);
                const auto rivals = static_cast<double>(grants[n].rivals - grants[from].rivals);
                lacking = std::max(lacking, fairness.rate * own - fairness.loss - rivals);
            }
        }
        CHECK(longest <= wait.most[1]);
        CHECK(lacking <= 1.0 + 1e-6);  // the window begins after the rival's grants up to its first own one
        CHECK(wait.rate == wait.most[1]);
    }
}

TEST_CASE("the sure grants of a row are its slots unless bursts are single beats", "[analysis]") {
    const std::vector<int> table{0, 0, 1, 0, 2};
    const SlotShares whole(table, 3, RepeatedSlot::kGranted);
    CHECK(whole.sure_grants(0) == 3);
    CHECK(whole.slots(0) == 3);
    const SlotShares lost(table, 3, RepeatedSlot::kLost);
    CHECK(lost.sure_grants(0) == 2);
    CHECK(lost.slots(0) == 3);
    CHECK(lost.sure_grants(1) == 1);
    const SlotShares skipped(table, 3, RepeatedSlot::kSkipped);
    CHECK(skipped.sure_grants(0) == 1);
    const SlotShares alone({0}, 1, RepeatedSlot::kSkipped);
    CHECK(alone.sure_grants(0) == 1);
}
