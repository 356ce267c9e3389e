#pragma once

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

namespace metabuffer {

/// What Z of whole numbers means.
enum class DepthIntegers : std::uint8_t {
    kScaled,  ///< a fraction of the largest number that the file's samples hold
    kRaw,     ///< the number that goes over the link
};

/// Where a file of Z has its bits.
enum class DepthBits : std::uint8_t {
    kChannel,  ///< all in one channel
    kRgb24,    ///< 24 bits in R, G and B of 8 bits, R the highest
};

/// What floats of R, G and B become on the link.
enum class ColourEncoding : std::uint8_t {
    kAsIs,  ///< whole numbers in proportion
    kSrgb,  ///< they are linear, and become what sRGB has for them
};

/// What the samples of a scenario's image files mean.
struct ImageReading {
    double near = 0.0;  ///< more than `far` if larger samples are nearer
    double far = 1.0;
    DepthIntegers integers = DepthIntegers::kScaled;
    DepthBits bits = DepthBits::kChannel;
    ColourEncoding colours = ColourEncoding::kAsIs;
    /// Samples of Z where the image is empty. They become the far plane.
    std::vector<double> nothing{};
    bool nan_is_nothing = false;

    bool larger_is_nearer() const { return near > far; }
    double nearest() const { return std::min(near, far); }
    double farthest() const { return std::max(near, far); }

  private:
    auto all() const { return std::tie(near, far, integers, bits, colours, nothing, nan_is_nothing); }

  public:
    friend bool operator<(const ImageReading& a, const ImageReading& b) { return a.all() < b.all(); }
};

}  // namespace metabuffer
