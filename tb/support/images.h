#pragma once

#include <array>
#include <cstdint>

#include "formats/depth_format.h"
#include "formats/image.h"
#include "support/random_seed.h"

namespace metabuffer::test {

/// A pixel that is random throughout: any colour and alpha, Z up to `farthest`.
inline Pixel noise_pixel(Random& random, std::uint32_t farthest = far_z(DepthFormat::kZ24)) {
    const std::uint64_t bits = random.bits();
    return {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
            static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24),
            static_cast<std::uint32_t>(bits >> 32) & farthest};
}

/// Any colour, but few depths and alphas, so that ties, clear and opaque pixels are common. Now and then any word.
inline Pixel corner_pixel(Random& random) {
    if (random.one_in(4)) return noise_pixel(random);
    constexpr std::array<std::uint32_t, 9> kDepths{0, 1, 2, 3, 0x7FFF, 0xFFFF, 0x10000, 0x80'0000, 0xFF'FFFF};
    constexpr std::array<std::uint8_t, 6> kAlphas{0, 1, 127, 128, 254, 255};
    const Pixel any = noise_pixel(random);
    const std::uint8_t alpha = one_of(random, kAlphas);
    return {any.r(), any.g(), any.b(), alpha, one_of(random, kDepths)};
}

/// An image of noise. Its Z fits every link unless `farthest` is given.
inline PixelImage noise_image(Random& random, int width, int height,
                              std::uint32_t farthest = far_z(DepthFormat::kA8Z16)) {
    PixelImage image(width, height);
    for (Pixel& pixel : image.values) pixel = noise_pixel(random, farthest);
    return image;
}
inline PixelImage noise_image(std::uint64_t seed, int width, int height) {
    Random random(seed);
    return noise_image(random, width, height);
}

/// Noise, but opaque, and with so few depths that images tie with each other now and then.
inline PixelImage opaque_noise_image(Random& random, int width, int height) {
    PixelImage image = noise_image(random, width, height, 0xFF);
    for (Pixel& pixel : image.values) pixel = Pixel(pixel.r(), pixel.g(), pixel.b(), 255, pixel.z());
    return image;
}

inline PixelImage corner_image(Random& random, int width, int height) {
    PixelImage image(width, height);
    for (Pixel& pixel : image.values) pixel = corner_pixel(random);
    return image;
}

}  // namespace metabuffer::test
