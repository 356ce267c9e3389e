#include "datapath/span.h"

#include <algorithm>

#include "datapath/vectorized.h"

namespace metabuffer {
namespace {

constexpr std::uint32_t kAlphaMask = ~kColourMask;
constexpr std::uint32_t kEvenBytes = 0x00FF'00FFU;  ///< every other channel, each with 8 bits of headroom

// ---- planes_after_link ----

// The same as colour_link_bits, with_colour_half and so on, written out: alpha and Z as far as the format has them.
METABUFFER_VECTORIZED
void link_planes(const Pixel* __restrict colour, const Pixel* __restrict depth, const DepthLayout& layout,
                 std::uint32_t* __restrict argb, std::uint32_t* __restrict z, std::size_t count) {
    const std::uint32_t alpha_mask = layout.alpha_mask() << kColourBits;
    const std::uint32_t opaque_alpha = layout.opaque_alpha() << kColourBits;
    const std::uint32_t z_mask = layout.z_mask();
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t depth_word = depth[i].word();
        argb[i] = (static_cast<std::uint32_t>(colour[i].word()) & kColourMask) |
                  (static_cast<std::uint32_t>(depth_word) & alpha_mask) | opaque_alpha;
        z[i] = static_cast<std::uint32_t>(depth_word >> 32) & z_mask;
    }
}

// ---- compose_span ----

/// Z has 24 bits, so a signed comparison, which vector units have, gives the same result.
METABUFFER_INLINE bool nearer(std::uint32_t local_z, std::uint32_t upstream_z) {
    return static_cast<std::int32_t>(local_z) < static_cast<std::int32_t>(upstream_z);
}

METABUFFER_INLINE std::uint32_t select(bool first, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t mask = first ? ~std::uint32_t{0} : 0;
    return (a & mask) | (b & ~mask);
}

METABUFFER_VECTORIZED
void compose_z(const std::uint32_t* __restrict local_argb, const std::uint32_t* __restrict local_z,
               std::uint32_t* __restrict argb, std::uint32_t* __restrict z, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const bool wins = nearer(local_z[i], z[i]);
        argb[i] = select(wins, local_argb[i], argb[i]);
        z[i] = select(wins, local_z[i], z[i]);
    }
}

METABUFFER_VECTORIZED
void compose_z_alpha_key(const std::uint32_t* __restrict local_argb, const std::uint32_t* __restrict local_z,
                         std::uint32_t* __restrict argb, std::uint32_t* __restrict z, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const bool wins = nearer(local_z[i], z[i]) & ((local_argb[i] & kAlphaMask) != 0);
        argb[i] = select(wins, local_argb[i], argb[i]);
        z[i] = select(wins, local_z[i], z[i]);
    }
}

/// Two channels of front + back * weight / 255, in bytes 0 and 2. No step leaves its 16 bits: the largest
/// value, 255 * 255 + 128 + 254, is below 2^16.
METABUFFER_INLINE std::uint32_t over_even_bytes(std::uint32_t front, std::uint32_t back,
                                                std::uint32_t weight) {
    const std::uint32_t product = back * weight + 0x0080'0080U;
    const std::uint32_t quotient = ((product + ((product >> 8) & kEvenBytes)) >> 8) & kEvenBytes;
    const std::uint32_t sum = front + quotient;
    const std::uint32_t carry = (sum >> 8) & 0x0001'0001U;
    return (sum | (carry * 0xFFU)) & kEvenBytes;
}

METABUFFER_VECTORIZED
void compose_over(const std::uint32_t* __restrict local_argb, const std::uint32_t* __restrict local_z,
                  std::uint32_t* __restrict argb, std::uint32_t* __restrict z, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const bool local_is_front = nearer(local_z[i], z[i]);
        const std::uint32_t front = select(local_is_front, local_argb[i], argb[i]);
        const std::uint32_t back = local_argb[i] ^ argb[i] ^ front;
        const std::uint32_t weight = 255U - (front >> 24);
        argb[i] = over_even_bytes(front & kEvenBytes, back & kEvenBytes, weight) |
                  (over_even_bytes((front >> 8) & kEvenBytes, (back >> 8) & kEvenBytes, weight) << 8);
        z[i] = select(local_is_front, local_z[i], z[i]);
    }
}

// ---- replicate_span ----

METABUFFER_VECTORIZED
void double_values(const std::uint32_t* __restrict source, std::uint32_t* __restrict out, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        out[2 * i] = source[i];
        out[2 * i + 1] = source[i];
    }
}

