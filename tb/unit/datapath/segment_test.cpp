#include "datapath/segment.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <limits>
#include <vector>

#include "random_seed.h"

namespace metabuffer {
namespace {

struct RasterSize {
    int width;
    int height;
};

ViewportRow row_at(int dx, int dy, int sdx, int sdy, int dmultiple) {
    ViewportRow row;
    row.dcomp = 1;
    row.sdx = static_cast<std::uint16_t>(sdx);
    row.sdy = static_cast<std::uint16_t>(sdy);
    row.dx = static_cast<std::int16_t>(dx);
    row.dy = static_cast<std::int16_t>(dy);
    row.dmultiple = static_cast<std::uint16_t>(dmultiple);
    return row;
}

/// What the raster shows when each source pixel is painted repetition by repetition.
struct Painted {
    std::vector<std::int64_t> owner;  ///< segment pixel at each raster position, -1 for none
    std::vector<std::int64_t> first;  ///< of each segment pixel
    std::vector<std::int64_t> last;
};

Painted painted(const ViewportRow& row, RasterSize raster) {
    const std::size_t pixels = std::size_t{row.sdx} * row.sdy;
    Painted result;
    result.owner.assign(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height), -1);
    result.first.assign(pixels, std::numeric_limits<std::int64_t>::max());
    result.last.assign(pixels, -1);
    std::size_t k = 0;
    for (int j = 0; j < row.sdy; ++j) {
        for (int i = 0; i < row.sdx; ++i, ++k) {
            for (int repetition = 0; repetition < row.dmultiple * row.dmultiple; ++repetition) {
                const int x = row.dx + i * row.dmultiple + repetition % row.dmultiple;
                const int y = row.dy + j * row.dmultiple + repetition / row.dmultiple;
                if (x < 0 || x >= raster.width || y < 0 || y >= raster.height) continue;
                const std::int64_t position = std::int64_t{y} * raster.width + x;
                result.owner[static_cast<std::size_t>(position)] = static_cast<std::int64_t>(k);
                result.first[k] = std::min(result.first[k], position);
                result.last[k] = std::max(result.last[k], position);
            }
        }
    }
    return result;
}

void check_uses(const Segment& segment, const Painted& wanted) {
    for (std::size_t k = 0; k < wanted.first.size(); ++k) {
        INFO("segment pixel " << k);
        REQUIRE(wanted.last[k] >= 0);  // the row is valid: each of its pixels shows
        REQUIRE(segment.first_use(static_cast<std::int64_t>(k)) == wanted.first[k]);
        REQUIRE(segment.last_use(static_cast<std::int64_t>(k)) == wanted.last[k]);
    }
}

void check_coverage(const Segment& segment, const Painted& wanted, RasterSize raster) {
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

void check_bounds(const Segment& segment, const Painted& wanted, RasterSize raster) {
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

void check_releases(const Segment& segment, const Painted& wanted, RasterSize raster) {
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

void check_against_painting(const ViewportRow& row, RasterSize raster) {
    INFO("raster " << raster.width << " x " << raster.height << ", sdx " << row.sdx << ", sdy " << row.sdy
                   << ", dx " << row.dx << ", dy " << row.dy << ", multiple " << row.dmultiple);
    const Segment segment(row, raster.width, raster.height);
    const Painted wanted = painted(row, raster);
    CHECK(segment.row() == row);
    CHECK(segment.pixels() == static_cast<std::int64_t>(wanted.first.size()));
    check_bounds(segment, wanted, raster);
    check_uses(segment, wanted);
    check_coverage(segment, wanted, raster);
    check_releases(segment, wanted, raster);
}

/// A position and a length on one axis such that the first and the last source pixel show at least in part.
struct Extent {
    int destination;
    int count;
};

Extent random_extent(test::Random& random, int raster, int multiple) {
    const int destination = random.between(1 - multiple, raster - 1);
    int most = 1;
    while (destination + most * multiple < raster) ++most;
    return {destination, random.one_in(3) ? most : random.between(1, most)};
}

TEST_CASE("segment: an unassigned one covers nothing and holds nothing") {
    const Segment segment;
    CHECK(segment.pixels() == 0);
    CHECK_FALSE(segment.covers(0, 0));
    CHECK(segment.released_before(0) == 0);
    CHECK(segment.released_before(1000) == 0);
}

TEST_CASE("segment: the paper's sample table agrees with painting") {
    check_against_painting(row_at(25, 25, 75, 75, 1), {100, 100});
    check_against_painting(row_at(0, 25, 25, 75, 1), {100, 100});
    check_against_painting(row_at(25, 0, 75, 25, 1), {100, 100});
    check_against_painting(row_at(0, 0, 25, 25, 1), {100, 100});
}

TEST_CASE("segment: a replicated pixel is kept until the last raster row that repeats its source row") {
    // Two source rows of three pixels, tripled, on a raster of 12 x 8 from (2, 1).
    const Segment segment(row_at(2, 1, 3, 2, 3), 12, 8);
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
    check_against_painting(row_at(-3, -3, 1, 1, 20), {10, 6});
    check_against_painting(row_at(-19, -19, 1, 1, 20), {10, 6});
    check_against_painting(row_at(9, 5, 1, 1, 20), {10, 6});
    check_against_painting(row_at(-254, -254, 1, 1, 255), {5, 4});
    check_against_painting(row_at(-254, -254, 2, 2, 255), {5, 4});
}

TEST_CASE("segment: agrees with painting for every row on a small raster") {
    const RasterSize raster{5, 3};
    for (int multiple = 1; multiple <= 4; ++multiple) {
        for (int dx = 1 - multiple; dx < raster.width; ++dx) {
            for (int sdx = 1; dx + (sdx - 1) * multiple < raster.width; ++sdx) {
                for (int dy = 1 - multiple; dy < raster.height; ++dy) {
                    for (int sdy = 1; dy + (sdy - 1) * multiple < raster.height; ++sdy) {
                        check_against_painting(row_at(dx, dy, sdx, sdy, multiple), raster);
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
        const RasterSize raster{random.between(1, 48), random.between(1, 32)};
        const int largest = random.one_in(5) ? 255 : random.one_in(2) ? 1 : 9;
        const int multiple = random.between(1, largest);
        const Extent x = random_extent(random, raster.width, multiple);
        const Extent y = random_extent(random, raster.height, multiple);
        check_against_painting(row_at(x.destination, y.destination, x.count, y.count, multiple), raster);
    }
}

TEST_CASE("segment: the largest raster overflows nothing") {
    const int side = 16384;
    const std::int64_t area = std::int64_t{side} * side;
    const Segment whole(row_at(0, 0, side, side, 1), side, side);
    CHECK(whole.pixels() == area);
    for (const std::int64_t k : {std::int64_t{0}, std::int64_t{side}, area / 2 + 77, area - 1}) {
        CHECK(whole.first_use(k) == k);
        CHECK(whole.last_use(k) == k);
        CHECK(whole.released_before(k) == k);
        CHECK(whole.released_before(k + 1) == k + 1);
    }
    // 65 source pixels of 255 from -100: the last begins at 16220 and is cut at the edge.
    const Segment replicated(row_at(-100, -100, 65, 65, 255), side, side);
    const std::int64_t pixels = 4225;
    CHECK(replicated.pixels() == pixels);
    CHECK(replicated.first_use(pixels - 1) == std::int64_t{16220} * side + 16220);
    CHECK(replicated.last_use(pixels - 1) == area - 1);
    CHECK(replicated.released_before(area - 1) == pixels - 1);
    CHECK(replicated.released_before(area) == pixels);
}

}  // namespace
}  // namespace metabuffer
