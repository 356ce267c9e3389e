#pragma once

#include <cstdint>

namespace metabuffer::rtl {

/// The finalizer of SplitMix64: every bit of the result depends on every bit of the word. Faults that come at random
/// draw from it, so that they depend on their seed and on what is mixed in, and on nothing else.
constexpr std::uint64_t mixed_bits(std::uint64_t word) {
    word += 0x9E37'79B9'7F4A'7C15U;
    word = (word ^ (word >> 30U)) * 0xBF58'476D'1CE4'E5B9U;
    word = (word ^ (word >> 27U)) * 0x94D0'49BB'1331'11EBU;
    return word ^ (word >> 31U);
}

}  // namespace metabuffer::rtl
