#include "datapath/slot_table.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/random_seed.h"
#include "support/rows.h"

namespace metabuffer {
namespace {

ViewportRow segment(int sdx, int dmultiple) { return test::segment_row({sdx, 1}, {}, dmultiple); }

std::vector<int> slots_of_each(const std::vector<int>& table, std::size_t rows) {
    std::vector<int> result(rows, 0);
    for (const int row : table) {
        REQUIRE(row >= 0);
        REQUIRE(static_cast<std::size_t>(row) < rows);
        ++result[static_cast<std::size_t>(row)];
    }
    return result;
}

/// The longest way from a slot of the row to its next one, the table read in a circle.
int longest_gap(const std::vector<int>& table, int row) {
    int longest = 0;
    int since = 0;
    bool seen = false;
    for (std::size_t i = 0; i < 2 * table.size(); ++i) {
        ++since;
        if (table[i % table.size()] != row) continue;
        if (seen) longest = std::max(longest, since);
        seen = true;
        since = 0;
    }
    return longest;
}

ViewportTable random_rows(test::Random& random, int most_rows) {
    ViewportTable rows;
    for (int count = random.between(1, most_rows); count > 0; --count) {
        const int widest = random.one_in(4) ? 4096 : 40;
        const int largest_multiple = random.one_in(4) ? 255 : 4;
        rows.push_back(segment(random.between(1, widest), random.between(1, largest_multiple)));
    }
    return rows;
}

TEST_CASE("slot table: no rows, no slots") {
    CHECK(slot_table({}).empty());
    CHECK(equal_slot_table({}).empty());
}

TEST_CASE("slot table: a renderer of one display has one slot whatever its width and multiple") {
    CHECK(slot_table({segment(1, 1)}) == std::vector<int>{0});
    CHECK(slot_table({segment(4096, 255)}) == std::vector<int>{0});
    CHECK(slot_table({segment(65535, 3)}) == std::vector<int>{0});
}

TEST_CASE("slot table: case one and three of the paper, equal needs, give one slot each") {
    CHECK(slot_table({segment(100, 1)}) == std::vector<int>{0});
    CHECK(slot_table({segment(50, 2), segment(50, 2), segment(50, 2), segment(50, 2)}) ==
          std::vector<int>{0, 1, 2, 3});
    CHECK(slot_table({segment(7, 3), segment(7, 3), segment(7, 3)}) == std::vector<int>{0, 1, 2});
}

TEST_CASE("slot table: the paper's sample table, 75 and 25 columns, gives three slots to one") {
    const ViewportTable rows = {segment(75, 1), segment(25, 1), segment(75, 1), segment(25, 1)};
    const std::vector<int> table = slot_table(rows);
    CHECK(slots_of_each(table, 4) == std::vector<int>{3, 1, 3, 1});
    CHECK(slot_table({segment(75, 1), segment(25, 1)}) == std::vector<int>{0, 0, 1, 0});
}

TEST_CASE("slot table: case four of the paper, l and w - l beside a whole width") {
    // w = 100 source columns at a multiple of 2, cut at l = 40 of 100.
    const ViewportTable rows = {segment(20, 2), segment(30, 2), segment(50, 2),
                                segment(20, 2), segment(30, 2), segment(50, 2)};
    CHECK(slots_of_each(slot_table(rows), 6) == std::vector<int>{2, 3, 5, 2, 3, 5});
}

TEST_CASE("slot table: a multiple divides the need, since a source row then serves several raster rows") {
    CHECK(slots_of_each(slot_table({segment(10, 1), segment(10, 2)}), 2) == std::vector<int>{2, 1});
    CHECK(slots_of_each(slot_table({segment(10, 4), segment(10, 1)}), 2) == std::vector<int>{1, 4});
    CHECK(slot_table({segment(10, 1), segment(20, 2), segment(40, 4)}) == std::vector<int>{0, 1, 2});
}

TEST_CASE("slot table: proportions are exact for multiples that are no powers of two") {
    CHECK(slots_of_each(slot_table({segment(20, 3), segment(40, 3)}), 2) == std::vector<int>{1, 2});
    CHECK(slots_of_each(slot_table({segment(30, 3), segment(50, 5), segment(70, 7)}), 3) ==
          std::vector<int>{1, 1, 1});
    CHECK(slots_of_each(slot_table({segment(10, 3), segment(10, 5)}), 2) == std::vector<int>{5, 3});
}

TEST_CASE("slot table: height and position of a segment have no effect") {
    ViewportRow tall = segment(30, 1);
    tall.sdy = 900;
    tall.dcomp = 7;
    tall.dx = -5;
    CHECK(slot_table({tall, segment(30, 1)}) == std::vector<int>{0, 1});
}

TEST_CASE("slot table: proportions are exact up to the limit and rounded to nearest beyond it") {
    CHECK(slots_of_each(slot_table({segment(255, 1), segment(1, 1)}), 2) == std::vector<int>{255, 1});
    CHECK(slots_of_each(slot_table({segment(129, 1), segment(127, 1)}), 2) == std::vector<int>{129, 127});
    // 256 of 257 and 1 of 257 of 256 slots: 255.004 and 0.996.
    CHECK(slots_of_each(slot_table({segment(256, 1), segment(1, 1)}), 2) == std::vector<int>{255, 1});
    // 1000 : 333 : 1 of 256: 191.9, 63.9, 0.19, and no row goes without.
    CHECK(slots_of_each(slot_table({segment(1000, 1), segment(333, 1), segment(1, 1)}), 3) ==
          std::vector<int>{192, 64, 1});
}

TEST_CASE(
    "slot table: needs are exact before rounding as long as the multiples have a common one up to 2^32") {
    // The multiples' least common one is 2,328,406,311, between 2^31 and 2^32. The third row's share is 55.5001 slots.
    const ViewportTable rows = {segment(3, 201), segment(2, 211), segment(3, 253), segment(4, 217)};
    CHECK(slots_of_each(slot_table(rows), rows.size()) == std::vector<int>{70, 44, 56, 86});
}

TEST_CASE("slot table: every row has a slot even if rows outnumber the limit") {
    ViewportTable rows(300, segment(1, 1));
    rows[7] = segment(4096, 1);
    const std::vector<int> slots = slots_of_each(slot_table(rows), rows.size());
    CHECK(*std::min_element(slots.begin(), slots.end()) == 1);
    CHECK(slots[7] > 200);
}

TEST_CASE("slot table: shares of random rows are in proportion to C / T and the table is short") {
    const auto seed = test::random_seed(106);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 500; ++trial) {
        const ViewportTable rows = random_rows(random, 24);
        const std::vector<int> table = slot_table(rows);
        const std::vector<int> slots = slots_of_each(table, rows.size());
        // Rounding moves each share by half a slot, the least share by one.
        REQUIRE(table.size() <= static_cast<std::size_t>(most_slots(static_cast<int>(rows.size()))));

        long double need = 0;
        for (const ViewportRow& row : rows) need += static_cast<long double>(row.sdx) / row.dmultiple;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            INFO("trial " << trial << ", row " << i << ": sdx " << rows[i].sdx << ", multiple "
                          << rows[i].dmultiple << ", " << slots[i] << " of " << table.size() << " slots");
            const long double share = static_cast<long double>(rows[i].sdx) / rows[i].dmultiple / need;
            CHECK(slots[i] >= 1);
            // In a table within the limit the share is exact, except for the weights' fixed point. In a longer one it
            // was rounded as for a table of 256 slots.
            const bool exact = std::fabs(share * table.size() - slots[i]) < 0.01L;
            const bool rounded = std::fabs(share * 256 - slots[i]) <= 0.501L;
            const bool raised = share * 256 < 1 && slots[i] == 1;
            CHECK((exact || rounded || raised));
        }
    }
}

