#include "functional/pixel_runs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "scenario/names.h"
#include "support/images.h"
#include "support/naive_pixels.h"
#include "support/random_seed.h"

// Runs of every length and at every alignment, against the same work done pixel by pixel. Memory around what is written
// must stay as it was: vector instructions could write too far.

using namespace metabuffer;
using functional::SourceRun;
using functional::TargetRun;
using test::corner_pixel;
using test::naive_after_link;
using test::naive_blend;
using test::Random;

namespace {

constexpr std::uint32_t kUntouched = 0xDEAD'BEEF;
constexpr std::size_t kMargin = 32;  // values on both sides, more than a vector has

/// Values at some distance from an aligned address, with a margin on both sides.
class Guarded {
  public:
    Guarded(std::size_t shift, std::size_t count)
        : values_(shift + count + 2 * kMargin, kUntouched), first_(shift + kMargin), count_(count) {}
    Guarded(std::size_t shift, const std::vector<std::uint32_t>& content) : Guarded(shift, content.size()) {
        std::copy(content.begin(), content.end(), data());
    }

    std::uint32_t* data() { return values_.data() + first_; }
    std::vector<std::uint32_t> content() const { return {begin(), begin() + size()}; }
    bool margins_untouched() const {
        const auto untouched = [](std::uint32_t value) { return value == kUntouched; };
        return std::all_of(values_.begin(), begin(), untouched) &&
               std::all_of(begin() + size(), values_.end(), untouched);
    }

  private:
    std::vector<std::uint32_t>::const_iterator begin() const {
        return values_.begin() + static_cast<std::ptrdiff_t>(first_);
    }
    std::ptrdiff_t size() const { return static_cast<std::ptrdiff_t>(count_); }

    std::vector<std::uint32_t> values_;
    std::size_t first_;
    std::size_t count_;
};

std::size_t random_count(Random& random) {
    return static_cast<std::size_t>(random.one_in(4) ? random.between(0, 1000) : random.between(0, 40));
}

std::size_t random_shift(Random& random) { return static_cast<std::size_t>(random.between(0, 15)); }

std::vector<Pixel> random_pixels(Random& random, std::size_t count) {
    std::vector<Pixel> pixels(count);
    for (Pixel& pixel : pixels) pixel = corner_pixel(random);
    return pixels;
}

std::vector<std::uint32_t> random_words(Random& random, std::size_t count) {
    std::vector<std::uint32_t> words(count);
    for (std::uint32_t& word : words) word = static_cast<std::uint32_t>(random.bits());
    return words;
}

std::vector<std::uint32_t> argb_of(const std::vector<Pixel>& pixels) {
    std::vector<std::uint32_t> argb;
    argb.reserve(pixels.size());
    for (const Pixel pixel : pixels) argb.push_back(pixel.a() * 0x100'0000U + pixel.rgb());
    return argb;
}

std::vector<std::uint32_t> z_of(const std::vector<Pixel>& pixels) {
    std::vector<std::uint32_t> z;
    z.reserve(pixels.size());
    for (const Pixel pixel : pixels) z.push_back(pixel.z());
    return z;
}

}  // namespace

TEST_CASE("runs: merging is what each pixel alone gives", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260201);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    const Composition composition = GENERATE(from_range(kCompositionTable)).value;
    const DepthFormat format = GENERATE(from_range(kDepthFormatTable)).value;
    INFO(to_string(composition) << ", " << to_string(format));

    for (int trial = 0; trial < 200; ++trial) {
        const std::size_t count = random_count(random);
        INFO("trial " << trial << ", " << count << " pixels");
        std::vector<Pixel> local = random_pixels(random, count);
        std::vector<Pixel> upstream = random_pixels(random, count);
        std::vector<Pixel> expected;
        for (std::size_t i = 0; i < count; ++i) {
            local[i] = naive_after_link(local[i], format);
            upstream[i] = naive_after_link(upstream[i], format);
            expected.push_back(naive_blend(composition, local[i], upstream[i]));
        }
        Guarded local_argb(random_shift(random), argb_of(local));
        Guarded local_z(random_shift(random), z_of(local));
        Guarded argb(random_shift(random), argb_of(upstream));
        Guarded z(random_shift(random), z_of(upstream));

        functional::merge(composition, SourceRun{local_argb.data(), local_z.data()}, count,
                          TargetRun{argb.data(), z.data()});

        REQUIRE(argb.content() == argb_of(expected));
        REQUIRE(z.content() == z_of(expected));
        REQUIRE(argb.margins_untouched());
        REQUIRE(z.margins_untouched());
        REQUIRE(local_argb.content() == argb_of(local));
        REQUIRE(local_z.content() == z_of(local));
    }
}

