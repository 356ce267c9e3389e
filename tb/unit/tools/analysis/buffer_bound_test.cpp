#include "tools/analysis/buffer_bound.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "datapath/segment.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "tools/analysis/bus_table.h"

using namespace metabuffer;
using namespace metabuffer::analysis;

namespace {

ViewportRow random_row(test::Random& random, int raster, int image) {
    return test::random_row(random, {image, image}, {raster, raster}, 1, random.between(1, 4));
}

/// One renderer, one display, one row.
Scenario one_composer(const ViewportRow& row, int raster, int image) {
    return test::with_renderer(test::small_scenario(raster, raster),
                               test::renderer_of({PixelImage(image, image)}, {row}));
}

}  // namespace

TEST_CASE("no window of a raster releases more than rate and burst say", "[analysis][random]") {
    test::Random random(test::random_seed(5));
    for (int round = 0; round < 300; ++round) {
        const int raster = random.between(4, 14);
        const bool smoothed = round % 3 > 0;
        const Segment segment(smoothed ? test::random_smoothed_row(random, {raster, raster}, 6)
                                       : random_row(random, raster, 14),
                              raster, raster, smoothed ? Smoothing::kBilinear : Smoothing::kReplicate);
        const ReleaseCurve curve(segment, raster);
        const std::int64_t positions = std::int64_t{raster} * raster;
        for (std::int64_t from = 0; from <= positions; ++from) {
            for (std::int64_t until = from; until <= positions; ++until) {
                const auto released =
                    static_cast<double>(segment.released_before(until) - segment.released_before(from));
                const std::int64_t inside =
                    std::clamp(until, curve.first, curve.last) - std::clamp(from, curve.first, curve.last);
                const double most = curve.rate * static_cast<double>(inside) + curve.burst;
                if (released > most + 1e-9) FAIL_CHECK("from " << from << " until " << until);
            }
        }
    }
}

TEST_CASE("a buffer for the whole segment is always safe and less than the legal size never",
          "[analysis][random]") {
    test::Random random(test::random_seed(6));
    for (int round = 0; round < 100; ++round) {
        Scenario scenario = one_composer(random_row(random, 30, 40), 30, 40);
        scenario.bus.width_bits = 16 << random.between(0, 5);
        scenario.bus.burst_pixels = random.between(1, 40);
        scenario.bus.arbitration = test::one_of(random, kArbitrationTable).value;
        scenario.composer.ready_space_pixels =
            std::max(in_flight_pixels(scenario.bus, scenario.memory), random.between(1, 40));
        const BufferBound bound(scenario);
        const ViewportRow& row = scenario.renderers.front().frames.front().table.front();
        const std::int64_t ready = scenario.composer.ready_space_pixels;
        CHECK(bound.smallest_legal_pixels() == ready + (row.dmultiple > 1 ? row.sdx : 0));
        CHECK(bound.whole_segment_pixels() ==
              std::max(bound.smallest_legal_pixels(), std::int64_t{row.sdx} * row.sdy + ready - 1));
        CHECK(bound.is_safe(bound.whole_segment_pixels()));
        CHECK_FALSE(bound.is_safe(bound.smallest_legal_pixels() - 1));
        const std::optional<BufferBound::Result> found = bound.find();
        REQUIRE(found.has_value() == (arbitration_row(scenario.bus.arbitration).proof != BufferProof::kNone));
        if (!found) continue;
        CHECK(bound.is_safe(found->pixels));
        CHECK(found->pixels <= bound.whole_segment_pixels());
        CHECK(found->renderer.has_value() == (found->pixels > bound.smallest_legal_pixels()));
    }
}

TEST_CASE("under a policy for which nothing is proved only a buffer for the whole segment is safe",
          "[analysis][random]") {
    test::Random random(test::random_seed(7));
    for (const ArbitrationRow& row : kArbitrationTable) {
        INFO(row.name);
        ArbitrationRow unproved = row;
        unproved.proof = BufferProof::kNone;
        int less_with_a_proof = 0;
        for (int round = 0; round < 20; ++round) {
            Scenario scenario = one_composer(random_row(random, 30, 40), 30, 40);
            scenario.bus.arbitration = row.value;
            scenario.composer.ready_space_pixels = in_flight_pixels(scenario.bus, scenario.memory);
            scenario.frames = random.between(1, 2);
            const BufferBound bound(scenario, MachineFigures(scenario, unproved));
            CHECK_FALSE(bound.find().has_value());
            const std::int64_t whole = bound.whole_segment_pixels();
            CHECK(bound.is_safe(whole));
            if (whole == bound.smallest_legal_pixels()) continue;
            CHECK_FALSE(bound.is_safe(whole - 1));
            less_with_a_proof += BufferBound(scenario).is_safe(whole - 1) ? 1 : 0;
        }
        CHECK((less_with_a_proof > 0) == (row.proof != BufferProof::kNone));
    }
}

TEST_CASE("a lone composer on a bus of exactly its rate needs a few pixels beside its ready space",
          "[analysis]") {
    const int size = 100;
    Scenario scenario = one_composer({1, 0, 0, size, size, 0, 0, 1}, size, size);
    scenario.memory.page_miss_cycles = 0;
    scenario.bus.burst_pixels = 4;
    scenario.composer.ready_space_pixels = 4;
    CHECK(BufferBound(scenario).find()->pixels <= 8);
    // Six clocks for each page of 512: 20 misses of the frame's 10,000 clocks, all of which must be prefetched.
    scenario.memory.page_miss_cycles = 6;
    const std::int64_t pixels = BufferBound(scenario).find()->pixels;
    CHECK(pixels >= 19 * 6);
    CHECK(pixels <= 20 * 6 + 16);
}

TEST_CASE(
    "a lone composer that smooths, on a bus of exactly its rate, needs a few pixels beside two source rows",
    "[analysis]") {
    const int size = 64;
    const int ready = 9;
    Scenario scenario = one_composer({1, 0, 0, size / 2, size / 2, 0, 0, 2}, size, size);
    scenario.bus.width_bits = 16;  // four clocks a pixel, and a pixel is four raster pixels
    scenario.bus.burst_pixels = 8;
    scenario.composer.ready_space_pixels = ready;
    scenario.composer.smoothing = Smoothing::kBilinear;
    scenario.memory.page_miss_cycles = 0;
    CHECK(BufferBound(scenario).smallest_legal_pixels() == ready + size);
    CHECK(BufferBound(scenario).find()->pixels == ready + size);
    // Two pages of 512 words: while they are opened, the raster takes three pixels.
    scenario.memory.page_miss_cycles = 6;
    const std::int64_t pixels = BufferBound(scenario).find()->pixels;
    CHECK(pixels >= ready + size + 3);
    CHECK(pixels <= ready + size + 4);
}

TEST_CASE("a slower bus never has a smaller bound by much and a much faster one needs the legal size",
          "[analysis]") {
    const int size = 60;
    std::int64_t slower = 0;
    for (const int width_bits : {16, 32, 64, 128, 512}) {
        Scenario scenario = one_composer({1, 0, 0, size, size, 0, 0, 1}, size, size);
        scenario.bus.width_bits = width_bits;
        scenario.memory.words_per_cycle = 8;
        const std::int64_t pixels = BufferBound(scenario).find()->pixels;
        if (slower > 0) CHECK(pixels <= slower);
        slower = pixels;
    }
    CHECK(slower <= 2 * 32);
}
