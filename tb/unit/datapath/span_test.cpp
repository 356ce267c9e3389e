#include "datapath/span.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "datapath/averaging.h"
#include "support/images.h"
#include "support/naive_pixels.h"
#include "support/random_seed.h"

namespace metabuffer {
namespace {

using Values = std::vector<std::uint32_t>;

constexpr std::uint32_t kGuard = 0xDEAD'BEEFU;  ///< stands where a function must not write
constexpr std::size_t kGuardValues = 40;        ///< more than any vector unit writes at once

/// A run of pixels somewhere in planes; nothing else in them may change. Each plane has its own alignment.
struct Run {
    std::size_t count;
    std::size_t argb_start;
    std::size_t z_start;
    Values argb_plane;
    Values z_plane;

    Run(test::Random& random, std::size_t length)
        : count(length),
          argb_start(kGuardValues + static_cast<std::size_t>(random.between(0, 8))),
          z_start(kGuardValues + static_cast<std::size_t>(random.between(0, 8))),
          argb_plane(argb_start + length + kGuardValues, kGuard),
          z_plane(z_start + length + kGuardValues, kGuard) {}

    std::uint32_t* argb() { return argb_plane.data() + argb_start; }
    std::uint32_t* z() { return z_plane.data() + z_start; }
    PixelSpan span() { return {argb(), z()}; }

    Pixel get(std::size_t i) const {
        return Pixel((std::uint64_t{z_plane[z_start + i]} << 32) | argb_plane[argb_start + i]);
    }
    void set(std::size_t i, Pixel pixel) {
        argb()[i] = static_cast<std::uint32_t>(pixel.word());
        z()[i] = pixel.z();
    }