TEST_CASE("runs: a link leaves what its depth format has room for", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260202);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    const DepthFormat format = GENERATE(from_range(kDepthFormatTable)).value;

    for (int trial = 0; trial < 100; ++trial) {
        const std::size_t shift = random_shift(random);
        const std::size_t count = random_count(random);
        INFO("trial " << trial << ", " << count << " pixels");
        const std::vector<Pixel> pixels = random_pixels(random, shift + count);
        std::vector<Pixel> expected;
        for (std::size_t i = shift; i < pixels.size(); ++i) {
            expected.push_back(naive_after_link(pixels[i], format));
        }
        Guarded argb(random_shift(random), count);
        Guarded z(random_shift(random), count);

        functional::take_over_link(pixels.data() + shift, count, format, TargetRun{argb.data(), z.data()});

        REQUIRE(argb.content() == argb_of(expected));
        REQUIRE(z.content() == z_of(expected));
        REQUIRE(argb.margins_untouched());
        REQUIRE(z.margins_untouched());

        // And together again they are the pixels.
        std::vector<Pixel> joined(shift + count + 1, Pixel(kUntouched));
        functional::join(SourceRun{argb.data(), z.data()}, count, joined.data() + shift);
        const auto first = joined.begin() + static_cast<std::ptrdiff_t>(shift);
        REQUIRE(std::equal(first, joined.end() - 1, expected.begin(), expected.end()));
        REQUIRE(joined.back() == Pixel(kUntouched));
    }
}

TEST_CASE("runs: replication repeats each value", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260203);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    const int multiple = GENERATE(range(1, 20), 100, 254, 255);
    INFO("multiple " << multiple);

    for (int trial = 0; trial < 20; ++trial) {
        const std::size_t count = random_count(random) / 4;
        INFO("trial " << trial << ", " << count << " values");
        Guarded values(random_shift(random), random_words(random, count));
        std::vector<std::uint32_t> expected;
        for (const std::uint32_t value : values.content()) {
            for (int n = 0; n < multiple; ++n) expected.push_back(value);
        }
        Guarded target(random_shift(random), expected.size());

        functional::replicate(values.data(), count, multiple, target.data());

        REQUIRE(target.content() == expected);
        REQUIRE(target.margins_untouched());
    }
}

TEST_CASE("runs: filling sets both planes", "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260204);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);

    for (int trial = 0; trial < 100; ++trial) {
        const std::size_t count = random_count(random);
        INFO("trial " << trial << ", " << count << " pixels");
        const std::vector<Pixel> expected(count, corner_pixel(random));
        Guarded argb(random_shift(random), count);
        Guarded z(random_shift(random), count);

        functional::fill(expected.empty() ? Pixel() : expected[0], count, TargetRun{argb.data(), z.data()});

        REQUIRE(argb.content() == argb_of(expected));
        REQUIRE(z.content() == z_of(expected));
        REQUIRE(argb.margins_untouched());
        REQUIRE(z.margins_untouched());
    }
}

TEST_CASE("runs: the mean of squares is that of each channel, halves rounded up; no other size is averaged",
          "[functional][random]") {
    const std::uint64_t seed = test::random_seed(20260205);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    const std::size_t s = GENERATE(1, 2, 4);
    INFO("supersample " << s);

    for (int trial = 0; trial < 100; ++trial) {
        const std::size_t count = random_count(random) / s;
        const std::size_t stride = count * s + static_cast<std::size_t>(random.between(0, 9));
        INFO("trial " << trial << ", " << count << " squares");
        std::vector<std::uint32_t> samples = random_words(random, s * stride);
        // Bright ones too: their sums are the largest.
        for (std::uint32_t& sample : samples) {
            if (trial % 10 == 0 || random.one_in(8)) sample = 0xFFFF'FFFF;
        }
        std::vector<std::uint32_t> expected;
        for (std::size_t x = 0; x < count; ++x) {
            std::uint32_t colour = 0;
            for (const int shift : {16, 8, 0}) {
                std::size_t sum = 0;
                for (std::size_t n = 0; n < s * s; ++n) {
                    sum += samples[n / s * stride + x * s + n % s] >> shift & 0xFFU;
                }
                // Twice as large, so that a half is a whole number.
                colour = colour * 256 + static_cast<std::uint32_t>((2 * sum + s * s) / (2 * s * s));
            }
            expected.push_back(colour);
        }
        Guarded raster(random_shift(random), samples);
        Guarded colours(random_shift(random), count);

        functional::average(raster.data(), stride, static_cast<int>(s), count, colours.data());

        REQUIRE(colours.content() == expected);
        REQUIRE(colours.margins_untouched());
        REQUIRE(raster.content() == samples);
    }
    std::uint32_t colour = 0;
    const std::vector<std::uint32_t> samples(9);
    CHECK_THROWS_AS(functional::average(samples.data(), 3, 3, 1, &colour), std::invalid_argument);
}
