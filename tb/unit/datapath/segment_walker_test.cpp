#include <catch2/catch.hpp>
#include <cstddef>
#include <set>

#include "datapath/composer_buffer.h"
#include "support/random_seed.h"
#include "unit/datapath/painted_segment.h"
#include "unit/datapath/part_state.h"

namespace metabuffer {
namespace {

using test::PaintedSegment;
using test::Size;

void check_walk(const ViewportRow& row, Size raster) {
    INFO("raster " << raster.width << " x " << raster.height << ", sdx " << row.sdx << ", sdy " << row.sdy
                   << ", dx " << row.dx << ", dy " << row.dy << ", multiple " << row.dmultiple);
    const PaintedSegment wanted(row, raster);
    SegmentWalker walker(Segment(row, raster.width, raster.height), true, raster.width, raster.height);
    std::set<std::int64_t> source_rows_seen;  // by an earlier raster row
    for (int y = 0; y < raster.height; ++y) {
        std::int64_t source_row = PaintedSegment::kNone;
        for (int x = 0; x < raster.width; ++x) {
            INFO("raster pixel " << x << ", " << y);
            const std::int64_t position = std::int64_t{y} * raster.width + x;
            const std::int64_t k = wanted.owner[static_cast<std::size_t>(position)];
            REQUIRE_FALSE(walker.done());
            REQUIRE(walker.x() == x);
            REQUIRE(walker.y() == y);
            REQUIRE(walker.covered() == (k != PaintedSegment::kNone));
            if (k != PaintedSegment::kNone) {
                source_row = k / row.sdx;
                REQUIRE(walker.pixel() == k);
                REQUIRE(walker.column() == k % row.sdx);
                REQUIRE(walker.row_first_pixel() == source_row * row.sdx);
                REQUIRE(walker.row_phase() == (y - row.dy) % row.dmultiple);
                REQUIRE(walker.last_use() == (wanted.last[static_cast<std::size_t>(k)] == position));
                REQUIRE(walker.replayed() == (source_rows_seen.count(source_row) == 1));
            }
            walker.advance();
        }
        source_rows_seen.insert(source_row);
    }
    REQUIRE(walker.done());
}

TEST_CASE("segment walker: without a segment it walks the whole raster and covers nothing") {
    SegmentWalker walker(Segment(), false, 5, 3);
    for (int position = 0; position < 15; ++position) {
        REQUIRE_FALSE(walker.done());
        REQUIRE_FALSE(walker.covered());
        REQUIRE_FALSE(walker.replayed());
        walker.advance();
    }
    CHECK(walker.done());
}

TEST_CASE("segment walker: a new one is done, since it has no raster") { CHECK(SegmentWalker().done()); }

TEST_CASE("segment walker: agrees with painting for every valid row on a small raster") {
    const Size raster{5, 4};
    for (int multiple = 1; multiple <= 4; ++multiple) {
        for (int dx = 1 - multiple; dx < raster.width; ++dx) {
            for (int sdx = 1; dx + (sdx - 1) * multiple < raster.width; ++sdx) {
                for (int dy = 1 - multiple; dy < raster.height; ++dy) {
                    for (int sdy = 1; dy + (sdy - 1) * multiple < raster.height; ++sdy) {
                        check_walk(test::segment_row({sdx, sdy}, {dx, dy}, multiple), raster);
                    }
                }
            }
        }
    }
}

TEST_CASE("segment walker: a waveform shows where it is and what it walks over") {
    const Size raster{10, 8};
    SegmentWalker walker(Segment(test::segment_row({4, 3}, {-1, 2}, 3), raster.width, raster.height), true,
                         raster.width, raster.height);
    while (walker.y() < 6 || walker.x() < 4) walker.advance();
    const test::PartState shown(walker);
    CHECK(shown["x"] == 4);
    CHECK(shown["y"] == 6);
    CHECK(shown["left"] == 0);
    CHECK(shown["right"] == 10);
    CHECK(shown["top"] == 2);
    CHECK(shown["bottom"] == 8);
    CHECK(shown["multiple"] == 3);
    CHECK(shown["source_width"] == 4);
    CHECK(shown["start_column"] == 0);
    CHECK(shown["start_column_phase"] == 1);
    CHECK(shown["first_row_phase"] == 0);
    CHECK(shown["row_covered"] == 1);
    CHECK(shown["window_row_pixel"] == 4);
    CHECK(shown["window_column"] == 1);
    CHECK(shown["window_column_phase"] == 2);
    CHECK(shown["window_repetition"] == 1);
    CHECK(shown["last_repetition"] == 0);
}

TEST_CASE("segment walker: agrees with painting for random rows, clipped on any side, of any multiple") {
    const auto seed = test::random_seed(131);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 300; ++trial) {
        const Size raster{random.between(1, 40), random.between(1, 30)};
        check_walk(test::random_valid_row(random, raster, random.one_in(5) ? 255 : 9), raster);
    }
}

}  // namespace
}  // namespace metabuffer
