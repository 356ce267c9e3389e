#include "formats/viewport_table.h"

#include <catch2/catch.hpp>
#include <functional>
#include <set>
#include <string>

#include "support/random_seed.h"
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

RowDefect defect_after(const Change& change) { return row_defect(changed(change), kLimits); }

std::string message_after(const Change& change, const ViewportLimits& limits = kLimits) {
    const ValidatedTable result = validate_table({changed(change)}, limits);
    REQUIRE(result.rows.empty());
    REQUIRE(result.rejected.size() == 1);
    return result.rejected.front().message;
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
    const int free_beside_window = limits.buffer_pixels - window;
    return free_beside_window < limits.ready_space_pixels ? RowDefect::kBuffer : RowDefect::kNone;
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

TEST_CASE("viewport row: Dcomp is 1 to the number of displays") {
    for (const int dcomp : {1, 2, 3, 4}) {
        CHECK(defect_after([&](ViewportRow& row) { row.dcomp = static_cast<std::uint16_t>(dcomp); }) ==
              RowDefect::kNone);
    }
    for (const int dcomp : {0, 5, 6, 32768, 65535}) {
        CHECK(defect_after([&](ViewportRow& row) { row.dcomp = static_cast<std::uint16_t>(dcomp); }) ==
              RowDefect::kDisplay);
    }
}

TEST_CASE("viewport row: Dmultiple is 1 to 255") {
    for (const int multiple : {1, 2, 254, 255}) {
        CHECK(defect_after([&](ViewportRow& row) {
                  row.dmultiple = static_cast<std::uint16_t>(multiple);
                  row.sdx = row.sdy = 1;
              }) == RowDefect::kNone);
    }
    for (const int multiple : {0, 256, 32768, 65535}) {
        CHECK(defect_after([&](ViewportRow& row) {
                  row.dmultiple = static_cast<std::uint16_t>(multiple);
                  row.sdx = row.sdy = 1;
              }) == RowDefect::kMultiple);
    }
}

TEST_CASE("viewport row: the source rectangle is not empty") {
    CHECK(defect_after([](ViewportRow& row) { row.sdx = 1; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.sdy = 1; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.sdx = 0; }) == RowDefect::kSource);
    CHECK(defect_after([](ViewportRow& row) { row.sdy = 0; }) == RowDefect::kSource);
}

TEST_CASE("viewport row: the source rectangle stays within the image") {
    CHECK(defect_after([](ViewportRow& row) { row.sx = 80; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.sx = 81; }) == RowDefect::kSource);
    CHECK(defect_after([](ViewportRow& row) { row.sy = 65; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.sy = 66; }) == RowDefect::kSource);
    const auto whole_image = [](ViewportRow& row) {
        row.sx = row.sy = 0;
        row.dmultiple = 1;
        row.sdx = 100;
        row.sdy = 80;
    };
    CHECK(defect_after(whole_image) == RowDefect::kNone);
    CHECK(defect_after([&](ViewportRow& row) {
              whole_image(row);
              row.sdx = 101;
          }) == RowDefect::kSource);
    CHECK(defect_after([&](ViewportRow& row) {
              whole_image(row);
              row.sdy = 81;
          }) == RowDefect::kSource);
    // The sum of two 16-bit fields needs 17 bits.
    CHECK(defect_after([](ViewportRow& row) { row.sx = 65535; }) == RowDefect::kSource);
    CHECK(defect_after([](ViewportRow& row) { row.sdy = 65530; }) == RowDefect::kSource);
}

TEST_CASE("viewport row: its first source pixel shows at least in part") {
    CHECK(defect_after([](ViewportRow& row) { row.dx = -2; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.dx = -3; }) == RowDefect::kDestination);
    CHECK(defect_after([](ViewportRow& row) { row.dy = -2; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.dy = -3; }) == RowDefect::kDestination);
    CHECK(defect_after([](ViewportRow& row) {
              row.sdx = 1;
              row.dx = 200;
          }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) {
              row.sdx = 1;
              row.dx = 201;
          }) == RowDefect::kDestination);
    CHECK(defect_after([](ViewportRow& row) {
              row.sdy = 1;
              row.dy = 149;
          }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) {
              row.sdy = 1;
              row.dy = 150;
          }) == RowDefect::kDestination);
    CHECK(defect_after([](ViewportRow& row) {
              row.dmultiple = 1;
              row.dx = -1;
          }) == RowDefect::kDestination);
}

