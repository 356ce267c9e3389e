#include "datapath/segment.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <vector>

#include "support/random_seed.h"
#include "support/rows.h"
#include "unit/datapath/painted_segment.h"

namespace metabuffer {
namespace {

using test::PaintedSegment;
using test::segment_row;
using test::Size;

void check_uses(const Segment& segment, const PaintedSegment& wanted) {
    for (std::size_t k = 0; k < wanted.first.size(); ++k) {
        INFO("segment pixel " << k);
        REQUIRE(wanted.last[k] >= 0);  // the row is valid: each of its pixels shows
        REQUIRE(segment.first_use(static_cast<std::int64_t>(k)) == wanted.first[k]);
        REQUIRE(segment.last_use(static_cast<std::int64_t>(k)) == wanted.last[k]);
    }
}

void check_coverage(const Segment& segment, const PaintedSegment& wanted, Size raster) {
    std::size_t position = 0;
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x, ++position) {
            INFO("raster pixel " << x << ", " << y);
            const bool covered = wanted.owner[position] >= 0;
            REQUIRE(segment.covers(x, y) == covered);
            if (covered) REQUIRE(segment.pixel_at(x, y) == wanted.owner[position]);
        }
    }
    CHECK_FALSE(segment.covers(-1, segment.top()));
    CHECK_FALSE(segment.covers(raster.width, segment.top()));
    CHECK_FALSE(segment.covers(segment.left(), -1));
    CHECK_FALSE(segment.covers(segment.left(), raster.height));
}

void check_bounds(const Segment& segment, const PaintedSegment& wanted, Size raster) {
    int left = raster.width;
    int right = 0;
    int top = raster.height;
    int bottom = 0;
    std::size_t position = 0;
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x, ++position) {
            if (wanted.owner[position] < 0) continue;
            left = std::min(left, x);
            right = std::max(right, x + 1);
            top = std::min(top, y);
            bottom = std::max(bottom, y + 1);
        }
    }
    CHECK(segment.left() == left);
    CHECK(segment.right() == right);
    CHECK(segment.top() == top);
    CHECK(segment.bottom() == bottom);
}

void check_releases(const Segment& segment, const PaintedSegment& wanted, Size raster) {
    const int positions = raster.width * raster.height;
    std::vector<int> releases_at(static_cast<std::size_t>(positions), 0);
    for (const std::int64_t last : wanted.last) ++releases_at[static_cast<std::size_t>(last)];
    std::int64_t released = 0;
    for (int position = 0; position <= positions; ++position) {
        INFO("after " << position << " raster pixels");
        REQUIRE(segment.released_before(position) == released);
        if (position < positions) released += releases_at[static_cast<std::size_t>(position)];
    }
    REQUIRE(released == segment.pixels());
    CHECK(segment.released_before(std::int64_t{positions} + 1) == released);
    CHECK(segment.released_before(-1) == 0);
}

void check_against_painting(const ViewportRow& row, Size raster) {
    INFO("raster " << raster.width << " x " << raster.height << ", sdx " << row.sdx << ", sdy " << row.sdy
                   << ", dx " << row.dx << ", dy " << row.dy << ", multiple " << row.dmultiple);
    const Segment segment(row, raster.width, raster.height);
    const PaintedSegment wanted(row, raster);
    CHECK(segment.row() == row);
    CHECK(segment.pixels() == static_cast<std::int64_t>(wanted.first.size()));
    check_bounds(segment, wanted, raster);
    check_uses(segment, wanted);
    check_coverage(segment, wanted, raster);
    check_releases(segment, wanted, raster);
}

TEST_CASE("segment: an unassigned one covers nothing and holds nothing") {
    const Segment segment;
    CHECK(segment.pixels() == 0);
    CHECK_FALSE(segment.covers(0, 0));
    CHECK(segment.released_before(0) == 0);
    CHECK(segment.released_before(1000) == 0);
}

TEST_CASE("segment: the paper's sample table agrees with painting") {
    check_against_painting(segment_row({75, 75}, {25, 25}), {100, 100});
    check_against_painting(segment_row({25, 75}, {0, 25}), {100, 100});
    check_against_painting(segment_row({75, 25}, {25, 0}), {100, 100});
    check_against_painting(segment_row({25, 25}, {0, 0}), {100, 100});
}

