#include "formats/pixel.h"

#include <catch2/catch.hpp>

#include "formats/image.h"
#include "support/images.h"
#include "support/random_seed.h"

namespace metabuffer {
namespace {

TEST_CASE("pixel: the memory word holds RGB in [23:0], A in [31:24], Z in [55:32] and zero above") {
    const Pixel pixel(0x12, 0x34, 0x56, 0x78, 0x9ABCDE);
    CHECK(pixel.word() == 0x009ABCDE'78123456U);
    CHECK(pixel.r() == 0x12);
    CHECK(pixel.g() == 0x34);
    CHECK(pixel.b() == 0x56);
    CHECK(pixel.a() == 0x78);
    CHECK(pixel.z() == 0x9ABCDE);
    CHECK(pixel.rgb() == 0x123456);
    CHECK(Pixel().word() == 0);
    // Each field takes its own bits and no others.
    CHECK(Pixel(0xFF, 0, 0, 0, 0).word() == 0x00000000'00FF0000U);
    CHECK(Pixel(0, 0xFF, 0, 0, 0).word() == 0x00000000'0000FF00U);
    CHECK(Pixel(0, 0, 0xFF, 0, 0).word() == 0x00000000'000000FFU);
    CHECK(Pixel(0, 0, 0, 0xFF, 0).word() == 0x00000000'FF000000U);
    CHECK(Pixel(0, 0, 0, 0, 0xFFFFFFFF).word() == 0x00FFFFFF'00000000U);
}

TEST_CASE("pixel: words compare bit for bit") {
    const Pixel pixel(1, 2, 3, 4, 5);
    CHECK(pixel == Pixel(0x00000005'04010203U));
    CHECK_FALSE(pixel != Pixel(0x00000005'04010203U));
    for (int bit = 0; bit < 64; ++bit) {
        INFO("bit " << bit);
        const Pixel other(pixel.word() ^ (std::uint64_t{1} << bit));
        CHECK(pixel != other);
        CHECK_FALSE(pixel == other);
    }
}

TEST_CASE("pixel: a colour frame carries R, G, B; a depth frame A and Z or, for z24, Z alone with A as 255") {
    constexpr DepthFormat k16 = DepthFormat::kA8Z16;
    constexpr DepthFormat k24 = DepthFormat::kZ24;
    CHECK(far_z(k16) == 0xFFFF);
    CHECK(far_z(k24) == 0xFFFFFF);
    CHECK(colour_link_bits(Pixel(0xAB, 0xCD, 0xEF, 0xFF, 0xFFFFFF)) == 0xABCDEF);
    CHECK(colour_link_bits(Pixel(0, 0, 0, 0xFF, 0xFFFFFF)) == 0);
    CHECK(depth_link_bits(Pixel(0xFF, 0xFF, 0xFF, 0x12, 0x3456), k16) == 0x123456);
    CHECK(depth_link_bits(Pixel(0, 0, 0, 0, 0xAB1234), k16) == 0x001234);
    CHECK(depth_link_bits(Pixel(0xFF, 0xFF, 0xFF, 0x12, 0x3456AB), k24) == 0x3456AB);
    CHECK(depth_link_bits(Pixel(0, 0, 0, 0xFF, 0), k24) == 0);
    // In the memory word each replaces its own and leaves the other's.
    const Pixel old(0x11, 0x22, 0x33, 0x44, 0x556677);
    CHECK(with_colour_half(old, 0xFFABCDEF) == Pixel(0xAB, 0xCD, 0xEF, 0x44, 0x556677));
    CHECK(with_colour_half(old, 0) == Pixel(0, 0, 0, 0x44, 0x556677));
    CHECK(with_depth_half(old, 0xABCDEF, k16).word() == 0x0000CDEF'AB112233U);
    CHECK(with_depth_half(old, 0, k16).word() == 0x00000000'00112233U);
    CHECK(with_depth_half(old, 0xFFFFFFFF, k16).word() == 0x0000FFFF'FF112233U);
    CHECK(with_depth_half(old, 0xABCDEF, k24).word() == 0x00ABCDEF'FF112233U);
    CHECK(with_depth_half(old, 0, k24).word() == 0x00000000'FF112233U);
    CHECK(with_depth_half(old, 0xFFFFFFFF, k24).word() == 0x00FFFFFF'FF112233U);
}

TEST_CASE("depth formats: alpha and Z lie beside each other in the 24 bits, and alpha is whole or left out") {
    for (const DepthLayout& layout : kDepthFormatTable) {
        INFO(layout.name);
        CHECK((layout.z_bits >= 1 && layout.z_bits <= 24));
        CHECK((layout.alpha_bits == 0 || layout.alpha_bits == 8));
        const std::uint32_t z = layout.z_mask() << layout.z_shift;
        const std::uint32_t alpha = layout.alpha_mask() << layout.alpha_shift;
        CHECK((z | alpha) <= 0xFF'FFFFU);
        CHECK((z & alpha) == 0);
        CHECK(layout.z_of(z) == layout.z_mask());
        CHECK(layout.alpha_of(alpha) == layout.alpha_mask());
    }
}

TEST_CASE("input framebuffer word: a pair over the link restores the pixel in either order of its halves") {
    const auto seed = test::random_seed(101);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 20000; ++trial) {
        const Pixel stale = test::noise_pixel(random);
        const DepthLayout layout = test::one_of(random, kDepthFormatTable);
        const DepthFormat format = layout.value;
        // What the format can carry.
        const Pixel any(random.bits());
        const Pixel sent(any.r(), any.g(), any.b(), layout.has_alpha() ? any.a() : std::uint8_t{255},
                         any.z() >> (24 - layout.z_bits));
        const std::uint32_t colour = colour_link_bits(sent);
        const std::uint32_t depth = depth_link_bits(sent, format);
        REQUIRE(colour <= 0xFFFFFF);
        REQUIRE(depth <= 0xFFFFFF);
        REQUIRE(with_depth_half(with_colour_half(stale, colour), depth, format) == sent);
        REQUIRE(with_colour_half(with_depth_half(stale, depth, format), colour) == sent);
    }
}

TEST_CASE("raster: values lie row by row from the top left") {
    Raster<int> raster(3, 2, 7);
    REQUIRE(raster.values == std::vector<int>(6, 7));
    raster.at(2, 0) = 20;
    raster.at(1, 1) = 11;
    CHECK(raster.values == std::vector<int>{7, 7, 20, 7, 11, 7});
    CHECK_FALSE(raster == Raster<int>(3, 2, 7));
    CHECK_FALSE(Raster<int>(3, 2, 7) == Raster<int>(2, 3, 7));
    CHECK(Raster<int>(3, 2, 7) == Raster<int>(3, 2, 7));
}

}  // namespace
}  // namespace metabuffer
