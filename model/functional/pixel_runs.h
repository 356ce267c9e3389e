#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/pixel.h"
#include "scenario/scenario.h"

namespace metabuffer::functional {

// The reference's arithmetic on runs of pixels: neighbours in a row, colour and depth apart as in PixelPlanes. The
// loops are written so that compilers turn them into vector instructions: no branch depends on a pixel. What is read
// and what is written must not overlap.

/// Pixels to be read.
struct SourceRun {
    const std::uint32_t* argb = nullptr;
    const std::uint32_t* z = nullptr;
};

/// Pixels to be written.
struct TargetRun {
    std::uint32_t* argb = nullptr;
    std::uint32_t* z = nullptr;
};

/// What the link leaves of the pixels. A depth frame has room only for the alpha and Z bits of its format, so an image
/// with more bits loses them here as it does in the machine.
void take_over_link(const Pixel* pixels, std::size_t count, DepthFormat format, TargetRun target);

/// Each of the `count` values `multiple` times: fills count * multiple values.
void replicate(const std::uint32_t* values, std::size_t count, int multiple, std::uint32_t* target);

/// The same pixel `count` times.
void fill(Pixel pixel, std::size_t count, TargetRun target);

/// What a composer does: merges its own pixels into those of the pipeline.
void merge(Composition composition, SourceRun local, std::size_t count, TargetRun pipeline);

/// The source pixels that smoothing mixes for each raster pixel: its own, the one beside it, the one in the other source
/// row, and the one beside that. A neighbour that is not there is the own pixel again.
struct Surroundings {
    SourceRun own;
    SourceRun beside;
    SourceRun across;
    SourceRun diagonal;
    const std::uint32_t* weight_x = nullptr;  ///< of `beside`, of 256, for each pixel
    std::uint32_t weight_y = 0;               ///< of `across`
};

/// Bilinear smoothing: colour and alpha are mixed, Z is that of the own pixel. A neighbour at the far plane, or hidden by
/// the composition's key, counts as the own pixel.
void mix(Composition composition, std::uint32_t far_z, const Surroundings& source, std::size_t count,
         TargetRun target);

/// Colour, alpha and depth put together to pixels.
void join(SourceRun source, std::size_t count, Pixel* pixels);

/// The mean colours, 0xRRGGBB, of `count` neighbouring squares of s x s pixels, s being 1, 2 or 4: each
/// channel alone, halves rounded up. Row j of the squares starts at argb + j * stride.
void average(const std::uint32_t* argb, std::size_t stride, int supersample, std::size_t count,
             std::uint32_t* colours);

}  // namespace metabuffer::functional
