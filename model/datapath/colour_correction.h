#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/colour_table.h"

namespace metabuffer {

/// The step after the averaging (section 2 of the paper): each channel of a colour, 0xRRGGBB, is looked up in its table.
inline std::uint32_t corrected(const ColourTable& table, std::uint32_t colour) {
    const auto& [red, green, blue] = table.channels();
    return (std::uint32_t{red[(colour >> 16) & 0xFFU]} << 16) |
           (std::uint32_t{green[(colour >> 8) & 0xFFU]} << 8) | blue[colour & 0xFFU];
}

/// The same for a run of colours.
inline void correct_span(const ColourTable& table, std::uint32_t* colours, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n) colours[n] = corrected(table, colours[n]);
}

}  // namespace metabuffer
