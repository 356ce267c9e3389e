#pragma once

#include <array>
#include <cstdint>

#include "formats/pixel.h"
#include "host/enum_table.h"

namespace metabuffer {

/// How a composer merges its local pixel with the one from upstream. Each level and the judges have their own code for
/// it: a switch that does not compile until it handles a new value.
enum class Composition : std::uint8_t {
    kZ,          ///< the nearer wins; a tie keeps the upstream pixel
    kZAlphaKey,  ///< as kZ, but a local pixel with A = 0 never wins
    kOver,       ///< premultiplied alpha: the nearer over the farther
};

struct CompositionRow {
    Composition value;
    const char* name;
};

/// Messages list the names in this order.
inline constexpr std::array kCompositionTable{
    CompositionRow{Composition::kZ, "z"},
    CompositionRow{Composition::kZAlphaKey, "z-alpha-key"},
    CompositionRow{Composition::kOver, "over"},
};
static_assert(is_in_order(kCompositionTable));

/// t / 255 rounded to nearest, exact for 0 <= t <= 255 * 255, without a divider.
constexpr std::uint32_t div255(std::uint32_t t) { return (t + 128 + ((t + 128) >> 8)) >> 8; }

/// One composer's datapath: the pixel that leaves it, given the local and the upstream pixel.
constexpr Pixel compose(Composition composition, Pixel local, Pixel upstream);

namespace detail {

constexpr std::uint8_t over_channel(std::uint8_t front, std::uint8_t back, std::uint8_t front_alpha) {
    const std::uint32_t sum = front + div255(std::uint32_t{back} * (255U - front_alpha));
    return static_cast<std::uint8_t>(sum > 255U ? 255U : sum);
}

constexpr Pixel over(Pixel front, Pixel back) {
    return {over_channel(front.r(), back.r(), front.a()), over_channel(front.g(), back.g(), front.a()),
            over_channel(front.b(), back.b(), front.a()), over_channel(front.a(), back.a(), front.a()),
            front.z()};
}

}  // namespace detail

constexpr Pixel compose(Composition composition, Pixel local, Pixel upstream) {
    const bool nearer = local.z() < upstream.z();
    switch (composition) {
        case Composition::kZ:
            return nearer ? local : upstream;
        case Composition::kZAlphaKey:
            return nearer && local.a() != 0 ? local : upstream;
        case Composition::kOver:
            return nearer ? detail::over(local, upstream) : detail::over(upstream, local);
    }
    return upstream;
}

}  // namespace metabuffer
