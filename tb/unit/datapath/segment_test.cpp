#include "datapath/segment.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "datapath/composer_buffer.h"
#include "support/painted_segment.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "unit/datapath/part_state.h"

namespace metabuffer::segment_test {
namespace {

using test::PaintedSegment;
using test::segment_row;
using test::Size;

void agree(const char* what, std::int64_t at, std::int64_t found, std::int64_t due) {
    if (found != due) FAIL(what << " of " << at << " is " << found << ", not " << due);
}

void check_bounds(const Segment& segment, const PaintedSegment& painted, Size raster) {
    int left = raster.width, right = 0, top = raster.height, bottom = 0;
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x) {
            if (painted.owner(std::int64_t{y} * raster.width + x) == PaintedSegment::kNone) continue;
            left = std::min(left, x);
            right = std::max(right, x + 1);
            top = std::min(top, y);
            bottom = std::max(bottom, y + 1);
        }
    }
    agree("left", 0, segment.left(), left);
    agree("right", 0, segment.right(), right);
    agree("top", 0, segment.top(), top);
    agree("bottom", 0, segment.bottom(), bottom);
    CHECK_FALSE(segment.covers(-1, top));
    CHECK_FALSE(segment.covers(raster.width, top));
    CHECK_FALSE(segment.covers(left, -1));
    CHECK_FALSE(segment.covers(left, raster.height));
}

void check_pixels(const Segment& segment, const PaintedSegment& painted) {
    REQUIRE(segment.pixels() == static_cast<std::int64_t>(painted.first.size()));
    const int width = segment.row().sdx;
    std::vector<std::int64_t> positions(painted.first.size());  // of which each pixel is the newest
    for (const std::int64_t newest : painted.newest) {
        if (newest != PaintedSegment::kNone) ++positions[static_cast<std::size_t>(newest)];
    }
    for (std::int64_t k = 0; k < segment.pixels(); ++k) {
        const auto at = static_cast<std::size_t>(k);
        const std::int64_t first = painted.first[at];
        agree("first use", k, segment.first_use(k),
              first == PaintedSegment::kNever ? segment.never() : first);
        agree("last use", k, segment.last_use(k), painted.last[at]);
        const Segment::Range columns = segment.newest_columns(static_cast<int>(k % width));
        const Segment::Range rows = segment.newest_rows(static_cast<int>(k / width));
        agree("positions of which it is the newest", k,
              std::int64_t{columns.end - columns.begin} * (rows.end - rows.begin), positions[at]);
    }
    agree("unused pixels", 0, segment.has_unused_pixels(),
          std::count(painted.used.begin(), painted.used.end(), false) > 0);
    agree("pixels skipped", 0, segment.skipped_pixels(), painted.skipped);
}

void check_window(std::int64_t position, const BlendWindow<std::int64_t>& window, const RasterStep& due) {
    const auto neighbour = [](bool there, std::int64_t pixel) { return there ? pixel : Segment::kNoPixel; };
    const bool beside = due.beside != 0;
    const bool across = due.across != 0;
    agree("pixel", position, window.own, due.pixel);
    agree("pixel beside", position, window.beside, neighbour(beside, due.pixel + due.beside));
    agree("pixel across", position, window.across, neighbour(across, due.pixel + due.across));
    agree("diagonal pixel", position, window.diagonal,
          neighbour(beside && across, due.pixel + due.beside + due.across));
}

void check_against_painting(const ViewportRow& row, Size raster, Smoothing smoothing) {
    INFO("raster " << raster.width << " x " << raster.height << ", sdx " << row.sdx << ", sdy " << row.sdy
                   << ", dx " << row.dx << ", dy " << row.dy << ", multiple " << row.dmultiple
                   << ", smoothed " << (smoothing == Smoothing::kBilinear));
    const Segment segment(row, raster.width, raster.height, smoothing);
    const PaintedSegment painted(row, raster, smoothing);
    REQUIRE(segment.row() == row);
    REQUIRE(segment.smooths() == (smoothing == Smoothing::kBilinear && row.dmultiple > 1));
    check_bounds(segment, painted, raster);
    check_pixels(segment, painted);

    SegmentWalker walker(segment, true, raster.width, raster.height);
    std::int64_t released = painted.skipped;
    for (std::int64_t position = 0; position < segment.never(); ++position) {
        const auto x = static_cast<int>(position % raster.width);
        const auto y = static_cast<int>(position / raster.width);
        const RasterStep& due = painted.steps[static_cast<std::size_t>(position)];
        agree("released pixels", position, segment.released_before(position), released);
        agree("coverage", position, segment.covers(x, y), due.covered);
        agree("end of the walk", position, walker.done(), 0);
        agree("column", position, walker.x(), x);
        agree("row", position, walker.y(), y);
        if (!(walker.step() == due)) FAIL("position " << position << " does not show " << due.pixel);
        if (due.covered) {
            const std::int64_t newest = painted.newest[static_cast<std::size_t>(position)];
            agree("pixel", position, segment.pixel_at(x, y), due.pixel);
            agree("newest pixel", position, segment.newest_at(x, y), newest);
            agree("newest pixel walked over", position, walker.step().newest(), newest);
            check_window(position, segment.window_at(x, y), due);
            check_window(position, walker.step().window(), due);
            agree("source column", position, walker.column(), due.pixel % row.sdx);
            agree("source row", position, walker.row_first_pixel(), due.pixel / row.sdx * row.sdx);
            agree("repetition", position, walker.row_phase(), (y - row.dy) % row.dmultiple);
            released = std::max(released, walker.released() + 1);
            // Two source rows and a pixel fit into every buffer. A position that needed more would wait for ever.
            if (newest - segment.released_before(position) > 2 * row.sdx)
                FAIL("too much is needed at " << position);
        }
        agree("pixels released on the way", position, released,
              painted.released[static_cast<std::size_t>(position)]);
        walker.advance();
    }
    REQUIRE(walker.done());
    REQUIRE(walker.step() == RasterStep{});
    REQUIRE(segment.released_before(segment.never()) == segment.pixels());
}