TEST_CASE("segment: a replicated pixel is kept until the last raster row that repeats its source row") {
    // Two source rows of three pixels, tripled, on a raster of 12 x 8 from (2, 1).
    const Segment segment(segment_row({3, 2}, {2, 1}, 3), 12, 8);
    CHECK(segment.first_use(0) == 1 * 12 + 2);
    CHECK(segment.last_use(0) == 3 * 12 + 4);
    CHECK(segment.first_use(5) == 4 * 12 + 8);
    CHECK(segment.last_use(5) == 6 * 12 + 10);
    CHECK(segment.released_before(3 * 12 + 4) == 0);
    CHECK(segment.released_before(3 * 12 + 5) == 1);
    CHECK(segment.released_before(48) == 3);
}

TEST_CASE("segment: a block cut by each edge of the raster is used only where it shows") {
    // One pixel blown up over the whole raster, and one of which a single corner pixel shows.
    check_against_painting(segment_row({1, 1}, {-3, -3}, 20), {10, 6});
    check_against_painting(segment_row({1, 1}, {-19, -19}, 20), {10, 6});
    check_against_painting(segment_row({1, 1}, {9, 5}, 20), {10, 6});
    check_against_painting(segment_row({1, 1}, {-254, -254}, 255), {5, 4});
    check_against_painting(segment_row({2, 2}, {-254, -254}, 255), {5, 4});
}

TEST_CASE("segment: agrees with painting for every row on a small raster") {
    const Size raster{5, 3};
    for (int multiple = 1; multiple <= 4; ++multiple) {
        for (int dx = 1 - multiple; dx < raster.width; ++dx) {
            for (int sdx = 1; dx + (sdx - 1) * multiple < raster.width; ++sdx) {
                for (int dy = 1 - multiple; dy < raster.height; ++dy) {
                    for (int sdy = 1; dy + (sdy - 1) * multiple < raster.height; ++sdy) {
                        check_against_painting(segment_row({sdx, sdy}, {dx, dy}, multiple), raster);
                    }
                }
            }
        }
    }
}

TEST_CASE("segment: agrees with painting for random rows, clipped on any side, of any multiple") {
    const auto seed = test::random_seed(109);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 400; ++trial) {
        const Size raster{random.between(1, 48), random.between(1, 32)};
        const int largest = random.one_in(5) ? 255 : random.one_in(2) ? 1 : 9;
        const int multiple = random.between(1, largest);
        check_against_painting(test::random_row(random, raster, raster, 1, multiple), raster);
    }
}

TEST_CASE("segment: the largest raster overflows nothing") {
    const int side = 16384;
    const std::int64_t area = std::int64_t{side} * side;
    const Segment whole(segment_row({side, side}, {0, 0}), side, side);
    CHECK(whole.pixels() == area);
    for (const std::int64_t k : {std::int64_t{0}, std::int64_t{side}, area / 2 + 77, area - 1}) {
        CHECK(whole.first_use(k) == k);
        CHECK(whole.last_use(k) == k);
        CHECK(whole.released_before(k) == k);
        CHECK(whole.released_before(k + 1) == k + 1);
    }
    // 65 source pixels of 255 from -100: the last begins at 16220 and is cut at the edge.
    const Segment replicated(segment_row({65, 65}, {-100, -100}, 255), side, side);
    const std::int64_t pixels = 4225;
    CHECK(replicated.pixels() == pixels);
    CHECK(replicated.first_use(pixels - 1) == std::int64_t{16220} * side + 16220);
    CHECK(replicated.last_use(pixels - 1) == area - 1);
    CHECK(replicated.released_before(area - 1) == pixels - 1);
    CHECK(replicated.released_before(area) == pixels);
}

TEST_CASE("segment: the largest one has a row and a column more than the raster on each side") {
    CHECK(most_segment_pixels(100, 50) == 102 * 52);
    CHECK(most_segment_pixels(1, 1) == 9);
}

}  // namespace
}  // namespace metabuffer