TEST_CASE("slot table: each slot goes to the row that is owed most, the first of equals") {
    const auto seed = test::random_seed(107);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 300; ++trial) {
        const ViewportTable rows = random_rows(random, 12);
        const std::vector<int> table = slot_table(rows);
        const std::vector<int> slots = slots_of_each(table, rows.size());
        const auto length = static_cast<std::int64_t>(table.size());
        std::vector<std::int64_t> had(rows.size(), 0);
        for (std::int64_t t = 0; t < length; ++t) {
            // What a row is owed after t + 1 slots, in units of 1 / length slots: its share less the slots that it had.
            std::size_t most_owed = 0;
            std::int64_t most = 0;
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const std::int64_t owed = (t + 1) * slots[i] - had[i] * length;
                if (i == 0 || owed > most) {
                    most = owed;
                    most_owed = i;
                }
            }
            const auto chosen = static_cast<std::size_t>(table[static_cast<std::size_t>(t)]);
            INFO("trial " << trial << ", slot " << t << " of " << length);
            REQUIRE(chosen == most_owed);
            ++had[chosen];
        }
    }
}

TEST_CASE("slot table: two rows alternate as evenly as whole slots allow") {
    for (int a = 1; a <= 40; ++a) {
        for (int b = 1; b <= 40; ++b) {
            const std::vector<int> table = slot_table({segment(a, 1), segment(b, 1)});
            const auto length = static_cast<int>(table.size());
            const std::vector<int> slots = slots_of_each(table, 2);
            INFO(a << " : " << b);
            for (const int row : {0, 1}) {
                const int share = slots[static_cast<std::size_t>(row)];
                CHECK(longest_gap(table, row) <= (length + share - 1) / share);
            }
        }
    }
}

