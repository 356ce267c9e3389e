#include "formats/colour_table.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/colour_tables.h"
#include "support/random_seed.h"

using namespace metabuffer;
using namespace metabuffer::test;

TEST_CASE("colour table: values computed by hand, halves rounded up, white at the most") {
    const ColourTable table = colour_table({1.0, 1.0, 1.0}, 1.0);
    for (const ColourTable::Channel& channel : table.channels()) {
        for (std::size_t v = 0; v < channel.size(); ++v) CHECK(channel[v] == v);
    }
    const ColourTable::Channels channels = colour_table({0.5, 0.25, 2.0}, 1.0).channels();
    CHECK(channels[0][1] == 1);      // 0.5
    CHECK(channels[0][3] == 2);      // 1.5
    CHECK(channels[0][255] == 128);  // 127.5
    CHECK(channels[1][1] == 0);      // 0.25
    CHECK(channels[1][2] == 1);      // 0.5
    CHECK(channels[1][254] == 64);   // 63.5
    CHECK(channels[2][127] == 254);
    CHECK(channels[2][128] == 255);
    CHECK(channels[2][255] == 255);
    // 255 * (v / 255)^(1/2) = sqrt(255 v), and with gamma 0.5 v * v / 255.
    const ColourTable::Channels root = colour_table({1.0, 0.5, 4.0}, 2.0).channels();
    CHECK(root[0][0] == 0);
    CHECK(root[0][1] == 16);    // 15.97
    CHECK(root[0][64] == 128);  // 127.75
    CHECK(root[0][255] == 255);
    CHECK(root[1][128] == 128);  // the root of 255 * 64
    CHECK(root[2][16] == 128);
    CHECK(root[2][64] == 255);
    const ColourTable::Channels square = colour_table({1.0, 1.0, 1.0}, 0.5).channels();
    CHECK(square[0][16] == 1);    // 1.004
    CHECK(square[0][11] == 0);    // 0.47
    CHECK(square[0][12] == 1);    // 0.56
    CHECK(square[0][128] == 64);  // 64.25
}

TEST_CASE("colour table: every value is the nearest to the light that gain and gamma ask for", "[random]") {
    const std::uint64_t seed = random_seed(20261124);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    const auto between = [&random](double low, double high) {
        return low + (high - low) * random.between(0, 1'000'000) / 1e6;
    };
    for (int trial = 0; trial < 300; ++trial) {
        const double gain[3] = {between(0.01, 3.0), between(0.5, 1.2), std::exp(between(-6.9, 6.9))};
        const double gamma = random.one_in(3) ? 1.0 : std::exp(between(-2.0, 2.0));
        INFO("gain " << gain[0] << ", " << gain[1] << ", " << gain[2] << ", gamma " << gamma);
        const ColourTable table = colour_table(gain, gamma);
        for (std::size_t c = 0; c < ColourTable::kChannels; ++c) {
            for (int v = 0; v < 256; ++v) {
                const int shown = table.channels()[c][static_cast<std::size_t>(v)];
                INFO("channel " << c << ", value " << v << ": " << shown);
                REQUIRE(may_show(v, gain[c], gamma, shown));
                // The judge is sharp: it accepts no neighbour, but at a tie.
                if (v > 0 && shown > 0) CHECK_FALSE(may_show(v, gain[c], gamma, shown - 1, 0.0L));
            }
        }
    }
}
