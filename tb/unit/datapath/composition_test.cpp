#include "datapath/composition.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/images.h"
#include "support/naive_pixels.h"
#include "support/random_seed.h"

namespace metabuffer::composition_test {
namespace {

TEST_CASE("div255: is t / 255 rounded to nearest for every product of two bytes") {
    for (std::uint32_t t = 0; t <= 65025; ++t) {
        // 255 is odd, so no quotient lies half way; the integer form rounds without any real number.
        const std::uint32_t remainder = t % 255;
        const std::uint32_t nearest = t / 255 + (remainder >= 128 ? 1 : 0);
        if (div255(t) != nearest || div255(t) != static_cast<std::uint32_t>(std::lround(t / 255.0L))) {
            FAIL("div255(" << t << ") = " << div255(t) << " instead of " << nearest);
        }
    }
    SUCCEED("all 65026 values");
}

TEST_CASE("composition: examples by hand") {
    struct Example {
        const char* rule;
        Composition composition;
        Pixel local, upstream, result;
    };
    constexpr auto kZ = Composition::kZ;
    constexpr auto kKey = Composition::kZAlphaKey;
    constexpr auto kOver = Composition::kOver;
    const Pixel back(10, 20, 30, 40, 500);
    const Pixel clear(1, 2, 3, 0, 499);
    const Pixel tied(1, 2, 3, 255, 500);
    const Pixel half_white(128, 128, 128, 128, 0);
    const std::vector<Example> examples{
        {"the nearer pixel wins, whatever its alpha", kZ, clear, back, clear},
        {"a tie keeps the upstream one", kZ, tied, back, back},
        {"depth is unsigned", kZ, {1, 1, 1, 1, 0x80'0000}, {2, 2, 2, 2, 0xFF'FFFF}, {1, 1, 1, 1, 0x80'0000}},
        {"a clear pixel never wins", kKey, clear, back, back},
        {"a faint one does", kKey, {1, 2, 3, 1, 499}, back, {1, 2, 3, 1, 499}},
        {"an opaque front hides the back", kOver, {1, 2, 3, 255, 499}, back, {1, 2, 3, 255, 499}},
        {"an empty front lets it through, at the front's depth",
         kOver,
         {0, 0, 0, 0, 499},
         back,
         {10, 20, 30, 40, 499}},
        {"the front is upstream at equal depth",
         kOver,
         {255, 0, 0, 255, 7},
         {0, 255, 0, 255, 7},
         {0, 255, 0, 255, 7}},
        {"sums saturate", kOver, {250, 255, 128, 0, 1}, {250, 1, 127, 255, 2}, {255, 255, 255, 255, 1}},
        {"half white on black", kOver, half_white, {0, 0, 0, 255, 1}, {128, 128, 128, 255, 0}},
        // 100 * (255 - 51) / 255 = 80 exactly; 101 * 204 / 255 = 80.8 rounds up.
        {"rounded once", kOver, {10, 10, 10, 51, 0}, {100, 101, 0, 0, 1}, {90, 91, 10, 51, 0}},
    };
    for (const Example& example : examples) {
        INFO(example.rule);
        CHECK(compose(example.composition, example.local, example.upstream) == example.result);
        CHECK(test::naive_blend(example.composition, example.local, example.upstream) == example.result);
    }
}

TEST_CASE("composition: every mode agrees with the rules") {
    const auto seed = test::random_seed(102);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    const auto check = [](Pixel local, Pixel upstream) {
        for (const auto& [composition, name] : kCompositionTable) {
            const Pixel result = compose(composition, local, upstream);
            const Pixel wanted = test::naive_blend(composition, local, upstream);
            if (result != wanted) {
                FAIL("mode " << name << ": " << std::hex << local.word() << " on " << upstream.word()
                             << " gives " << result.word() << " instead of " << wanted.word());
            }
        }
    };
    SECTION("of every alpha in front of every value") {
        for (int alpha = 0; alpha < 256; ++alpha) {
            for (int value = 0; value < 256; ++value) {
                const auto channel = static_cast<std::uint8_t>(value);
                const Pixel front(0, 3, 0, static_cast<std::uint8_t>(alpha), 0);
                const Pixel back(channel, channel, 0, channel, 1);
                check(front, back);
                check(back, front);
            }
        }
    }
    SECTION("of random pixels, many of them at the edges of alpha and depth") {
        for (int trial = 0; trial < 60000; ++trial)
            check(test::corner_pixel(random), test::corner_pixel(random));
    }
    SUCCEED("no difference");
}

}  // namespace
}  // namespace metabuffer::composition_test
