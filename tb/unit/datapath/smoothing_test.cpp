#include "datapath/smoothing.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "datapath/composer_buffer.h"
#include "datapath/segment.h"
#include "datapath/span.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "unit/datapath/painted_segment.h"

namespace metabuffer::smoothing_test {
namespace {

using test::PaintedSegment;
using test::Size;

TEST_CASE("smoothing: the counted weights are the quotients, for every multiple and every start") {
    for (int m = 1; m <= kMaximumMultiple; ++m) {
        for (int start = 0; start < m; ++start) {
            BlendCounter counter(m, start);
            for (int step = 0; step < 2 * m + 1; ++step) {
                const int i = (start + step) % m;
                const int off_centre = 2 * i + 1 - m;
                const int side = off_centre < 0 ? -1 : (off_centre > 0 ? 1 : 0);
                if (counter.weight() != 256 * std::abs(off_centre) / (2 * m) || counter.side() != side ||
                    counter.phase() != i) {
                    FAIL("multiple " << m << ", start " << start << ", step " << step);
                }
                counter.step();
            }
        }
    }
}

/// The formula itself, in floating point, which is exact here.
Pixel mixed(const BlendWindow<Pixel>& window, int x, int y, Composition composition, std::uint32_t far_z) {
    const bool key = composition == Composition::kZAlphaKey;
    const auto or_own = [&](Pixel pixel) {
        return pixel.z() == far_z || (key && pixel.a() == 0) ? window.own : pixel;
    };
    const auto channel = [&](auto of) {
        const double sum =
            of(window.own) * (256.0 - x) * (256.0 - y) + of(or_own(window.beside)) * x * (256.0 - y) +
            of(or_own(window.across)) * (256.0 - x) * y + of(or_own(window.diagonal)) * 1.0 * x * y;
        return static_cast<std::uint8_t>(std::floor((sum + 32768.0) / 65536.0));
    };
    if (key && window.own.a() == 0) return window.own;
    return {channel([](Pixel p) { return p.r(); }), channel([](Pixel p) { return p.g(); }),
            channel([](Pixel p) { return p.b(); }), channel([](Pixel p) { return p.a(); }), window.own.z()};
}

TEST_CASE("smoothing: four pixels are mixed as the formula says, one by one and in spans") {
    const std::uint64_t seed = test::random_seed(20261101);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    constexpr std::size_t kCount = 61;
    for (int trial = 0; trial < 600; ++trial) {
        const Composition composition = test::one_of(random, kCompositionTable).value;
        const std::uint32_t far = far_z(test::one_of(random, kDepthFormatTable).value);
        const int y = random.between(0, 127);
        std::vector<BlendWindow<Pixel>> windows(kCount);
        std::vector<std::uint32_t> weights(kCount);
        std::vector<std::uint32_t> argb[4];
        std::vector<std::uint32_t> z[4];
        for (std::size_t i = 0; i < kCount; ++i) {
            BlendWindow<Pixel>& window = windows[i];
            std::size_t plane = 0;
            for (Pixel* const pixel : {&window.own, &window.beside, &window.across, &window.diagonal}) {
                *pixel = test::corner_pixel(random);
                argb[plane].push_back(static_cast<std::uint32_t>(pixel->word()));
                z[plane++].push_back(pixel->z());
            }
            weights[i] = static_cast<std::uint32_t>(random.between(0, 127));
        }
        const auto span = [&](std::size_t plane) { return PixelSpan{argb[plane].data(), z[plane].data()}; };
        std::vector<std::uint32_t> out(kCount);
        blend_span(composition, far, {span(0), span(1), span(2), span(3), weights.data(), y}, out.data(),
                   kCount);
        for (std::size_t i = 0; i < kCount; ++i) {
            const auto x = static_cast<int>(weights[i]);
            const Pixel wanted = mixed(windows[i], x, y, composition, far);
            REQUIRE(blend(windows[i], x, y, composition, far) == wanted);
            REQUIRE(out[i] == static_cast<std::uint32_t>(wanted.word()));
        }
    }
}

void check_against_painting(const ViewportRow& row, Size raster) {
    INFO("raster " << raster.width << " x " << raster.height << ", sdx " << row.sdx << ", sdy " << row.sdy
                   << ", dx " << row.dx << ", dy " << row.dy << ", multiple " << row.dmultiple);
    const PaintedSegment wanted(row, raster, Smoothing::kBilinear);
    const Segment segment(row, raster.width, raster.height, Smoothing::kBilinear);
    REQUIRE(segment.smooths() == (row.dmultiple > 1));
    bool unused = false;
    for (std::int64_t k = 0; k < segment.pixels(); ++k) {
        const std::int64_t first = wanted.first[static_cast<std::size_t>(k)];
        const std::int64_t last = wanted.last[static_cast<std::size_t>(k)];
        if (segment.first_use(k) != (first == PaintedSegment::kNever ? segment.never() : first)) {
            FAIL("pixel " << k << " is needed first at " << segment.first_use(k) << ", not " << first);
        }
        if (segment.last_use(k) != last) {
            FAIL("pixel " << k << " is released at " << segment.last_use(k) << ", not " << last);
        }
        unused = unused || wanted.shown[static_cast<std::size_t>(k)] == PaintedSegment::kNever;
    }
    if (segment.has_unused_pixels()) REQUIRE(unused);
    SegmentWalker walker(segment, true, raster.width, raster.height);
    std::int64_t released = std::count(wanted.last.begin(), wanted.last.end(), -1);
    REQUIRE(segment.skipped_pixels() == released);
    for (std::int64_t position = 0; position < segment.never(); ++position) {
        const auto x = static_cast<int>(position % raster.width);
        const auto y = static_cast<int>(position / raster.width);
        const auto at = static_cast<std::size_t>(position);
        const bool covered = wanted.owner[at] != PaintedSegment::kNone;
        const bool agrees = walker.covered() == covered && segment.covers(x, y) == covered &&
                            segment.released_before(position) == released;
        if (!agrees)
            FAIL("position " << position << ": " << segment.released_before(position) << " released");
        if (covered) {
            const BlendWindow<std::int64_t> by_division = segment.window_at(x, y);
            const BlendWindow<std::int64_t> counted = walker.step().window();
            const bool same_window = by_division.own == counted.own && by_division.beside == counted.beside &&
                                     by_division.across == counted.across &&
                                     by_division.diagonal == counted.diagonal;
            const auto weight = [&](int distance) {
                return 256 * std::abs(2 * (distance % row.dmultiple) + 1 - row.dmultiple) /
                       (2 * row.dmultiple);
            };
            const int weight_x = counted.beside == Segment::kNoPixel ? 0 : weight(x - row.dx);
            const int weight_y = counted.across == Segment::kNoPixel ? 0 : weight(y - row.dy);
            if (!same_window || counted.own != wanted.owner[at] ||
                walker.step().newest() != wanted.newest[at] || segment.newest_at(x, y) != wanted.newest[at] ||
                walker.step().weight_x != weight_x || walker.step().weight_y != weight_y) {
                FAIL("position " << position << ": own " << counted.own << ", newest "
                                 << walker.step().newest() << ", not " << wanted.newest[at]);
            }
            if (walker.released() != Segment::kNoPixel) released = std::max(released, walker.released() + 1);
        }
        const auto due = static_cast<std::int64_t>(
            std::count_if(wanted.last.begin(), wanted.last.end(),
                          [position](std::int64_t last) { return last <= position; }));
        if (released != due) FAIL("position " << position << " has released " << released << ", not " << due);
        walker.advance();
    }
    REQUIRE(segment.released_before(segment.never()) == segment.pixels());
    for (int i = 0; i < row.sdx; ++i) {
        for (int j = 0; j < row.sdy; ++j) {
            const Segment::Range columns = segment.newest_columns(i);
            const Segment::Range rows = segment.newest_rows(j);
            const std::int64_t k = std::int64_t{j} * row.sdx + i;
            const auto block =
                static_cast<std::int64_t>(columns.end - columns.begin) * (rows.end - rows.begin);
            REQUIRE(std::count(wanted.newest.begin(), wanted.newest.end(), k) == block);
        }
    }
}

ViewportLimits limits_of(Size raster) {
    ViewportLimits limits;
    limits.displays = 1;
    limits.image_width_pixels = limits.image_height_pixels = 1000;
    limits.raster_width_pixels = raster.width;
    limits.raster_height_pixels = raster.height;
    limits.buffer_pixels = 1 << 20;
    limits.ready_space_pixels = 1;
    limits.smoothing = Smoothing::kBilinear;
    return limits;
}

TEST_CASE("smoothing: needs and releases agree with painting for every valid row on a small raster") {
    constexpr Size kRaster{5, 4};
    const ViewportLimits limits = limits_of(kRaster);
    int rows = 0;
    for (int m = 1; m <= 5; ++m) {
        for (int sdx = 1; sdx <= 6; ++sdx) {
            for (int dx = -2 * m; dx < kRaster.width; ++dx) {
                // The axes are independent, so one at a time goes through all its positions.
                for (const auto& [sdy, dy] :
                     {std::pair{1, 0}, std::pair{3, 1 - m}, std::pair{3, 1 - 2 * m}}) {
                    const ViewportRow row = test::segment_row({sdx, sdy}, {dx, dy}, m);
                    if (row_defect(row, limits) != RowDefect::kNone) continue;
                    check_against_painting(row, kRaster);
                    check_against_painting(test::segment_row({sdy, sdx}, {dy, dx}, m),
                                           {kRaster.height, kRaster.width});
                    ++rows;
                }
            }
        }
    }
    CHECK(rows > 100);
}

TEST_CASE("smoothing: needs and releases agree with painting for random rows") {
    const std::uint64_t seed = test::random_seed(20261102);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    int outside = 0;
    for (int checked = 0; checked < 3000;) {
        const Size raster{random.between(1, 16), random.between(1, 12)};
        const int m = random.one_in(8) ? random.between(1, 40) : random.between(1, 7);
        const ViewportRow row = test::segment_row(
            {random.between(1, 9), random.between(1, 9)},
            {random.between(-2 * m, raster.width), random.between(-2 * m, raster.height)}, m);
        if (row_defect(row, limits_of(raster)) != RowDefect::kNone) continue;
        outside += row.dx <= -m || row.dy <= -m ? 1 : 0;
        check_against_painting(row, raster);
        ++checked;
    }
    CHECK(outside > 100);
}

TEST_CASE("smoothing: two source rows and a pixel are never too little for a raster position") {
    // The buffer rule: with two source rows and the ready space, a composer takes slots until it holds two source rows
    // and a pixel more. What a position needs must fit into that, or the column would wait for ever.
    const std::uint64_t seed = test::random_seed(20261103);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int checked = 0; checked < 3000;) {
        const Size raster{random.between(1, 16), random.between(1, 16)};
        const int m = random.between(2, 7);
        const ViewportRow row = test::segment_row(
            {random.between(1, 9), random.between(1, 9)},
            {random.between(-2 * m, raster.width), random.between(-2 * m, raster.height)}, m);
        if (row_defect(row, limits_of(raster)) != RowDefect::kNone) continue;
        const Segment segment(row, raster.width, raster.height, Smoothing::kBilinear);
        for (int y = segment.top(); y < segment.bottom(); ++y) {
            for (int x = segment.left(); x < segment.right(); ++x) {
                const std::int64_t held =
                    segment.newest_at(x, y) + 1 - segment.released_before(std::int64_t{y} * raster.width + x);
                if (held > 2 * row.sdx + 1) FAIL("position " << x << ", " << y << " needs " << held);
            }
        }
        ++checked;
    }
}

}  // namespace
}  // namespace metabuffer::smoothing_test