    friend bool operator==(const Run& left, const Run& right) {
        return left.argb_plane == right.argb_plane && left.z_plane == right.z_plane;
    }
};

std::size_t random_length(test::Random& random) {
    return static_cast<std::size_t>(random.one_in(4) ? random.between(0, 300) : random.between(0, 40));
}

void randomize(test::Random& random, Run& run) {
    for (std::size_t i = 0; i < run.count; ++i) run.set(i, test::corner_pixel(random));
}

// ---- planes_after_link ----

void check_link(const PixelImage& colour, const PixelImage& depth, DepthFormat format, Pixel old) {
    const PixelPlanes planes = planes_after_link(colour, depth, format);
    REQUIRE(planes.width_pixels == colour.width_pixels);
    REQUIRE(planes.height_pixels == colour.height_pixels);
    REQUIRE(planes.argb.size() == colour.values.size());
    REQUIRE(planes.z.size() == colour.values.size());
    for (std::size_t i = 0; i < colour.values.size(); ++i) {
        INFO("pixel " << i);
        const Pixel half = with_colour_half(old, colour_link_bits(colour.values[i]));
        const Pixel wanted = with_depth_half(half, depth_link_bits(depth.values[i], format), format);
        REQUIRE(planes.argb[i] == static_cast<std::uint32_t>(wanted.word()));
        REQUIRE(planes.z[i] == wanted.z());
    }
}

TEST_CASE("span: planes hold what the link makes of one image's colour and another's depth") {
    const auto seed = test::random_seed(171);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (const DepthLayout& layout : kDepthFormatTable) {
        const DepthFormat format = layout.value;
        for (int trial = 0; trial < 50; ++trial) {
            const int width = random.between(1, 40);
            const int height = random.between(1, 5);
            INFO(layout.name << ", " << width << " x " << height);
            const PixelImage colour = test::noise_image(random, width, height, far_z(DepthFormat::kZ24));
            const PixelImage depth = test::noise_image(random, width, height, far_z(DepthFormat::kZ24));
            check_link(colour, depth, format, test::noise_pixel(random));
            check_link(colour, colour, format, test::noise_pixel(random));
        }
        check_link(PixelImage(), PixelImage(), format, Pixel());
    }
}

// ---- fill_span ----

TEST_CASE("span: a filled run holds one pixel, and its neighbours are unchanged") {
    const auto seed = test::random_seed(172);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 200; ++trial) {
        Run run(random, random_length(random));
        Run wanted = run;
        const Pixel pixel = test::corner_pixel(random);
        for (std::size_t i = 0; i < run.count; ++i) wanted.set(i, pixel);
        fill_span(pixel, run.argb(), run.z(), run.count);
        REQUIRE(run == wanted);
    }
}

// ---- compose_span ----

void check_composition(Composition composition, Run& local, Run& upstream) {
    const Run local_before = local;
    Run wanted = upstream;
    for (std::size_t i = 0; i < wanted.count; ++i) {
        wanted.set(i, test::naive_blend(composition, local.get(i), upstream.get(i)));
    }
    const Run before = upstream;
    compose_span(composition, local.span(), upstream.argb(), upstream.z(), upstream.count);
    for (std::size_t i = 0; i < wanted.count; ++i) {
        if (upstream.get(i) == wanted.get(i)) continue;
        INFO(std::hex << "composition " << static_cast<int>(composition) << ", pixel " << i << ", local "
                      << local.get(i).word() << ", upstream " << before.get(i).word());
        REQUIRE(upstream.get(i).word() == wanted.get(i).word());
    }
    REQUIRE(upstream == wanted);
    REQUIRE(local == local_before);
}

TEST_CASE("span: a composited run is right pixel for pixel at any length and alignment") {
    const auto seed = test::random_seed(173);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (const CompositionRow& row : kCompositionTable) {
        for (int trial = 0; trial < 1000; ++trial) {
            // All the short lengths, then any.
            const std::size_t count = trial <= 70 ? static_cast<std::size_t>(trial) : random_length(random);
            Run local(random, count);
            Run upstream(random, count);
            randomize(random, local);
            randomize(random, upstream);
            check_composition(row.value, local, upstream);
        }
    }
}

TEST_CASE("span: a composited run is right for every pair of alpha and channel behind it") {
    const auto seed = test::random_seed(174);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    constexpr std::size_t kPairs = std::size_t{256} * 256;
    constexpr std::uint32_t kZ = 1000;
    Run local(random, kPairs);
    Run upstream(random, kPairs);
    for (const CompositionRow& row : kCompositionTable) {
        for (const std::uint32_t local_z : {kZ - 1, kZ, kZ + 1}) {
            for (const int front_channel : {0, 1, 127, 128, 254, 255}) {
                for (std::size_t i = 0; i < kPairs; ++i) {
                    const auto alpha = static_cast<std::uint8_t>(i >> 8);
                    const auto channel = static_cast<std::uint8_t>(i);
                    const auto other = static_cast<std::uint8_t>(front_channel);
                    const auto most = static_cast<std::uint8_t>(255 - alpha);
                    const bool local_is_front = local_z < kZ;
                    const Pixel front(other, alpha, most, alpha, local_is_front ? local_z : kZ);
                    const Pixel back(channel, channel, channel, channel, local_is_front ? kZ : local_z);
                    local.set(i, local_is_front ? front : back);
                    upstream.set(i, local_is_front ? back : front);
                }
                check_composition(row.value, local, upstream);
            }
        }
    }
}

TEST_CASE("span: a tie keeps upstream and a transparent local pixel wins only without the key") {
    const auto seed = test::random_seed(175);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    const Pixel upstream_pixel(1, 2, 3, 255, 500);
    const auto result = [&](Composition composition, Pixel local_pixel) {
        Run local(random, 1);
        Run upstream(random, 1);
        local.set(0, local_pixel);
        upstream.set(0, upstream_pixel);
        compose_span(composition, local.span(), upstream.argb(), upstream.z(), 1);
        return upstream.get(0);
    };
    const Pixel tied(9, 9, 9, 255, 500);
    const Pixel transparent(9, 9, 9, 0, 499);
    const Pixel faint(9, 9, 9, 1, 499);
    for (const CompositionRow& row : kCompositionTable) CHECK(result(row.value, tied) == upstream_pixel);
    CHECK(result(Composition::kZ, transparent) == transparent);
    CHECK(result(Composition::kZAlphaKey, transparent) == upstream_pixel);
    CHECK(result(Composition::kZAlphaKey, faint) == faint);
}

// ---- replicate_span ----

void check_replication(test::Random& random, int multiple, std::size_t length, int skip, std::size_t count) {
    INFO("multiple " << multiple << ", length " << length << ", skip " << skip << ", count " << count);
    Run source(random, length);
    randomize(random, source);
    const Run source_before = source;
    Run out(random, count);
    Run wanted = out;
    for (std::size_t n = 0; n < count; ++n) {
        wanted.set(n, source.get((static_cast<std::size_t>(skip) + n) / static_cast<std::size_t>(multiple)));
    }
    replicate_span(source.span(), multiple, skip, out.argb(), out.z(), count);
    REQUIRE(out == wanted);
    REQUIRE(source == source_before);
}

TEST_CASE("span: result n of a replicated run is source pixel (skip + n) / multiple") {
    const auto seed = test::random_seed(176);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    SECTION("every skip and count of short runs") {
        for (int multiple = 1; multiple <= 18; ++multiple) {
            const int results = multiple * 3;
            for (int skip = 0; skip < results; ++skip) {
                for (int count = 0; count <= results - skip; ++count) {
                    check_replication(random, multiple, 3, skip, static_cast<std::size_t>(count));
                }
            }
        }
    }
    SECTION("any multiple and length") {
        for (int trial = 0; trial < 2000; ++trial) {
            const int multiple = random.one_in(2) ? random.between(1, 5) : random.between(1, 255);
            const int length = random.between(1, 60);
            const int skip = random.between(0, multiple * length - 1);
            const int most = multiple * length - skip;
            const int count = random.one_in(2) ? most : random.between(0, most);
            check_replication(random, multiple, static_cast<std::size_t>(length), skip,
                              static_cast<std::size_t>(count));
        }
    }
}

// ---- average_span ----

/// `values` raster pixels at a random position of a plane; alpha too, which must not show.
void check_average(test::Random& random, int supersample, std::size_t display_width, const Values& values) {
    INFO("supersample " << supersample << ", display width " << display_width);
    Run raster(random, values.size());
    Values wanted;
    Averager averager(static_cast<int>(display_width), supersample);
    for (std::size_t i = 0; i < values.size(); ++i) {
        raster.argb()[i] = values[i];
        std::uint32_t colour = 0;
        if (averager.push(Pixel(values[i]), colour)) wanted.push_back(colour);
    }
    REQUIRE(wanted.size() == display_width);
    const auto start = kGuardValues + static_cast<std::size_t>(random.between(0, 8));
    Values colours(start + display_width + kGuardValues, kGuard);
    Values whole = colours;
    for (std::size_t i = 0; i < display_width; ++i) whole[start + i] = wanted[i];
    average_span(raster.argb(), supersample, display_width, colours.data() + start);
    REQUIRE(colours == whole);
}

TEST_CASE("span: averaged rows are the averager's display pixels at any width and alignment") {
    const auto seed = test::random_seed(177);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (const int supersample : {1, 2, 4}) {
        for (int trial = 0; trial < 300; ++trial) {
            const std::size_t width = trial <= 40 ? static_cast<std::size_t>(trial) : random_length(random);
            Values values(width * static_cast<std::size_t>(supersample * supersample));
            for (std::uint32_t& value : values) value = static_cast<std::uint32_t>(random.bits());
            check_average(random, supersample, width, values);
        }
    }
}

TEST_CASE("span: the brightest pixels average to themselves and halves are rounded up") {
    const auto seed = test::random_seed(178);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (const std::size_t supersample : {std::size_t{1}, std::size_t{2}, std::size_t{4}}) {
        const std::size_t block = supersample * supersample;
        constexpr std::size_t kWidth = 21;
        const Values white(kWidth * block, 0xFFFF'FFFFU);
        check_average(random, static_cast<int>(supersample), kWidth, white);
        Values colours(kWidth);
        average_span(white.data(), static_cast<int>(supersample), kWidth, colours.data());
        CHECK(colours == Values(kWidth, 0xFF'FFFFU));
        if (supersample == 1) continue;

        // One display pixel: half of its raster pixels are one brighter than the others.
        Values half(block, 0x10'20'30U);
        for (std::size_t i = 0; i < block / 2; ++i) half[i] = 0x11'21'31U;
        average_span(half.data(), static_cast<int>(supersample), 1, colours.data());
        CHECK(colours[0] == 0x11'21'31U);
        half[0] = 0x10'20'30U;
        average_span(half.data(), static_cast<int>(supersample), 1, colours.data());
        CHECK(colours[0] == 0x10'20'30U);
    }
}

}  // namespace
}  // namespace metabuffer
