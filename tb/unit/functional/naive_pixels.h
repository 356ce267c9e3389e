#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "formats/pixel.h"
#include "random_seed.h"
#include "scenario/scenario.h"

namespace metabuffer::test {

// What happens to single pixels, written down anew and as plainly as can be, in floating point where there is
// something to divide. The functional level is tested against it.

/// What a link of this depth format leaves of a pixel.
inline Pixel naive_after_link(Pixel pixel, DepthFormat format) {
    switch (format) {
        case DepthFormat::kA8Z16:
            return {pixel.r(), pixel.g(), pixel.b(), pixel.a(), pixel.z() % 0x1'0000U};
        case DepthFormat::kZ24:
            return {pixel.r(), pixel.g(), pixel.b(), 255, pixel.z()};
    }
    return {};
}

inline std::uint8_t naive_over_channel(int front, int back, int front_alpha) {
    const long through = std::lround(back * (255.0 - front_alpha) / 255.0);
    return static_cast<std::uint8_t>(std::min(255L, front + through));
}

inline Pixel naive_blend(Composition composition, Pixel local, Pixel upstream) {
    const bool nearer = local.z() < upstream.z();
    const Pixel front = nearer ? local : upstream;
    const Pixel back = nearer ? upstream : local;
    switch (composition) {
        case Composition::kZ:
            return front;
        case Composition::kZAlphaKey:
            return nearer && local.a() == 0 ? upstream : front;
        case Composition::kOver:
            return {naive_over_channel(front.r(), back.r(), front.a()),
                    naive_over_channel(front.g(), back.g(), front.a()),
                    naive_over_channel(front.b(), back.b(), front.a()),
                    naive_over_channel(front.a(), back.a(), front.a()), front.z()};
    }
    return {};
}

/// Few depths and alphas, so that ties, clear and opaque pixels are common; and now and then any word.
inline Pixel random_pixel(Random& random) {
    if (random.one_in(4)) return Pixel(random.bits() & 0xFF'FFFF'FFFF'FFFFULL);
    const std::uint32_t depths[] = {0, 1, 2, 3, 0x7FFF, 0xFFFF, 0xFF'FFFF};
    const std::uint8_t alphas[] = {0, 1, 127, 128, 254, 255};
    return {static_cast<std::uint8_t>(random.between(0, 255)),
            static_cast<std::uint8_t>(random.between(0, 255)),
            static_cast<std::uint8_t>(random.between(0, 255)), alphas[random.between(0, 5)],
            depths[random.between(0, 6)]};
}

}  // namespace metabuffer::test
