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
        // The frame's start, at -1, may release pixels that smoothing does not need.
        const auto released_before = [&](std::int64_t position) {
            return position < 0 ? 0 : segment.released_before(position);
        };
        for (std::int64_t from = -1; from <= positions; ++from) {
            for (std::int64_t until = from; until <= positions; ++until) {
                const auto released = static_cast<double>(released_before(until) - released_before(from));
                const std::int64_t inside =
                    std::clamp(until, curve.first, curve.last) - std::clamp(from, curve.first, curve.last);
                const double most = curve.rate * static_cast<double>(inside) + curve.burst;
                if (released > most + 1e-9) FAIL_CHECK("from " << from << " until " << until);
            }
        }
    }
}

TEST_CASE("a buffer lacks no more at the end of a frame than its raster has released since any pixel",
          "[analysis][random]") {
    const std::uint64_t seed = test::random_seed(8);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int round = 0; round < 2000; ++round) {
        const int width = random.between(4, 14);
        const int height = random.between(4, 24);
        const bool smoothed = round % 3 > 0;
        const ViewportRow row =
            smoothed ? test::random_smoothed_row(random, {width, height}, 6)
                     : test::random_row(random, {14, 24}, {width, height}, 1, random.between(1, 4));
        const Segment segment(row, width, height, smoothed ? Smoothing::kBilinear : Smoothing::kReplicate);
        const std::int64_t burst = random.between(1, 8);
        const BusTable::SureBursts sure{random.between(1, 60) / 100.0, random.between(1, 600) / 100.0};
        const std::int64_t positions = std::int64_t{width} * height;
        MachineFigures machine((test::small_scenario(width, height)));
        machine.burst_pixels = burst;
        double most = 0.0;
        for (std::int64_t k = 0; k < segment.pixels(); ++k) {
            const auto clocks =
                static_cast<double>(positions - segment.last_use(k) - machine.busready_cycles);
            const double brought = sure.in(clocks) * static_cast<double>(burst);
            most = std::max(most, static_cast<double>(segment.pixels() - k) - brought);
        }
        INFO("raster " << width << " x " << height << ", row " << row.sdx << " x " << row.sdy << " at "
                       << row.dx << ", " << row.dy << " multiple " << row.dmultiple << ", smoothed "
                       << smoothed << " rate " << sure.rate << " loss " << sure.loss);
        CHECK(most_refill_pixels(segment, sure, machine) == Approx(most).margin(1e-9));
    }
}

TEST_CASE("what a rival has released counts what the frame's start releases", "[analysis]") {
    // Source row 1 shows in raster row 0, whose other source row is row 2: nothing needs row 0.
    Scenario scenario = one_composer({1, 0, 0, 2, 3, 0, -7, 4}, 8, 8);
    scenario.composer.smoothing = Smoothing::kBilinear;
    const BufferBound bound(scenario);
    const RivalGrants rival(bound.tables().front(), 0, 100);
    CHECK(rival.released_before(-1) == 0);
    CHECK(rival.released_before(0) == 2);
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
        CHECK(bound.smallest_legal_pixels() == ready + (row.dmultiple > 1 ? row.sdx - 1 : 0));
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
    CHECK(BufferBound(scenario).smallest_legal_pixels() == ready + size - 1);
    CHECK(BufferBound(scenario).find()->pixels == ready + size);
    // Two pages of 512 words: while they are opened, the raster takes three pixels.
    scenario.memory.page_miss_cycles = 6;
    const std::int64_t pixels = BufferBound(scenario).find()->pixels;
    CHECK(pixels >= ready + size + 3);
    CHECK(pixels <= ready + size + 4);
}

TEST_CASE(
    "a lone composer needs as many pixels more as its raster takes while its memory refreshes or its bus is "
    "slow",
    "[analysis]") {
    // Two pixels a clock into a raster of one: the bus has the time, but each wait must be buffered.
    const int size = 100;
    Scenario scenario = one_composer({1, 0, 0, size, size, 0, 0, 1}, size, size);
    scenario.bus.width_bits = 128;
    scenario.memory.words_per_cycle = 2;
    scenario.memory.page_miss_cycles = 4;
    scenario.bus.burst_pixels = 16;
    scenario.composer.ready_space_pixels = 16;
    const std::int64_t plain = BufferBound(scenario).find()->pixels;
    Scenario refreshed = scenario;
    refreshed.memory.refresh_interval_cycles = 800;
    refreshed.memory.refresh_cycles = 36;
    const std::int64_t with_refresh = BufferBound(refreshed).find()->pixels;
    CHECK(with_refresh >= plain + 30);
    CHECK(with_refresh <= plain + 60);
    // Page misses of 12 clocks and writes of 8, one in 64 of the link's clocks.
    Scenario shared = scenario;
    shared.memory.ports = MemoryPorts::kShared;
    shared.memory.write_block_words = 16;
    shared.clocks.dvi_in_mhz = shared.clocks.core_mhz / 4;
    const std::int64_t with_writes = BufferBound(shared).find()->pixels;
    CHECK(with_writes >= plain + 16);
    CHECK(with_writes <= plain + 96);
    // Three clocks of read latency and a register each way: five more to the answer, after each burst.
    Scenario delayed = scenario;
    delayed.memory.read_latency_cycles = 3;
    delayed.bus.register_stages = 1;
    delayed.composer.ready_space_pixels = 16;
    const std::int64_t with_delays = BufferBound(delayed).find()->pixels;
    CHECK(with_delays >= plain + 4);
    CHECK(with_delays <= plain + 20);
    // The arbiter's two clocks in the eight of a burst.
    Scenario slow = scenario;
    slow.bus.grant_cycles = 2;
    const std::int64_t with_grants = BufferBound(slow).find()->pixels;
    CHECK(with_grants >= plain);
    CHECK(with_grants <= plain + 8);
}

TEST_CASE("where refreshes leave the bus too little, the buffer must hold most of the segment",
          "[analysis]") {
    const int size = 100;
    Scenario scenario = one_composer({1, 0, 0, size, size, 0, 0, 1}, size, size);
    scenario.memory.page_miss_cycles = 0;
    scenario.memory.refresh_interval_cycles = 100;
    scenario.memory.refresh_cycles = 50;
    const BufferBound bound(scenario);
    // Half of the pixels come in the raster's clocks; the others must have come before.
    CHECK(bound.find()->pixels >= size * size / 2);
    CHECK(bound.find()->pixels <= size * size * 6 / 10);
    scenario.memory.refresh_cycles = 99;
    CHECK(BufferBound(scenario).find()->pixels > size * size * 9 / 10);
    CHECK(BufferBound(scenario).find()->pixels <= bound.whole_segment_pixels());
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
