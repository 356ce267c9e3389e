#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "formats/pixel.h"
#include "scenario/scenario.h"

namespace metabuffer::test {

// What happens to single pixels, written independently and as simply as possible, with floating point where something
// is divided. The functional level is tested against it.

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

}  // namespace metabuffer::test