TEST_CASE("viewport row: its last source pixel shows at least in part") {
    // Dx + 20 * 3 < 201 + 3 and Dy + 15 * 3 < 150 + 3.
    CHECK(defect_after([](ViewportRow& row) { row.dx = 143; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.dx = 144; }) == RowDefect::kDestination);
    CHECK(defect_after([](ViewportRow& row) { row.dy = 107; }) == RowDefect::kNone);
    CHECK(defect_after([](ViewportRow& row) { row.dy = 108; }) == RowDefect::kDestination);
}

TEST_CASE("viewport row: the buffer holds the ready space, and beside it a source row to be repeated") {
    ViewportLimits limits = kLimits;
    const ViewportRow replicated = good_row();  // Sdx 20
    ViewportRow single = good_row();
    single.dmultiple = 1;

    limits.buffer_pixels = 52;
    CHECK(row_defect(replicated, limits) == RowDefect::kNone);
    limits.buffer_pixels = 51;
    CHECK(row_defect(replicated, limits) == RowDefect::kBuffer);
    CHECK(row_defect(single, limits) == RowDefect::kNone);
    limits.buffer_pixels = 32;
    CHECK(row_defect(single, limits) == RowDefect::kNone);
    limits.buffer_pixels = 31;
    CHECK(row_defect(single, limits) == RowDefect::kBuffer);
}

TEST_CASE("viewport row: smoothed, the outermost source lines may lie beside the raster, the next may not") {
    // Sdx 20, Sdy 15, Dmultiple 3, a raster of 201 x 150.
    ViewportLimits limits = kLimits;
    limits.smoothing = Smoothing::kBilinear;
    const auto defect = [&](const Change& change) { return row_defect(changed(change), limits); };
    CHECK(defect([](ViewportRow& row) { row.dx = -5; }) == RowDefect::kNone);
    CHECK(defect([](ViewportRow& row) { row.dx = -6; }) == RowDefect::kDestination);
    CHECK(defect([](ViewportRow& row) { row.dy = -5; }) == RowDefect::kNone);
    CHECK(defect([](ViewportRow& row) { row.dy = -6; }) == RowDefect::kDestination);
    CHECK(defect([](ViewportRow& row) { row.dx = 146; }) == RowDefect::kNone);
    CHECK(defect([](ViewportRow& row) { row.dx = 147; }) == RowDefect::kDestination);
    CHECK(defect([](ViewportRow& row) { row.dy = 110; }) == RowDefect::kNone);
    CHECK(defect([](ViewportRow& row) { row.dy = 111; }) == RowDefect::kDestination);
    // A single source line is its own neighbour, and must show. At Dmultiple 1 nothing is smoothed.
    CHECK(defect([](ViewportRow& row) { row.sdx = 1, row.dx = -3; }) == RowDefect::kDestination);
    CHECK(defect([](ViewportRow& row) { row.dmultiple = 1, row.dx = -1; }) == RowDefect::kDestination);
    CHECK(message_after([](ViewportRow& row) { row.dx = -6; }, limits) ==
          "its second source column lies left of the raster: Dx = -6 must stay above -6");
    // A first source column that may lie beside the raster is not what is wrong.
    CHECK(message_after([](ViewportRow& row) { row.sx = 0, row.sdx = 72, row.dx = -5; }, limits) ==
          "its last but one source column lies right of the raster: Dx + Sdx*m = 211 must stay below 207");
    CHECK(message_after([](ViewportRow& row) { row.dy = 111; }, limits) ==
          "its last but one source row lies below the raster: Dy + Sdy*m = 156 must stay below 156");
}