TEST_CASE("slot table: no row waits much longer than its period, so a small buffer bridges the gap") {
    const auto seed = test::random_seed(108);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 500; ++trial) {
        const ViewportTable rows = random_rows(random, 16);
        const std::vector<int> table = slot_table(rows);
        const std::vector<int> slots = slots_of_each(table, rows.size());
        // Always serving the one owed most keeps what k rows are owed below the k-th harmonic number of
        // slots, and serving ahead of time puts a row at most one slot ahead.
        double harmonic = 0;
        for (std::size_t k = 1; k <= rows.size(); ++k) harmonic += 1.0 / static_cast<double>(k);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            INFO("trial " << trial << ", row " << i << ", " << slots[i] << " of " << table.size());
            const double period = static_cast<double>(table.size()) / slots[i];
            CHECK(longest_gap(table, static_cast<int>(i)) <= (harmonic + 1.0) * period);
        }
    }
}

TEST_CASE("slot table: round robin gives every row one slot in table order whatever its need") {
    CHECK(equal_slot_table({segment(1, 1), segment(4096, 1), segment(5, 255)}) == std::vector<int>{0, 1, 2});
}

TEST_CASE("slot table: with less room the shares are rounded more, and each row still has a slot") {
    const ViewportTable rows = {segment(640, 1), segment(320, 1), segment(100, 1)};
    CHECK(slots_of_each(slot_table(rows, 53), 3) == std::vector<int>{32, 16, 5});  // exact
    CHECK(slots_of_each(slot_table(rows, 20), 3) == std::vector<int>{12, 6, 2});
    CHECK(slots_of_each(slot_table(rows, 1), 3) == std::vector<int>{1, 1, 1});
}

/// Five rows of which the second and the last break a rule.
ValidatedTable three_of_five() {
    return {{segment(3, 1), segment(2, 1), segment(1, 1)},
            {{1, RowDefect::kSource, ""}, {4, RowDefect::kSource, ""}}};
}

TEST_CASE("slot table: the host counts the rows that it sends, the machine those that stand") {
    CHECK(sent_indices(three_of_five()) == std::vector<int>{0, 2, 3});
    CHECK(judge_slots({0, 2, 0, 3, 2, 0}, three_of_five()) == std::vector<int>{0, 1, 0, 2, 1, 0});
    CHECK(sent_indices({{segment(3, 1), segment(2, 1)}, {}}) == std::vector<int>{0, 1});
    const RejectedRow first{0, RowDefect::kSource, ""};
    const RejectedRow second{1, RowDefect::kSource, ""};
    const RejectedRow fourth{3, RowDefect::kSource, ""};
    CHECK(sent_indices({{segment(3, 1), segment(2, 1)}, {first, second, fourth}}) == std::vector<int>{2, 4});
}

TEST_CASE(
    "slot table: a sent table is wrong if it has a slot of a dropped row or none of a valid one, or is too "
    "long") {
    CHECK_FALSE(judge_slots({0, 2, 3, 1}, three_of_five()));
    CHECK_FALSE(judge_slots({0, 2, 3, 5}, three_of_five()));
    CHECK_FALSE(judge_slots({0, 2, 0}, three_of_five()));
    CHECK_FALSE(judge_slots({}, three_of_five()));
    std::vector<int> longest(static_cast<std::size_t>(most_slots(5)), 0);
    longest[1] = 2;
    longest[2] = 3;
    CHECK(judge_slots(longest, three_of_five()));
    longest.push_back(0);
    CHECK_FALSE(judge_slots(longest, three_of_five()));
}

}  // namespace
}  // namespace metabuffer
