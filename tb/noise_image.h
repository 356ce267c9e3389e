#pragma once

#include <cstdint>

#include "formats/image.h"
#include "random_seed.h"

namespace metabuffer::test {

/// An opaque image of random colours in which each pixel's Z is random too, of eight bits.
inline PixelImage noise_image(Random& random, int width, int height) {
    PixelImage image(width, height);
    for (Pixel& pixel : image.values) {
        const std::uint64_t bits = random.bits();
        pixel =
            Pixel(static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                  static_cast<std::uint8_t>(bits >> 16), 255, static_cast<std::uint32_t>(bits >> 32) & 0xFFU);
    }
    return image;
}

}  // namespace metabuffer::test