/// Writes whole runs in blocks of constant size, which are vector stores. The next run overwrites what a block writes
/// beyond its run. Leaves out the runs at the end whose blocks would write out of bounds; returns how many runs it has
/// written.
template <std::size_t kBlock>
METABUFFER_INLINE std::size_t write_runs(const std::uint32_t* __restrict source, std::size_t multiple,
                                         std::uint32_t* __restrict out, std::size_t count) {
    const std::size_t written = (multiple + kBlock - 1) / kBlock * kBlock;
    if (count < written) return 0;
    const std::size_t runs = (count - written) / multiple + 1;
    for (std::size_t i = 0; i < runs; ++i) {
        for (std::size_t k = 0; k < multiple; k += kBlock) {
            for (std::size_t j = 0; j < kBlock; ++j) out[i * multiple + k + j] = source[i];
        }
    }
    return runs;
}

METABUFFER_VECTORIZED
std::size_t write_short_runs(const std::uint32_t* source, std::size_t multiple, std::uint32_t* out,
                             std::size_t count) {
    // With the multiple known, the loop over a run's blocks goes away.
    return multiple == 3 ? write_runs<4>(source, 3, out, count) : write_runs<4>(source, 4, out, count);
}

METABUFFER_VECTORIZED
std::size_t write_long_runs(const std::uint32_t* source, std::size_t multiple, std::uint32_t* out,
                            std::size_t count) {
    return write_runs<8>(source, multiple, out, count);
}

void replicate_values(const std::uint32_t* source, std::size_t multiple, std::size_t skip, std::uint32_t* out,
                      std::size_t count) {
    source += skip / multiple;
    if (multiple == 1) {
        std::copy_n(source, count, out);
        return;
    }
    const std::uint32_t* const end = out + count;
    if (const std::size_t phase = skip % multiple; phase != 0) {
        out = std::fill_n(out, std::min(multiple - phase, count), *source++);
    }
    const auto left = static_cast<std::size_t>(end - out);
    std::size_t runs = left / multiple;
    if (multiple == 2) {
        double_values(source, out, runs);
    } else if (multiple <= 4) {
        runs = write_short_runs(source, multiple, out, left);
    } else {
        runs = write_long_runs(source, multiple, out, left);
    }
    source += runs;
    out += runs * multiple;
    while (out != end) {
        out = std::fill_n(out, std::min(multiple, static_cast<std::size_t>(end - out)), *source++);
    }
}

// ---- blend_span ----

/// Two channels of `a` and `b` in the weights 256 - weight and weight, each 255 * 256 at most, in 16 bits.
METABUFFER_INLINE std::uint32_t mix_even_bytes(std::uint32_t a, std::uint32_t b, std::uint32_t weight) {
    return (a & kEvenBytes) * (256U - weight) + (b & kEvenBytes) * weight;
}

/// The same of two rows, rounded back to bytes 0 and 2.
METABUFFER_INLINE std::uint32_t mix_rows(std::uint32_t own_row, std::uint32_t other_row,
                                         std::uint32_t weight) {
    constexpr std::uint32_t kHalf = 1U << 15;
    constexpr std::uint32_t kLow = 0xFFFFU;
    const std::uint32_t low = (own_row & kLow) * (256U - weight) + (other_row & kLow) * weight + kHalf;
    const std::uint32_t high = (own_row >> 16) * (256U - weight) + (other_row >> 16) * weight + kHalf;
    return (low >> 16) | (high & ~kLow);
}

METABUFFER_INLINE std::uint32_t seen_argb(std::uint32_t argb, std::uint32_t z, std::uint32_t own,
                                          std::uint32_t far_z, std::uint32_t unkeyed) {
    return select((z != far_z) & (((argb | unkeyed) & kAlphaMask) != 0), argb, own);
}

METABUFFER_VECTORIZED
void blend_values(const BlendSpans& source, std::uint32_t far_z, bool has_key, std::uint32_t* __restrict argb,
                  std::size_t count) {
    const std::uint32_t* __restrict own = source.own.argb;
    const std::uint32_t* __restrict beside = source.beside.argb;
    const std::uint32_t* __restrict across = source.across.argb;
    const std::uint32_t* __restrict diagonal = source.diagonal.argb;
    const std::uint32_t* __restrict beside_z = source.beside.z;
    const std::uint32_t* __restrict across_z = source.across.z;
    const std::uint32_t* __restrict diagonal_z = source.diagonal.z;
    const std::uint32_t* __restrict weights_x = source.weights_x;
    const auto weight_y = static_cast<std::uint32_t>(source.weight_y);
    const std::uint32_t unkeyed = has_key ? 0 : kAlphaMask;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t p = own[i];
        const std::uint32_t b = seen_argb(beside[i], beside_z[i], p, far_z, unkeyed);
        const std::uint32_t a = seen_argb(across[i], across_z[i], p, far_z, unkeyed);
        const std::uint32_t d = seen_argb(diagonal[i], diagonal_z[i], p, far_z, unkeyed);
        const std::uint32_t weight_x = weights_x[i];
        const std::uint32_t even =
            mix_rows(mix_even_bytes(p, b, weight_x), mix_even_bytes(a, d, weight_x), weight_y);
        const std::uint32_t odd = mix_rows(mix_even_bytes(p >> 8, b >> 8, weight_x),
                                           mix_even_bytes(a >> 8, d >> 8, weight_x), weight_y);
        argb[i] = select(((p | unkeyed) & kAlphaMask) == 0, p, even | (odd << 8));
    }
}