TEST_CASE("viewport row: smoothed, the buffer holds two source rows beside the ready space") {
    ViewportLimits limits = kLimits;
    limits.smoothing = Smoothing::kBilinear;
    limits.buffer_pixels = 72;
    CHECK(row_defect(good_row(), limits) == RowDefect::kNone);
    limits.buffer_pixels = 71;
    CHECK(row_defect(good_row(), limits) == RowDefect::kBuffer);
    CHECK(message_after([](ViewportRow&) {}, limits) ==
          "the composer's buffer of 71 pixels could never hold what the row needs: at least 2*Sdx + "
          "ready_space_pixels = 72");
    ViewportRow single = good_row();
    single.dmultiple = 1;
    limits.buffer_pixels = 32;
    CHECK(row_defect(single, limits) == RowDefect::kNone);
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
    limits.ready_space_pixels = kHuge - 65535;
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

TEST_CASE("viewport table: a dropped row is reported with what is wrong and what would be right") {
    CHECK(message_after([](ViewportRow& row) { row.dcomp = 5; }) == "Dcomp 5 is not a display: 1 to 4");
    CHECK(message_after([](ViewportRow& row) { row.dmultiple = 0; }) == "Dmultiple 0 is outside 1 to 255");
    CHECK(message_after([](ViewportRow& row) { row.sdx = 0; }) ==
          "Sdx 0 makes the segment empty: at least 1");
    CHECK(message_after([](ViewportRow& row) { row.sdy = 0; }) ==
          "Sdy 0 makes the segment empty: at least 1");
    CHECK(message_after([](ViewportRow& row) { row.sx = 100; }) ==
          "Sx + Sdx = 120 leaves the image of 100 pixels");
    CHECK(message_after([](ViewportRow& row) { row.sy = 90; }) ==
          "Sy + Sdy = 105 leaves the image of 80 scanlines");
    CHECK(message_after([](ViewportRow& row) { row.dx = -3; }) ==
          "its first source column lies left of the raster: Dx = -3 must stay above -3");
    CHECK(message_after([](ViewportRow& row) { row.dx = 201; }) ==
          "its first source column lies right of the raster: Dx = 201 must stay below 201");
    CHECK(message_after([](ViewportRow& row) { row.dx = 150; }) ==
          "its last source column lies right of the raster: Dx + Sdx*m = 210 must stay below 204");
    CHECK(message_after([](ViewportRow& row) { row.dy = -4; }) ==
          "its first source row lies above the raster: Dy = -4 must stay above -3");
    CHECK(message_after([](ViewportRow& row) { row.dy = 150; }) ==
          "its first source row lies below the raster: Dy = 150 must stay below 150");
    CHECK(message_after([](ViewportRow& row) { row.dy = 110; }) ==
          "its last source row lies below the raster: Dy + Sdy*m = 155 must stay below 153");
    const ValidatedTable twice = validate_table({good_row(), good_row()}, kLimits);
    REQUIRE(twice.rejected.size() == 1);
    CHECK(twice.rejected[0].message ==
          "Dcomp 1 is taken by an earlier row of the table: one row for each display");
}

TEST_CASE("viewport table: a buffer too small is reported with the size that would do") {
    ViewportLimits limits = kLimits;
    limits.buffer_pixels = 16;
    CHECK(message_after([](ViewportRow&) {}, limits) ==
          "the composer's buffer of 16 pixels could never hold what the row needs: at least Sdx + "
          "ready_space_pixels = 52");
    CHECK(message_after([](ViewportRow& row) { row.dmultiple = 1; }, limits) ==
          "the composer's buffer of 16 pixels could never hold what the row needs: at least "
          "ready_space_pixels = 32");
}

TEST_CASE("viewport table: each defect has its own key in the report") {
    CHECK(std::string(row_defect_key(RowDefect::kDisplay)) == "display");
    CHECK(std::string(row_defect_key(RowDefect::kDuplicate)) == "duplicate");
    CHECK(std::string(row_defect_key(RowDefect::kMultiple)) == "multiple");
    CHECK(std::string(row_defect_key(RowDefect::kSource)) == "source");
    CHECK(std::string(row_defect_key(RowDefect::kDestination)) == "destination");
    CHECK(std::string(row_defect_key(RowDefect::kBuffer)) == "buffer");
}

}  // namespace
}  // namespace metabuffer
