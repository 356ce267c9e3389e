#include "formats/colour_table.h"

#include <algorithm>
#include <cmath>

namespace metabuffer {
namespace {

constexpr double kWhite = 255.0;

std::uint8_t corrected_value(double value, double gain, double gamma) {
    const double light = std::min(kWhite, gain * value) / kWhite;
    return static_cast<std::uint8_t>(std::lround(kWhite * std::pow(light, 1.0 / gamma)));
}

}  // namespace

ColourTable colour_table(const double (&gain)[ColourTable::kChannels], double gamma) {
    ColourTable::Channels channels{};
    for (std::size_t c = 0; c < ColourTable::kChannels; ++c) {
        for (std::size_t v = 0; v < ColourTable::kValues; ++v) {
            channels[c][v] = corrected_value(static_cast<double>(v), gain[c], gamma);
        }
    }
    return ColourTable(channels);
}

}  // namespace metabuffer
