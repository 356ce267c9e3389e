#include "monitors/reference_composition.h"

#include <algorithm>
#include <cstdlib>

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

Pixel reference_smoothing(const ReferenceMixture& mixture, Composition composition, std::uint32_t far_z) {
    const Pixel own = mixture.own;
    const bool key = composition == Composition::kZAlphaKey;
    if (key && own.a() == 0) return own;
    const auto or_own = [&](Pixel pixel) {
        return pixel.z() == far_z || (key && pixel.a() == 0) ? own : pixel;
    };
    const Pixel beside = or_own(mixture.beside);
    const Pixel across = or_own(mixture.across);
    const Pixel diagonal = or_own(mixture.diagonal);
    const auto channel = [&](std::uint8_t (Pixel::*of)() const) {
        const std::int64_t x = mixture.weight_x;
        const std::int64_t y = mixture.weight_y;
        const std::int64_t sum = (own.*of)() * (256 - x) * (256 - y) + (beside.*of)() * x * (256 - y) +
                                 (across.*of)() * (256 - x) * y + (diagonal.*of)() * x * y;
        return static_cast<std::uint8_t>((sum + 32768) / 65536);
    };
    return {channel(&Pixel::r), channel(&Pixel::g), channel(&Pixel::b), channel(&Pixel::a), own.z()};
}

ReferenceLines reference_lines(int distance, int count, int multiple) {
    ReferenceLines lines;
    lines.own = lines.other = distance / multiple;
    const int off_centre = 2 * (distance % multiple) + 1 - multiple;
    if (off_centre < 0 && lines.own > 0) lines.other = lines.own - 1;
    if (off_centre > 0 && lines.own + 1 < count) lines.other = lines.own + 1;
    lines.weight = 256 * std::abs(off_centre) / (2 * multiple);
    return lines;
}

}  // namespace metabuffer::monitors
