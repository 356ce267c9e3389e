#pragma once

#include <array>
#include <string>

// Names of goals that the list of goals and the samplers put together from parts.

namespace metabuffer::coverage {

constexpr std::array<const char*, 4> kSides{"left", "right", "top", "bottom"};
/// Up to this Dmultiple every way in which the raster can cut a replicated pixel is a goal of its own.
constexpr int kLargestPhasedMultiple = 4;

inline std::string width_name(int bits) { return std::to_string(bits) + " bits"; }

inline std::string phase_name(int multiple, const std::string& side, int cut) {
    return "x" + std::to_string(multiple) + ", " + side + ", " + std::to_string(cut) + " cut";
}

/// "A, B", as crossed goals are called.
inline std::string both(const std::string& a, const std::string& b) { return a + ", " + b; }

}  // namespace metabuffer::coverage
