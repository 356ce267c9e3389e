#pragma once

#include <array>
#include <cstdint>
#include <string>

// Names of goals that the list of goals and the samplers put together from parts.

namespace metabuffer::coverage {

constexpr std::array<const char*, 4> kSides{"left", "right", "top", "bottom"};
/// Up to this Dmultiple every way in which the raster can cut a replicated pixel is a goal of its own.
constexpr int kLargestPhasedMultiple = 4;

inline std::string width_name(int bits) { return std::to_string(bits) + " bits"; }

/// How a display's clock can stand to the core clock.
constexpr std::array<const char*, 5> kClockRatios{"DVI out slower by a whole factor", "DVI out slower",
                                                  "DVI out equal", "DVI out faster",
                                                  "DVI out faster by a whole factor"};

/// Which of kClockRatios two periods have, both above 0.
inline const char* clock_ratio_name(std::int64_t core_picoseconds, std::int64_t out_picoseconds) {
    if (core_picoseconds == out_picoseconds) return kClockRatios[2];
    if (core_picoseconds < out_picoseconds) {
        return kClockRatios[out_picoseconds % core_picoseconds == 0 ? 0 : 1];
    }
    return kClockRatios[core_picoseconds % out_picoseconds == 0 ? 4 : 3];
}

inline std::string phase_name(int multiple, const std::string& side, int cut) {
    return "x" + std::to_string(multiple) + ", " + side + ", " + std::to_string(cut) + " cut";
}

/// "A, B", as crossed goals are called.
inline std::string both(const std::string& a, const std::string& b) { return a + ", " + b; }

}  // namespace metabuffer::coverage