// ---- average_span ----

METABUFFER_VECTORIZED
void drop_alpha(const std::uint32_t* __restrict argb, std::size_t count, std::uint32_t* __restrict colours) {
    for (std::size_t i = 0; i < count; ++i) colours[i] = argb[i] & kColourMask;
}

/// Red and blue are summed side by side: 16 * 255 + 8 has 12 bits, and each has 16.
template <std::size_t kSupersample>
METABUFFER_INLINE void average(const std::uint32_t* __restrict argb, std::size_t display_width,
                               std::uint32_t* __restrict colours) {
    constexpr std::uint32_t kGreen = 0x0000'FF00U;
    constexpr std::uint32_t kHalf = kSupersample * kSupersample / 2;
    constexpr int kShift = kSupersample == 4 ? 4 : 2;
    const std::size_t raster_width = display_width * kSupersample;
    for (std::size_t i = 0; i < display_width; ++i) {
        std::uint32_t red_blue = (kHalf << 16) | kHalf;
        std::uint32_t green = kHalf << 8;
        for (std::size_t x = 0; x < kSupersample; ++x) {
            for (std::size_t y = 0; y < kSupersample; ++y) {
                const std::uint32_t pixel = argb[y * raster_width + i * kSupersample + x];
                red_blue += pixel & kEvenBytes;
                green += pixel & kGreen;
            }
        }
        colours[i] = ((red_blue >> kShift) & kEvenBytes) | ((green >> kShift) & kGreen);
    }
}

METABUFFER_VECTORIZED
void average_2(const std::uint32_t* argb, std::size_t display_width, std::uint32_t* colours) {
    average<2>(argb, display_width, colours);
}

METABUFFER_VECTORIZED
void average_4(const std::uint32_t* argb, std::size_t display_width, std::uint32_t* colours) {
    average<4>(argb, display_width, colours);
}

}  // namespace

PixelPlanes planes_after_link(const PixelImage& colour, const PixelImage& depth, DepthFormat format) {
    PixelPlanes planes(colour.width_pixels, colour.height_pixels);
    link_planes(colour.values.data(), depth.values.data(), layout_of(format), planes.argb.data(),
                planes.z.data(), planes.argb.size());
    return planes;
}

void fill_span(Pixel pixel, std::uint32_t* argb, std::uint32_t* z, std::size_t count) {
    std::fill_n(argb, count, static_cast<std::uint32_t>(pixel.word()));
    std::fill_n(z, count, pixel.z());
}

void compose_span(Composition composition, PixelSpan local, std::uint32_t* argb, std::uint32_t* z,
                  std::size_t count) {
    switch (composition) {
        case Composition::kZ:
            compose_z(local.argb, local.z, argb, z, count);
            break;
        case Composition::kZAlphaKey:
            compose_z_alpha_key(local.argb, local.z, argb, z, count);
            break;
        case Composition::kOver:
            compose_over(local.argb, local.z, argb, z, count);
            break;
    }
}

void replicate_span(PixelSpan source, int multiple, int skip, std::uint32_t* argb, std::uint32_t* z,
                    std::size_t count) {
    const auto times = static_cast<std::size_t>(multiple);
    const auto left_out = static_cast<std::size_t>(skip);
    replicate_values(source.argb, times, left_out, argb, count);
    replicate_values(source.z, times, left_out, z, count);
}

void blend_span(Composition composition, std::uint32_t far_z, const BlendSpans& source, std::uint32_t* argb,
                std::size_t count) {
    blend_values(source, far_z, composition == Composition::kZAlphaKey, argb, count);
}

void average_span(const std::uint32_t* argb, int supersample, std::size_t display_width,
                  std::uint32_t* colours) {
    if (supersample == 4) {
        average_4(argb, display_width, colours);
    } else if (supersample == 2) {
        average_2(argb, display_width, colours);
    } else {
        drop_alpha(argb, display_width, colours);
    }
}

}  // namespace metabuffer
