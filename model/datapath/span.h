#pragma once

#include <cstddef>
#include <cstdint>

#include "datapath/composition.h"
#include "formats/image.h"
#include "formats/pixel_planes.h"

/// The datapath on runs of pixels instead of single ones: the same results as compose() and Averager, pixel
/// for pixel, at the speed of the processor's vector units.
namespace metabuffer {

/// A run of pixels in planes: `argb` and `z` are read side by side.
struct PixelSpan {
    const std::uint32_t* argb = nullptr;
    const std::uint32_t* z = nullptr;
};

/// What the link leaves of a pair: the colour half of one image's words and the depth half of another's. They are one
/// image, unless frames of two pairs were mixed. Both have one size.
PixelPlanes planes_after_link(const PixelImage& colour, const PixelImage& depth, DepthFormat format);

/// Fills `count` pixels with one.
void fill_span(Pixel pixel, std::uint32_t* argb, std::uint32_t* z, std::size_t count);

/// Composites `count` local pixels with the upstream ones in (argb, z), which the results replace.
void compose_span(Composition composition, PixelSpan local, std::uint32_t* argb, std::uint32_t* z,
                  std::size_t count);

/// Each source pixel `multiple` times, the first `skip` results left out, `count` results in all:
/// out[n] = source[(skip + n) / multiple], for both planes.
void replicate_span(PixelSpan source, int multiple, int skip, std::uint32_t* argb, std::uint32_t* z,
                    std::size_t count);

/// What the raster pixels of a row are mixed of: each one's own source pixel, the one beside it, the one across in the
/// other source row, and the one that is both. A neighbour that is not there is the own pixel again.
struct BlendSpans {
    PixelSpan own;
    PixelSpan beside;
    PixelSpan across;
    PixelSpan diagonal;
    const std::uint32_t* weights_x = nullptr;  ///< of 256, for each pixel
    int weight_y = 0;
};

/// The same as blend() for `count` raster pixels. Writes colour and alpha; Z is that of `own`.
void blend_span(Composition composition, std::uint32_t far_z, const BlendSpans& source, std::uint32_t* argb,
                std::size_t count);

/// Averages blocks of supersample x supersample pixels: `argb` holds `supersample` raster rows one after the other,
/// each display_width * supersample wide; `colours` gets display_width values 0xRRGGBB.
void average_span(const std::uint32_t* argb, int supersample, std::size_t display_width,
                  std::uint32_t* colours);

}  // namespace metabuffer