bool is_valid(const ViewportRow& row, Size raster, Smoothing smoothing) {
    ViewportLimits limits;
    limits.displays = 1;
    limits.image_width_pixels = limits.image_height_pixels = 1000;
    limits.raster_width_pixels = raster.width;
    limits.raster_height_pixels = raster.height;
    limits.buffer_pixels = 1 << 20;
    limits.ready_space_pixels = 1;
    limits.smoothing = smoothing;
    return row_defect(row, limits) == RowDefect::kNone;
}

TEST_CASE("segment: a row shows, needs and releases its pixels as they are painted") {
    SECTION("the paper's sample table") {
        for (const auto& [size, place] : {std::pair<Size, test::Position>{{75, 75}, {25, 25}},
                                          {{25, 75}, {0, 25}},
                                          {{75, 25}, {25, 0}},
                                          {{25, 25}, {0, 0}}}) {
            check_against_painting(segment_row(size, place), {100, 100}, Smoothing::kReplicate);
        }
    }
    SECTION("every row that is valid on a small raster") {
        constexpr Size kRaster{5, 4};
        int rows = 0;
        for (int m = 1; m <= 5; ++m) {
            for (int sdx = 1; sdx <= 6; ++sdx) {
                for (int dx = -2 * m; dx < kRaster.width; ++dx) {
                    // The axes are independent, so one at a time goes through all its positions.
                    for (const auto& [sdy, dy] :
                         {std::pair{1, 0}, std::pair{3, 1 - m}, std::pair{3, 1 - 2 * m}}) {
                        for (const Smoothing smoothing : {Smoothing::kReplicate, Smoothing::kBilinear}) {
                            const ViewportRow row = segment_row({sdx, sdy}, {dx, dy}, m);
                            if (!is_valid(row, kRaster, smoothing)) continue;
                            check_against_painting(row, kRaster, smoothing);
                            check_against_painting(segment_row({sdy, sdx}, {dy, dx}, m),
                                                   {kRaster.height, kRaster.width}, smoothing);
                            ++rows;
                        }
                    }
                }
            }
        }
        CHECK(rows > 200);
    }
    SECTION("random rows") {
        const auto seed = test::random_seed(109);
        INFO("METABUFFER_SEED=" << seed);
        test::Random random(seed);
        for (int trial = 0; trial < 600; ++trial) {
            const bool large = random.one_in(6);
            const Size raster{random.between(1, large ? 48 : 16), random.between(1, large ? 32 : 12)};
            const int largest = random.one_in(8) ? 255 : 9;
            check_against_painting(test::random_valid_row(random, raster, largest), raster,
                                   Smoothing::kReplicate);
            check_against_painting(test::random_smoothed_row(random, raster, largest), raster,
                                   Smoothing::kBilinear);
        }
    }
}

TEST_CASE("segment: an unassigned one covers nothing, holds nothing, and a walk without one covers nothing") {
    const Segment segment;
    CHECK(segment.pixels() == 0);
    CHECK_FALSE(segment.covers(0, 0));
    CHECK(segment.released_before(0) == 0);
    CHECK(segment.released_before(1000) == 0);
    CHECK(SegmentWalker().done());
    SegmentWalker walker(Segment(), false, 5, 3);
    for (int position = 0; position < 15; ++position) {
        REQUIRE_FALSE(walker.done());
        REQUIRE_FALSE(walker.covered());
        REQUIRE_FALSE(walker.replayed());
        walker.advance();
    }
    CHECK(walker.done());
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
    // It has a row and a column more than the raster on each side, at most.
    CHECK(most_segment_pixels(100, 50) == 102 * 52);
    CHECK(most_segment_pixels(1, 1) == 9);
}

TEST_CASE("segment: a waveform shows where the walk is and what it walks over") {
    const Size raster{10, 8};
    SegmentWalker walker(Segment(segment_row({4, 3}, {-1, 2}, 3), raster.width, raster.height), true,
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

}  // namespace
}  // namespace metabuffer::segment_test
