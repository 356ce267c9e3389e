#pragma once

#include <cstdint>

#include "formats/depth_format.h"

namespace metabuffer {

constexpr int kColourBits = 24;
constexpr std::uint32_t kColourMask = 0xFF'FFFFU;
constexpr int kPixelBits = 64;  ///< one word of the input framebuffer, one pixel on the bus

/// One pixel as the input framebuffer's 64-bit memory holds it and as bus and pipeline carry it:
/// B [7:0], G [15:8], R [23:16], A [31:24], Z [55:32], the rest zero.
class Pixel {
  public:
    constexpr Pixel() = default;
    constexpr explicit Pixel(std::uint64_t word) : word_(word) {}
    constexpr Pixel(std::uint8_t r, std::uint8_t g, std::uint8_t b, std::uint8_t a, std::uint32_t z)
        : word_((std::uint64_t{z & kColourMask} << 32) | (std::uint64_t{a} << 24) | (std::uint64_t{r} << 16) |
                (std::uint64_t{g} << 8) | b) {}

    constexpr std::uint64_t word() const { return word_; }
    constexpr std::uint8_t r() const { return static_cast<std::uint8_t>(word_ >> 16); }
    constexpr std::uint8_t g() const { return static_cast<std::uint8_t>(word_ >> 8); }
    constexpr std::uint8_t b() const { return static_cast<std::uint8_t>(word_); }
    constexpr std::uint8_t a() const { return static_cast<std::uint8_t>(word_ >> 24); }
    constexpr std::uint32_t z() const { return static_cast<std::uint32_t>(word_ >> 32) & kColourMask; }
    constexpr std::uint32_t rgb() const { return static_cast<std::uint32_t>(word_) & kColourMask; }

    friend constexpr bool operator==(Pixel left, Pixel right) { return left.word_ == right.word_; }
    friend constexpr bool operator!=(Pixel left, Pixel right) { return left.word_ != right.word_; }

  private:
    std::uint64_t word_ = 0;
};

/// The 24 link bits of a pixel in the colour frame: R[23:16] G[15:8] B[7:0].
constexpr std::uint32_t colour_link_bits(Pixel pixel) { return pixel.rgb(); }

/// The 24 link bits of a pixel in the depth frame.
constexpr std::uint32_t depth_link_bits(Pixel pixel, DepthFormat format) {
    const DepthLayout& layout = layout_of(format);
    return ((pixel.a() & layout.alpha_mask()) << layout.alpha_shift) |
           ((pixel.z() & layout.z_mask()) << layout.z_shift);
}

/// A memory word whose colour half has been replaced by a colour frame's link bits.
constexpr Pixel with_colour_half(Pixel old, std::uint32_t link_bits) {
    return Pixel((old.word() & ~std::uint64_t{kColourMask}) | (link_bits & kColourMask));
}

/// A memory word whose depth half (A and Z) has been replaced by a depth frame's link bits.
constexpr Pixel with_depth_half(Pixel old, std::uint32_t link_bits, DepthFormat format) {
    const DepthLayout& layout = layout_of(format);
    const std::uint64_t a = layout.alpha_of(link_bits) | layout.opaque_alpha();
    const std::uint64_t z = layout.z_of(link_bits);
    return Pixel(old.rgb() | (a << 24) | (z << 32));
}

}  // namespace metabuffer
