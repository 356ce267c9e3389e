#include "formats/viewport_table.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "support/random_seed.h"
#include "support/refusals.h"
#include "support/rows.h"

namespace metabuffer {
namespace {

constexpr ViewportLimits kLimits{4, 100, 80, 201, 150, 1024, 32};

/// A valid row, far from every limit.
ViewportRow good_row() { return test::table_row(1, {10, 10}, {20, 15}, {30, 40}, 3); }

using Change = std::function<void(ViewportRow&)>;

ViewportRow changed(const Change& change) {
    ViewportRow row = good_row();
    change(row);
    return row;
}

/// What is said of the row after a change of it; nothing if it is valid.
auto message_with(const ViewportLimits& limits) {
    return [limits](const Change& change) {
        const ValidatedTable result = validate_table({changed(change)}, limits);
        REQUIRE(result.rows.size() + result.rejected.size() == 1);
        return result.rejected.empty() ? std::string() : result.rejected.front().message;
    };
}

/// Whether any repetition of the source line that is the index-th of the segment lies on the raster.
bool shows(int destination, int multiple, int index, int raster) {
    for (int repetition = 0; repetition < multiple; ++repetition) {
        const int position = destination + index * multiple + repetition;
        if (position >= 0 && position < raster) return true;
    }
    return false;
}

/// The rules by their purpose: the display exists, the pixels exist, and the first and the last one show.
RowDefect judged(const ViewportRow& row, const ViewportLimits& limits) {
    std::set<int> displays;
    for (int display = 1; display <= limits.displays; ++display) displays.insert(display);
    if (displays.count(row.dcomp) == 0) return RowDefect::kDisplay;
    if (row.dmultiple == 0 || row.dmultiple >= 256) return RowDefect::kMultiple;
    if (row.sdx == 0 || row.sdy == 0) return RowDefect::kSource;
    const int last_source_x = row.sx + row.sdx - 1;
    const int last_source_y = row.sy + row.sdy - 1;
    if (last_source_x >= limits.image_width_pixels || last_source_y >= limits.image_height_pixels) {
        return RowDefect::kSource;
    }
    const bool smoothed = limits.smoothing == Smoothing::kBilinear && row.dmultiple > 1;
    // Smoothed, the outermost one need not show itself if the next one to it does.
    const auto ends_show = [&](int destination, int count, int raster) {
        const auto shows_line = [&](int index) { return shows(destination, row.dmultiple, index, raster); };
        if (shows_line(0) && shows_line(count - 1)) return true;
        if (!smoothed || count == 1) return false;
        const bool first = shows_line(0) || (destination < 0 && shows_line(1));
        const bool last = shows_line(count - 1) ||
                          (destination + (count - 1) * row.dmultiple >= raster && shows_line(count - 2));
        return first && last;
    };
    if (!ends_show(row.dx, row.sdx, limits.raster_width_pixels) ||
        !ends_show(row.dy, row.sdy, limits.raster_height_pixels)) {
        return RowDefect::kDestination;
    }
    const int window = row.dmultiple == 1 ? 0 : (smoothed ? row.sdx + row.sdx : row.sdx);
    // The last pixel of the window comes into the ready space.
    const int held = std::max(window - 1, 0);
    return limits.buffer_pixels - held < limits.ready_space_pixels ? RowDefect::kBuffer : RowDefect::kNone;
}

TEST_CASE("viewport table: the paper's sample table is valid as it is") {
    const ViewportTable table = {{1, 0, 0, 75, 75, 25, 25, 1},
                                 {2, 75, 0, 25, 75, 0, 25, 1},
                                 {3, 0, 75, 75, 25, 25, 0, 1},
                                 {4, 75, 75, 25, 25, 0, 0, 1}};
    const ValidatedTable result = validate_table(table, {4, 100, 100, 100, 100, 64, 32});
    CHECK((result.rows == table));
    CHECK(result.rejected.empty());
    CHECK(validate_table({}, kLimits).rows.empty());
    CHECK(validate_table({}, kLimits).rejected.empty());
}

TEST_CASE("viewport row: each rule up to its limit, and beyond it what is wrong and what would be right") {
    test::check_refusals<Change>(message_with(kLimits))({
        {[](auto& row) { row.dcomp = 4; }, ""},
        {[](auto& row) { row.dcomp = 0; }, "Dcomp 0 is not a display: 1 to 4"},
        {[](auto& row) { row.dcomp = 5; }, "Dcomp 5 is not a display: 1 to 4"},
        {[](auto& row) { row.dcomp = 65535; }, "Dcomp 65535 is not a display: 1 to 4"},
        {[](auto& row) { row.dmultiple = 1; }, ""},
        {[](auto& row) { row.dmultiple = 255, row.sdx = row.sdy = 1; }, ""},
        {[](auto& row) { row.dmultiple = 0; }, "Dmultiple 0 is outside 1 to 255"},
        {[](auto& row) { row.dmultiple = 256, row.sdx = row.sdy = 1; }, "Dmultiple 256 is outside 1 to 255"},
        {[](auto& row) { row.dmultiple = 65535; }, "Dmultiple 65535 is outside 1 to 255"},
        {[](auto& row) { row.sdx = 1; }, ""},
        {[](auto& row) { row.sdy = 1; }, ""},
        {[](auto& row) { row.sdx = 0; }, "Sdx 0 makes the segment empty: at least 1"},
        {[](auto& row) { row.sdy = 0; }, "Sdy 0 makes the segment empty: at least 1"},
        {[](auto& row) { row.sx = 80; }, ""},
        {[](auto& row) { row.sx = 81; }, "Sx + Sdx = 101 leaves the image of 100 pixels"},
        {[](auto& row) { row.sy = 65; }, ""},
        {[](auto& row) { row.sy = 66; }, "Sy + Sdy = 81 leaves the image of 80 scanlines"},
        {[](auto& row) {
             row = test::table_row(1, {}, {100, 80}, {});
         },
         ""},
        {[](auto& row) {
             row = test::table_row(1, {}, {101, 80}, {});
         },
         "Sx + Sdx = 101 leaves the image of 100 pixels"},
        {[](auto& row) {
             row = test::table_row(1, {}, {100, 81}, {});
         },
         "Sy + Sdy = 81 leaves the image of 80 scanlines"},
        // The sum of two 16-bit fields needs 17 bits.
        {[](auto& row) { row.sx = 65535; }, "Sx + Sdx = 65555 leaves the image of 100 pixels"},
        {[](auto& row) { row.sdy = 65530; }, "Sy + Sdy = 65540 leaves the image of 80 scanlines"},
        {[](auto& row) { row.dx = -2; }, ""},
        {[](auto& row) { row.dx = -3; },
         "its first source column lies left of the raster: Dx = -3 must stay above -3"},
        {[](auto& row) { row.dy = -2; }, ""},
        {[](auto& row) { row.dy = -3; },
         "its first source row lies above the raster: Dy = -3 must stay above -3"},
        {[](auto& row) { row.dmultiple = 1, row.dx = -1; },
         "its first source column lies left of the raster: Dx = -1 must stay above -1"},
        {[](auto& row) { row.sdx = 1, row.dx = 200; }, ""},
        {[](auto& row) { row.sdx = 1, row.dx = 201; },
         "its first source column lies right of the raster: Dx = 201 must stay below 201"},
        {[](auto& row) { row.sdy = 1, row.dy = 149; }, ""},
        {[](auto& row) { row.sdy = 1, row.dy = 150; },
         "its first source row lies below the raster: Dy = 150 must stay below 150"},
        {[](auto& row) { row.dx = 143; }, ""},
        {[](auto& row) { row.dx = 144; },
         "its last source column lies right of the raster: Dx + Sdx*m = 204 must stay below 204"},
        {[](auto& row) { row.dy = 107; }, ""},
        {[](auto& row) { row.dy = 108; },
         "its last source row lies below the raster: Dy + Sdy*m = 153 must stay below 153"},
    });
}

TEST_CASE("viewport row: smoothed, the outermost source lines may lie beside the raster, the next may not") {
    // Sdx 20, Sdy 15, Dmultiple 3, a raster of 201 x 150.
    ViewportLimits limits = kLimits;
    limits.smoothing = Smoothing::kBilinear;
    test::check_refusals<Change>(message_with(limits))({
        {[](auto& row) { row.dx = -5; }, ""},
        {[](auto& row) { row.dx = -6; },
         "its second source column lies left of the raster: Dx = -6 must stay above -6"},
        {[](auto& row) { row.dy = -5; }, ""},
        {[](auto& row) { row.dy = -6; },
         "its second source row lies above the raster: Dy = -6 must stay above -6"},
        {[](auto& row) { row.dx = 146; }, ""},
        {[](auto& row) { row.dx = 147; },
         "its last but one source column lies right of the raster: Dx + Sdx*m = 207 must stay below 207"},
        {[](auto& row) { row.dy = 110; }, ""},
        {[](auto& row) { row.dy = 111; },
         "its last but one source row lies below the raster: Dy + Sdy*m = 156 must stay below 156"},
        // A first source column that may lie beside the raster is not what is wrong.
        {[](auto& row) { row.sx = 0, row.sdx = 72, row.dx = -5; },
         "its last but one source column lies right of the raster: Dx + Sdx*m = 211 must stay below 207"},
        // A single source line is its own neighbour, and must show. At Dmultiple 1 nothing is smoothed.
        {[](auto& row) { row.sdx = 1, row.dx = -3; },
         "its first source column lies left of the raster: Dx = -3 must stay above -3"},
        {[](auto& row) { row.dmultiple = 1, row.dx = -1; },
         "its first source column lies left of the raster: Dx = -1 must stay above -1"},
    });
}

TEST_CASE(
    "viewport row: the buffer holds the ready space, and beside it all but a pixel of the source rows that "
    "are read again") {
    struct Case {
        Smoothing smoothing;
        std::uint16_t multiple;
        int buffer_pixels;
        const char* least;  ///< nothing: it is enough
    };
    for (const Case& one : {Case{Smoothing::kReplicate, 3, 51, ""},
                            Case{Smoothing::kReplicate, 3, 50, "Sdx - 1 + ready_space_pixels = 51"},
                            Case{Smoothing::kReplicate, 1, 32, ""},
                            Case{Smoothing::kReplicate, 1, 31, "ready_space_pixels = 32"},
                            Case{Smoothing::kBilinear, 3, 71, ""},
                            Case{Smoothing::kBilinear, 3, 70, "2*Sdx - 1 + ready_space_pixels = 71"},
                            Case{Smoothing::kBilinear, 1, 32, ""}}) {
        ViewportLimits limits = kLimits;
        limits.smoothing = one.smoothing;
        limits.buffer_pixels = one.buffer_pixels;
        const std::string least = one.least;
        CHECK(message_with(limits)([&one](auto& row) { row.dmultiple = one.multiple; }) ==
              (least.empty() ? ""
                             : "the composer's buffer of " + std::to_string(one.buffer_pixels) +
                                   " pixels could never hold what the row needs: at least " + least));
    }
}

TEST_CASE("viewport row: extreme fields and limits overflow nothing") {
    constexpr int kHuge = 2147483647;
    ViewportRow row{65535, 65535, 65535, 65535, 65535, -32768, 32767, 65535};
    ViewportLimits limits{kHuge, kHuge, kHuge, kHuge, kHuge, kHuge, kHuge};
    CHECK(row_defect(row, limits) == RowDefect::kMultiple);
    row.dmultiple = 255;
    CHECK(row_defect(row, limits) == RowDefect::kDestination);
    row.dx = -254;
    CHECK(row_defect(row, limits) == RowDefect::kBuffer);
    limits.ready_space_pixels = kHuge - 65534;
    CHECK(row_defect(row, limits) == RowDefect::kNone);
    limits.raster_height_pixels = 32767 + 65535 * 255 - 254;
    CHECK(row_defect(row, limits) == RowDefect::kNone);
    limits.raster_height_pixels -= 1;
    CHECK(row_defect(row, limits) == RowDefect::kDestination);
}

TEST_CASE("viewport table: of several defects the first in the order of the rules counts") {
    ViewportLimits limits = kLimits;
    limits.buffer_pixels = 1;
    // Wrong in every way, and put right from the first rule to the last.
    ViewportRow row{9, 0, 0, 0, 1, -1000, 0, 0};
    CHECK(row_defect(row, limits) == RowDefect::kDisplay);
    row.dcomp = 1;
    CHECK(row_defect(row, limits) == RowDefect::kMultiple);
    row.dmultiple = 1;
    CHECK(row_defect(row, limits) == RowDefect::kSource);
    row.sdx = 1;
    CHECK(row_defect(row, limits) == RowDefect::kDestination);
    row.dx = 0;
    CHECK(row_defect(row, limits) == RowDefect::kBuffer);
    limits.buffer_pixels = limits.ready_space_pixels;
    CHECK(row_defect(row, limits) == RowDefect::kNone);

    const ViewportRow duplicate_and_worse{1, 0, 0, 0, 1, -1000, 0, 0};
    const ValidatedTable result = validate_table({row, duplicate_and_worse}, limits);
    REQUIRE(result.rejected.size() == 1);
    CHECK(result.rejected[0].defect == RowDefect::kDuplicate);
    CHECK(result.rejected[0].message ==
          "Dcomp 1 is taken by an earlier row of the table: one row for each display");
}

TEST_CASE("viewport table: a display is taken by the first valid row that names it, never by a dropped one") {
    const auto row = [](int dcomp, int sdx) {
        return ViewportRow{
            static_cast<std::uint16_t>(dcomp), 0, 0, static_cast<std::uint16_t>(sdx), 1, 0, 0, 1};
    };
    const ViewportTable table = {row(2, 0), row(2, 5), row(2, 6), row(1, 7), row(0, 1), row(0, 1), row(2, 0)};
    const ValidatedTable result = validate_table(table, kLimits);
    CHECK((result.rows == ViewportTable{row(2, 5), row(1, 7)}));
    REQUIRE(result.rejected.size() == 5);
    const RejectedRow* rejected = result.rejected.data();
    CHECK((rejected[0].index == 0 && rejected[0].defect == RowDefect::kSource));
    CHECK((rejected[1].index == 2 && rejected[1].defect == RowDefect::kDuplicate));
    CHECK((rejected[2].index == 4 && rejected[2].defect == RowDefect::kDisplay));
    CHECK((rejected[3].index == 5 && rejected[3].defect == RowDefect::kDisplay));
    CHECK((rejected[4].index == 6 && rejected[4].defect == RowDefect::kDuplicate));
}

TEST_CASE("viewport table: rows of random tables are accepted and dropped as the rules say") {
    const auto seed = test::random_seed(112);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    int seen[kRowDefectCount] = {};
    for (int trial = 0; trial < 20000; ++trial) {
        const ViewportLimits limits{
            random.between(1, 4),  random.between(1, 12),
            random.between(1, 12), random.between(1, 20),
            random.between(1, 20), random.between(1, 24),
            random.between(1, 16), random.one_in(2) ? Smoothing::kBilinear : Smoothing::kReplicate};
        ViewportTable table;
        for (int rows = random.between(1, 5); rows > 0; --rows) {
            const auto u16 = [&random](int low, int high) {
                return static_cast<std::uint16_t>(random.between(low, high));
            };
            const auto s16 = [&random](int low, int high) {
                return static_cast<std::int16_t>(random.between(low, high));
            };
            const int largest = random.one_in(8) ? 260 : 4;
            const int lowest = random.one_in(8) ? -260 : -8;
            table.push_back({u16(random.one_in(8) ? 0 : 1, limits.displays + (random.one_in(8) ? 1 : 0)),
                             u16(0, 4), u16(0, 4), u16(0, 6), u16(0, 6), s16(lowest, 21), s16(lowest, 21),
                             u16(random.one_in(8) ? 0 : 1, largest)});
        }
        const ValidatedTable result = validate_table(table, limits);
        std::set<int> taken;
        std::size_t stood = 0;
        std::size_t dropped = 0;
        for (std::size_t i = 0; i < table.size(); ++i) {
            INFO("trial " << trial << ", row " << i);
            const RowDefect alone = judged(table[i], limits);
            REQUIRE(row_defect(table[i], limits) == alone);
            const RowDefect wanted = taken.count(table[i].dcomp) != 0 ? RowDefect::kDuplicate : alone;
            ++seen[static_cast<int>(wanted)];
            if (wanted == RowDefect::kNone) {
                taken.insert(table[i].dcomp);
                REQUIRE(stood < result.rows.size());
                REQUIRE((result.rows[stood++] == table[i]));
            } else {
                REQUIRE(dropped < result.rejected.size());
                REQUIRE(result.rejected[dropped].index == static_cast<int>(i));
                REQUIRE(result.rejected[dropped].defect == wanted);
                REQUIRE_FALSE(result.rejected[dropped++].message.empty());
            }
        }
        REQUIRE(stood == result.rows.size());
        REQUIRE(dropped == result.rejected.size());
    }
    for (const int count : seen) CHECK(count > 100);  // the random tables reach every rule
}

TEST_CASE("viewport table: each defect has its own key in the report") {
    const std::vector<std::string> keys{"none",   "display",     "duplicate", "multiple",
                                        "source", "destination", "buffer"};
    REQUIRE(keys.size() == kRowDefectCount);
    for (std::size_t n = 0; n < keys.size(); ++n) {
        CHECK(row_defect_key(static_cast<RowDefect>(n)) == keys[n]);
    }
}

}  // namespace
}  // namespace metabuffer
