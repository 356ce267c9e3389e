#include "tools/analysis/burst_costs.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <vector>

#include "support/random_seed.h"
#include "support/rows.h"

using namespace metabuffer;
using namespace metabuffer::analysis;

namespace {

/// A burst word by word, as docs/design.md has it: the arbiter's clocks, a page miss, then a beat of words of one page, and
/// so on.
struct PlainBurst {
    std::int64_t cycles = 0;
    std::int64_t misses = 0;
    std::int64_t beats = 0;
    std::vector<std::int64_t> until;  ///< clocks from the grant until each pixel is on the bus
};

struct Setting {
    BusConfig bus;
    MemoryConfig memory;
    ViewportRow row;
    int image_width = 0;
    int raster_width = 0;
    int raster_height = 0;
    Smoothing smoothing = Smoothing::kReplicate;

    Segment segment() const { return {row, raster_width, raster_height, smoothing}; }
    std::int64_t page(std::int64_t k) const {
        const std::int64_t y = row.sy + k / row.sdx;
        return (y * image_width + row.sx + k % row.sdx) / memory.page_words;
    }
};

PlainBurst play(const Setting& setting, std::int64_t first, std::int64_t behind, std::int64_t open_page) {
    PlainBurst burst;
    burst.cycles = setting.bus.grant_cycles;
    for (std::int64_t k = first; k < behind;) {
        if (setting.page(k) != open_page) {
            burst.cycles += setting.memory.page_miss_cycles;
            ++burst.misses;
            open_page = setting.page(k);
        }
        burst.cycles += cycles_per_beat(setting.bus);
        ++burst.beats;
        for (int n = 0; n < pixels_per_beat(setting.bus, setting.memory); ++n) {
            if (k >= behind || setting.page(k) != open_page) break;
            burst.until.push_back(burst.cycles);
            ++k;
        }
    }
    return burst;
}

Setting random_setting(test::Random& random) {
    Setting setting;
    setting.bus.width_bits = 16 << random.between(0, 5);
    setting.bus.burst_pixels = random.between(1, 40);
    setting.bus.grant_cycles = random.one_in(3) ? random.between(1, 5) : 0;
    setting.memory.read_latency_cycles = random.one_in(3) ? random.between(1, 5) : 0;
    setting.memory.page_words = random.between(1, 60);
    setting.memory.page_miss_cycles = random.between(0, 7);
    setting.memory.words_per_cycle = random.between(1, 8);
    setting.image_width = random.between(8, 40);
    setting.raster_width = random.between(8, 40);
    setting.raster_height = random.between(8, 40);
    setting.row = test::random_row(random, {setting.image_width, setting.raster_height + 9},
                                   {setting.raster_width, setting.raster_height}, 1, random.between(1, 4));
    if (random.one_in(2)) {
        constexpr int kLargestMultiple = 9;
        setting.smoothing = Smoothing::kBilinear;
        setting.image_width = setting.raster_width + 2;
        setting.row = test::random_smoothed_row(random, {setting.raster_width, setting.raster_height},
                                                kLargestMultiple);
    }
    return setting;
}

}  // namespace

TEST_CASE("bursts cost what a memory played word by word says", "[analysis][random]") {
    test::Random random(test::random_seed(7));
    for (int round = 0; round < 800; ++round) {
        const Setting setting = random_setting(random);
        const Segment segment = setting.segment();
        const auto first_word = static_cast<FirstWord>(random.between(0, 2));
        const double stretch = test::one_of(random, std::array<double, 4>{1.0, 1.0, 1.25, 2.5});
        const BurstCosts costs(segment, setting.image_width, setting.bus, setting.memory, first_word,
                               stretch);
        const std::int64_t burst = setting.bus.burst_pixels;
        const std::int64_t pixels = segment.pixels();
        REQUIRE(costs.bursts() == (pixels + burst - 1) / burst);

        std::int64_t clocks = 0;
        std::int64_t misses = 0;
        std::int64_t beats = 0;
        for (std::int64_t b = 0; b < costs.bursts(); ++b) {
            const std::int64_t first = b * burst;
            std::int64_t open_page = -1;
            if (first_word == FirstWord::kHits) open_page = setting.page(first);
            if (first_word == FirstWord::kExact && b > 0) open_page = setting.page(first - 1);
            const PlainBurst played = play(setting, first, std::min(first + burst, pixels), open_page);
            CHECK(costs.before(b) == Approx(stretch * static_cast<double>(clocks)));
            clocks += played.cycles;
            misses += played.misses;
            beats += played.beats;
            double latest = std::numeric_limits<double>::max();
            for (std::size_t i = 0; i < played.until.size(); ++i) {
                const std::int64_t k = first + static_cast<std::int64_t>(i);
                const double until = stretch * static_cast<double>(played.until[i]);
                CHECK(costs.until_pixel(k) == Approx(until));
                const std::int64_t needed = segment.first_use(k) - setting.memory.read_latency_cycles;
                latest = std::min(latest, static_cast<double>(needed) - until);
            }
            CHECK(costs.latest_start(b) == Approx(latest).margin(1e-6));
        }
        CHECK(costs.total_cycles() == clocks);
        CHECK(costs.page_misses() == misses);
        CHECK(costs.beats() == beats);
    }
}

TEST_CASE("no burst of any beginning is longer than the longest and no window exceeds average and excess",
          "[analysis][random]") {
    test::Random random(test::random_seed(8));
    for (int round = 0; round < 200; ++round) {
        const Setting setting = random_setting(random);
        const Segment segment = setting.segment();
        const BurstCosts costs(segment, setting.image_width, setting.bus, setting.memory, FirstWord::kMisses);
        std::int64_t longest = 0;
        for (std::int64_t first = 0; first < segment.pixels(); ++first) {
            const std::int64_t behind =
                std::min<std::int64_t>(first + setting.bus.burst_pixels, segment.pixels());
            longest = std::max(longest, play(setting, first, behind, -1).cycles);
            std::int64_t in_page = 0;
            while (first + in_page < segment.pixels() &&
                   setting.page(first + in_page) == setting.page(first)) {
                ++in_page;
            }
            CHECK(costs.pixels_in_page(first) == in_page);
        }
        CHECK(costs.longest() >= static_cast<double>(longest));
        CHECK(costs.longest() <=
              static_cast<double>(longest) + cycles_per_beat(setting.bus) * (1 + setting.bus.burst_pixels));
        for (std::int64_t a = 0; a < costs.bursts(); ++a) {
            for (std::int64_t b = a; b <= costs.bursts(); ++b) {
                const double window = costs.before(b) - costs.before(a);
                CHECK(window <= costs.average() * static_cast<double>(b - a) + costs.excess() + 1e-6);
            }
        }
    }
}
