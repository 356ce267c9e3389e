#include "datapath/smoothing.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "datapath/span.h"
#include "support/images.h"
#include "support/naive_pixels.h"
#include "support/random_seed.h"

namespace metabuffer::smoothing_test {
namespace {

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
            const Pixel wanted = test::naive_mixture(windows[i], x, y, composition, far);
            REQUIRE(blend(windows[i], x, y, composition, far) == wanted);
            REQUIRE(out[i] == static_cast<std::uint32_t>(wanted.word()));
        }
    }
}

}  // namespace
}  // namespace metabuffer::smoothing_test
