#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace metabuffer::rtl {

/// Drives a pin whose width follows from a parameter of the SystemVerilog module. A number that does not fit a narrower
/// pin would look like another one.
template <typename Pin>
void put(Pin& pin, std::uint32_t value) {
    pin = static_cast<Pin>(std::min<std::uint32_t>(value, std::numeric_limits<Pin>::max()));
}

}  // namespace metabuffer::rtl
