#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "datapath/composition.h"
#include "datapath/smoothing.h"
#include "formats/depth_format.h"
#include "formats/pixel.h"

namespace metabuffer::test {

// What happens to single pixels, written independently and as simply as possible, with floating point where something
// is divided. All levels are tested against it.

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

/// The local pixel where up to four are mixed, by the formula of docs/design.md. x and y are the neighbours' weights of
/// 256.
inline Pixel naive_mixture(const BlendWindow<Pixel>& window, int x, int y, Composition composition,
                           std::uint32_t far_z) {
    const bool key = composition == Composition::kZAlphaKey;
    if (key && window.own.a() == 0) return window.own;
    const auto or_own = [&](Pixel pixel) {
        return pixel.z() == far_z || (key && pixel.a() == 0) ? window.own : pixel;
    };
    const auto channel = [&](auto of) {
        const double sum =
            of(window.own) * (256.0 - x) * (256.0 - y) + of(or_own(window.beside)) * x * (256.0 - y) +
            of(or_own(window.across)) * (256.0 - x) * y + of(or_own(window.diagonal)) * 1.0 * x * y;
        return static_cast<std::uint8_t>(std::floor((sum + 32768.0) / 65536.0));
    };
    return {channel([](Pixel p) { return p.r(); }), channel([](Pixel p) { return p.g(); }),
            channel([](Pixel p) { return p.b(); }), channel([](Pixel p) { return p.a(); }), window.own.z()};
}

}  // namespace metabuffer::test
