#include "datapath/composition.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/images.h"
#include "support/random_seed.h"

namespace metabuffer {
namespace {

/// The fields of a pixel, so that the reference below shares no bit arithmetic with the datapath.
struct Fields {
    int r;
    int g;
    int b;
    int a;
    int z;
};

Fields fields_of(Pixel pixel) {
    return {pixel.r(), pixel.g(), pixel.b(), pixel.a(), static_cast<int>(pixel.z())};
}

Pixel pixel_of(const Fields& fields) {
    return {static_cast<std::uint8_t>(fields.r), static_cast<std::uint8_t>(fields.g),
            static_cast<std::uint8_t>(fields.b), static_cast<std::uint8_t>(fields.a),
            static_cast<std::uint32_t>(fields.z)};
}

/// front + back * (1 - alpha), with alpha as a real number, rounded once and saturated.
int blended(int front, int back, int front_alpha) {
    const long double behind = static_cast<long double>(back) * (255 - front_alpha) / 255.0L;
    const long sum = front + std::lround(behind);
    return sum > 255 ? 255 : static_cast<int>(sum);
}

Pixel blended_over(const Fields& front, const Fields& back) {
    return pixel_of({blended(front.r, back.r, front.a), blended(front.g, back.g, front.a),
                     blended(front.b, back.b, front.a), blended(front.a, back.a, front.a), front.z});
}

Pixel expected(Composition composition, Pixel local, Pixel upstream) {
    const Fields l = fields_of(local);
    const Fields u = fields_of(upstream);
    switch (composition) {
        case Composition::kZ:
            return l.z >= u.z ? upstream : local;
        case Composition::kZAlphaKey:
            return l.z >= u.z || l.a == 0 ? upstream : local;
        case Composition::kOver:
            return l.z < u.z ? blended_over(l, u) : blended_over(u, l);
    }
    return {};
}

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

TEST_CASE("composition z: the nearer pixel wins and a tie keeps the upstream one") {
    const Pixel local(1, 2, 3, 4, 1000);
    CHECK(compose(Composition::kZ, local, Pixel(9, 9, 9, 9, 1001)) == local);
    CHECK(compose(Composition::kZ, local, Pixel(9, 9, 9, 9, 999)) == Pixel(9, 9, 9, 9, 999));
    CHECK(compose(Composition::kZ, local, Pixel(9, 9, 9, 9, 1000)) == Pixel(9, 9, 9, 9, 1000));
}

TEST_CASE("composition z: alpha has no effect") {
    const Pixel transparent(1, 2, 3, 0, 5);
    CHECK(compose(Composition::kZ, transparent, Pixel(9, 9, 9, 255, 6)) == transparent);
}

TEST_CASE("composition z: depth compares as unsigned over all 24 bits") {
    const Pixel nearest(1, 1, 1, 1, 0);
    const Pixel farthest(2, 2, 2, 2, 0xFFFFFF);
    const Pixel middle(3, 3, 3, 3, 0x800000);
    CHECK(compose(Composition::kZ, nearest, farthest) == nearest);
    CHECK(compose(Composition::kZ, farthest, nearest) == nearest);
    CHECK(compose(Composition::kZ, middle, farthest) == middle);
    CHECK(compose(Composition::kZ, middle, nearest) == nearest);
    CHECK(compose(Composition::kZ, farthest, Pixel(4, 4, 4, 4, 0xFFFFFF)) == Pixel(4, 4, 4, 4, 0xFFFFFF));
}

TEST_CASE("composition z-alpha-key: a nearer local pixel wins unless its alpha is 0") {
    const Pixel upstream(9, 9, 9, 0, 100);
    CHECK(compose(Composition::kZAlphaKey, Pixel(1, 2, 3, 0, 99), upstream) == upstream);
    CHECK(compose(Composition::kZAlphaKey, Pixel(1, 2, 3, 1, 99), upstream) == Pixel(1, 2, 3, 1, 99));
    CHECK(compose(Composition::kZAlphaKey, Pixel(1, 2, 3, 255, 100), upstream) == upstream);
    CHECK(compose(Composition::kZAlphaKey, Pixel(1, 2, 3, 255, 101), upstream) == upstream);
}

TEST_CASE("composition over: an opaque front hides the back and an empty one lets it through") {
    const Pixel back(10, 20, 30, 40, 500);
    CHECK(compose(Composition::kOver, Pixel(1, 2, 3, 255, 499), back) == Pixel(1, 2, 3, 255, 499));
    CHECK(compose(Composition::kOver, Pixel(0, 0, 0, 0, 499), back) == Pixel(10, 20, 30, 40, 499));
}

TEST_CASE("composition over: the front is upstream at equal depth") {
    const Pixel local(255, 0, 0, 255, 7);
    const Pixel upstream(0, 255, 0, 255, 7);
    CHECK(compose(Composition::kOver, local, upstream) == upstream);
}

TEST_CASE("composition over: the result has the front's depth whichever side it came from") {
    CHECK(compose(Composition::kOver, Pixel(0, 0, 0, 9, 3), Pixel(0, 0, 0, 9, 8)).z() == 3);
    CHECK(compose(Composition::kOver, Pixel(0, 0, 0, 9, 8), Pixel(0, 0, 0, 9, 3)).z() == 3);
}

TEST_CASE("composition over: colours that are not premultiplied saturate instead of wrapping") {
    const Pixel front(250, 255, 128, 0, 1);
    const Pixel back(250, 1, 127, 255, 2);
    CHECK(compose(Composition::kOver, front, back) == Pixel(255, 255, 255, 255, 1));
}

TEST_CASE("composition over: half-transparent white over black and over white, by hand") {
    // 255 * (255 - 128) / 255 = 127, so white over white is white again.
    CHECK(compose(Composition::kOver, Pixel(128, 128, 128, 128, 0), Pixel(0, 0, 0, 255, 1)) ==
          Pixel(128, 128, 128, 255, 0));
    CHECK(compose(Composition::kOver, Pixel(128, 128, 128, 128, 0), Pixel(255, 255, 255, 255, 1)) ==
          Pixel(255, 255, 255, 255, 0));
    // 100 * (255 - 51) / 255 = 80 exactly; 101 * 204 / 255 = 80.8 rounds up.
    CHECK(compose(Composition::kOver, Pixel(10, 10, 10, 51, 0), Pixel(100, 101, 0, 0, 1)) ==
          Pixel(90, 91, 10, 51, 0));
}

TEST_CASE("composition over: one channel is exact for every front alpha and back value") {
    int wrong = 0;
    for (int alpha = 0; alpha < 256; ++alpha) {
        for (int value = 0; value < 256; ++value) {
            const Pixel front = pixel_of({0, 3, 0, alpha, 0});
            const Pixel back = pixel_of({value, value, 0, value, 1});
            const Pixel result = compose(Composition::kOver, back, front);
            if (result != expected(Composition::kOver, back, front)) ++wrong;
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("composition: every mode agrees with the rules at the edges of alpha, colour and depth") {
    const std::vector<Fields> edges = [] {
        std::vector<Fields> result;
        for (const int a : {0, 1, 127, 128, 254, 255}) {
            for (const int c : {0, 1, 128, 254, 255}) {
                for (const int z : {0, 1, 0xFFFE, 0xFFFF, 0x10000, 0xFFFFFF}) {
                    result.push_back({c, 255 - c, c, a, z});
                }
            }
        }
        return result;
    }();
    int wrong = 0;
    for (const CompositionRow& row : kCompositionTable) {
        for (const Fields& local : edges) {
            for (const Fields& upstream : edges) {
                const Pixel l = pixel_of(local);
                const Pixel u = pixel_of(upstream);
                if (compose(row.value, l, u) != expected(row.value, l, u)) ++wrong;
            }
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("composition: every mode agrees with the rules on random pixels with frequent ties") {
    const auto seed = test::random_seed(102);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 60000; ++trial) {
        const Pixel local = test::noise_pixel(random);
        Pixel upstream = test::noise_pixel(random);
        if (random.one_in(3)) {
            upstream = Pixel(upstream.r(), upstream.g(), upstream.b(), upstream.a(), local.z());
        }
        for (const auto& [composition, name] : kCompositionTable) {
            const Pixel result = compose(composition, local, upstream);
            const Pixel wanted = expected(composition, local, upstream);
            if (result != wanted) {
                FAIL("mode " << name << ": " << std::hex << local.word() << " on " << upstream.word()
                             << " gives " << result.word() << " instead of " << wanted.word());
            }
        }
    }
    SUCCEED("no difference");
}

}  // namespace
}  // namespace metabuffer
