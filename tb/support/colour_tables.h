#pragma once

#include <cmath>
#include <cstdint>

#include "formats/colour_table.h"
#include "formats/image.h"
#include "support/random_seed.h"

namespace metabuffer::test {

/// Any table at all, in which colours that differ may become the same.
inline ColourTable random_colour_table(Random& random) {
    ColourTable::Channels channels{};
    for (ColourTable::Channel& channel : channels) {
        for (std::uint8_t& value : channel) value = static_cast<std::uint8_t>(random.bits());
    }
    return ColourTable(channels);
}

/// Whether a display that multiplies by `gain` and takes the root of that gamma shows `shown` for a channel's value. By
/// the way back: the light for which `shown` would be half a step too bright or too dark, raised to gamma, lies around
/// the light that is asked for. `slack`: how far a rounding of the way forward may be off, in steps.
inline bool may_show(int value, double gain, double gamma, int shown, long double slack = 1e-9L) {
    const long double white = 255.0L;
    const long double asked = static_cast<long double>(gain) * value / white;
    if (asked >= 1.0L) return shown == 255;
    const auto light = [&](long double step) {
        return step <= 0.0L ? 0.0L : std::pow(step / white, static_cast<long double>(gamma));
    };
    const bool is_dark_enough = light(shown - 0.5L - slack) <= asked;
    const bool is_bright_enough = shown == 255 || asked < light(shown + 0.5L + slack);
    return is_dark_enough && is_bright_enough;
}

/// A display's picture, corrected channel by channel with divisions.
inline ColourImage naive_correction(const ColourTable& table, ColourImage picture) {
    for (std::uint32_t& colour : picture.values) {
        const std::uint32_t red = table.channels()[0][colour / 65536];
        const std::uint32_t green = table.channels()[1][colour / 256 % 256];
        const std::uint32_t blue = table.channels()[2][colour % 256];
        colour = red * 65536 + green * 256 + blue;
    }
    return picture;
}

}  // namespace metabuffer::test
