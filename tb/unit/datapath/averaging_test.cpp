#include "datapath/averaging.h"

#include <catch2/catch.hpp>
#include <optional>
#include <vector>

#include "formats/image.h"
#include "support/images.h"
#include "support/random_seed.h"

namespace metabuffer {
namespace {

/// A display picture and, for each of its pixels, which raster pixel completed it.
struct Averaged {
    std::vector<std::uint32_t> colours;
    std::vector<std::size_t> completed_by;
};

Averaged averaged(Averager& averager, const std::vector<Pixel>& raster) {
    Averaged result;
    for (std::size_t position = 0; position < raster.size(); ++position) {
        constexpr std::uint32_t kUntouched = 0xDEADBEEF;
        std::uint32_t colour = kUntouched;
        if (averager.push(raster[position], colour)) {
            result.colours.push_back(colour);
            result.completed_by.push_back(position);
        } else {
            CHECK(colour == kUntouched);
        }
    }
    return result;
}

/// The mean of each block as a whole number, halves rounded up, from the raster as a picture.
std::vector<std::uint32_t> means(const PixelImage& raster, int supersample) {
    std::vector<std::uint32_t> result;
    const int count = supersample * supersample;
    for (int y = 0; y < raster.height_pixels; y += supersample) {
        for (int x = 0; x < raster.width_pixels; x += supersample) {
            int r = 0;
            int g = 0;
            int b = 0;
            for (int j = 0; j < supersample; ++j) {
                for (int i = 0; i < supersample; ++i) {
                    r += raster.at(x + i, y + j).r();
                    g += raster.at(x + i, y + j).g();
                    b += raster.at(x + i, y + j).b();
                }
            }
            const auto mean = [count](int sum) {
                return static_cast<std::uint32_t>(sum / count + (2 * (sum % count) >= count ? 1 : 0));
            };
            result.push_back(mean(r) * 65536 + mean(g) * 256 + mean(b));
        }
    }
    return result;
}

PixelImage random_raster(test::Random& random, int width, int height) {
    return test::noise_image(random, width, height, far_z(DepthFormat::kZ24));
}

std::uint32_t block_average(int supersample, const std::vector<Pixel>& block) {
    Averager averager(1, supersample);
    const Averaged result = averaged(averager, block);
    REQUIRE(result.colours.size() == 1);
    return result.colours.front();
}

TEST_CASE("averaging: without supersampling each pixel passes through at once, colour only") {
    Averager averager(3, 1);
    const auto seed = test::random_seed(103);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int i = 0; i < 30; ++i) {
        const Pixel pixel = test::noise_pixel(random);
        std::uint32_t colour = 0;
        REQUIRE(averager.push(pixel, colour));
        CHECK(colour == (pixel.word() & 0xFFFFFF));
    }
}

TEST_CASE("averaging: a display pixel is complete with the last raster pixel of its block") {
    for (const int supersample : {1, 2, 4}) {
        INFO("supersample " << supersample);
        const int width = 3;
        const int height = 2;
        Averager averager(width, supersample);
        const std::vector<Pixel> raster(static_cast<std::size_t>(width * height * supersample * supersample));
        const Averaged result = averaged(averager, raster);
        std::vector<std::size_t> wanted;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const int last_x = (x + 1) * supersample - 1;
                const int last_y = (y + 1) * supersample - 1;
                wanted.push_back(static_cast<std::size_t>(last_y * width * supersample + last_x));
            }
        }
        CHECK(result.completed_by == wanted);
    }
}

TEST_CASE("averaging: a block of all ones stays all ones and a black one black") {
    for (const int supersample : {1, 2, 4}) {
        INFO("supersample " << supersample);
        const auto side = static_cast<std::size_t>(supersample);
        CHECK(block_average(supersample, std::vector<Pixel>(side * side, Pixel(255, 255, 255, 0, 0))) ==
              0xFFFFFF);
        CHECK(block_average(supersample, std::vector<Pixel>(side * side, Pixel(0, 0, 0, 255, 0xFFFFFF))) ==
              0);
    }
}

TEST_CASE("averaging: halves round up, less than a half rounds down, each channel for itself") {
    // Sums over 4 pixels: R 2 (a half), G 1 (a quarter), B 3 (three quarters).
    CHECK(block_average(2, {Pixel(2, 1, 3, 0, 0), Pixel(), Pixel(), Pixel()}) == 0x010001);
    // Sums over 16 pixels: R 8 (a half), G 7 (just less), B 1020 + 7 (63.75 and just less than a half more).
    std::vector<Pixel> block(16);
    block[0] = Pixel(8, 7, 255, 0, 0);
    block[5] = Pixel(0, 0, 255, 0, 0);
    block[10] = Pixel(0, 0, 255, 0, 0);
    block[15] = Pixel(0, 0, 255, 0, 0);
    CHECK(block_average(4, block) == 0x010040);
}

TEST_CASE("averaging: equals the mean of each block on random rasters, frame after frame") {
    const auto seed = test::random_seed(104);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (const int supersample : {1, 2, 4}) {
        for (int trial = 0; trial < 20; ++trial) {
            const int width = random.between(1, 9);
            const int height = random.between(1, 7);
            INFO("supersample " << supersample << ", display " << width << " x " << height);
            Averager averager(width, supersample);
            for (int frame = 0; frame < 2; ++frame) {
                const PixelImage raster = random_raster(random, width * supersample, height * supersample);
                CHECK(averaged(averager, raster.values).colours == means(raster, supersample));
            }
        }
    }
}

}  // namespace
}  // namespace metabuffer
