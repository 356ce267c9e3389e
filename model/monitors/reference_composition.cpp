#include "monitors/reference_composition.h"

#include <algorithm>

namespace metabuffer::monitors {
namespace {

constexpr int kOpaque = 255;

std::uint8_t over_channel(int front, int back, int front_alpha) {
    return static_cast<std::uint8_t>(std::min(kOpaque, unlimited_over(front, back, front_alpha)));
}

Pixel over(Pixel front, Pixel back) {
    return {over_channel(front.r(), back.r(), front.a()), over_channel(front.g(), back.g(), front.a()),
            over_channel(front.b(), back.b(), front.a()), over_channel(front.a(), back.a(), front.a()),
            front.z()};
}

}  // namespace

/// The quotient by division, rounded to nearest.
int unlimited_over(int front, int back, int front_alpha) {
    const int product = back * (kOpaque - front_alpha);
    return front + (2 * product + kOpaque) / (2 * kOpaque);
}

Pixel reference_composition(Composition composition, Pixel local, Pixel upstream) {
    const bool local_in_front = local.z() < upstream.z();
    switch (composition) {
        case Composition::kZ:
            return local_in_front ? local : upstream;
        case Composition::kZAlphaKey:
            return local_in_front && local.a() != 0 ? local : upstream;
        case Composition::kOver:
            return local_in_front ? over(local, upstream) : over(upstream, local);
    }
    return upstream;  // no composition
}

}  // namespace metabuffer::monitors
