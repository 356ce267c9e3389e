#include "functional/pixel_runs.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "functional/vector_loop.h"

namespace metabuffer::functional {

namespace {

// The loops take bare pointers: only then do compilers assume that they do not overlap.

struct TakeOverLink {
    METABUFFER_REFERENCE_LOOP void operator()(const Pixel* __restrict pixels, std::size_t count,
                                              std::uint32_t argb_lost, std::uint32_t z_kept,
                                              std::uint32_t* __restrict argb,
                                              std::uint32_t* __restrict z) const {
        for (std::size_t i = 0; i < count; ++i) {
            argb[i] = static_cast<std::uint32_t>(pixels[i].word()) | argb_lost;
            z[i] = pixels[i].z() & z_kept;
        }
    }
};

struct FillPlanes {
    METABUFFER_REFERENCE_LOOP void operator()(std::uint32_t argb_value, std::uint32_t z_value,
                                              std::size_t count, std::uint32_t* __restrict argb,
                                              std::uint32_t* __restrict z) const {
        for (std::size_t i = 0; i < count; ++i) {
            argb[i] = argb_value;
            z[i] = z_value;
        }
    }
};

struct PlanarPixel {
    std::uint32_t argb;
    std::uint32_t z;
};

// Choices between two pixels are made with masks. Compilers may turn a choice into a branch, or into a store that
// depends on the pixel. That costs several times as much where near and far pixels alternate.

/// All ones if the condition holds, else zero.
inline std::uint32_t mask_of(bool condition) { return 0U - static_cast<std::uint32_t>(condition); }

/// Z has 24 bits, so the comparison may be a signed one, the only one that vector units before AVX-512 have.
inline bool is_nearer(std::uint32_t local_z, std::uint32_t upstream_z) {
    return static_cast<std::int32_t>(local_z) < static_cast<std::int32_t>(upstream_z);
}

inline std::uint32_t nearer_z(std::uint32_t local_z, std::uint32_t upstream_z) {
    return static_cast<std::uint32_t>(
        std::min(static_cast<std::int32_t>(local_z), static_cast<std::int32_t>(upstream_z)));
}

inline std::uint32_t select(std::uint32_t mask, std::uint32_t if_set, std::uint32_t if_clear) {
    return (if_set & mask) | (if_clear & ~mask);
}

struct KeepNearest {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict local_argb,
                                              const std::uint32_t* __restrict local_z, std::size_t count,
                                              std::uint32_t* __restrict argb,
                                              std::uint32_t* __restrict z) const {
        for (std::size_t i = 0; i < count; ++i) {
            const PlanarPixel local{local_argb[i], local_z[i]};
            const PlanarPixel upstream{argb[i], z[i]};
            argb[i] = select(mask_of(is_nearer(local.z, upstream.z)), local.argb, upstream.argb);
            z[i] = nearer_z(local.z, upstream.z);
        }
    }
};

struct KeepNearestUnlessClear {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict local_argb,
                                              const std::uint32_t* __restrict local_z, std::size_t count,
                                              std::uint32_t* __restrict argb,
                                              std::uint32_t* __restrict z) const {
        for (std::size_t i = 0; i < count; ++i) {
            const PlanarPixel local{local_argb[i], local_z[i]};
            const PlanarPixel upstream{argb[i], z[i]};
            const std::uint32_t local_wins =
                mask_of(is_nearer(local.z, upstream.z)) & mask_of((local.argb >> 24) != 0);
            argb[i] = select(local_wins, local.argb, upstream.argb);
            z[i] = select(local_wins, local.z, upstream.z);
        }
    }
};

/// One channel of front + back * (1 - front alpha) in steps of 1/255, saturated. The product is rounded to
/// nearest by an exact division; halves cannot occur because 255 is odd.
inline std::uint32_t over_channel(std::uint32_t front, std::uint32_t back, int shift,
                                  std::uint32_t front_alpha) {
    const std::uint32_t product = ((back >> shift) & 0xFFU) * (255U - front_alpha);
    const std::uint32_t sum = ((front >> shift) & 0xFFU) + (product + 127U) / 255U;
    return std::min(sum, 255U) << shift;
}

struct PremultipliedOver {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict local_argb,
                                              const std::uint32_t* __restrict local_z, std::size_t count,
                                              std::uint32_t* __restrict argb,
                                              std::uint32_t* __restrict z) const {
        for (std::size_t i = 0; i < count; ++i) {
            const PlanarPixel local{local_argb[i], local_z[i]};
            const PlanarPixel upstream{argb[i], z[i]};
            const std::uint32_t local_in_front = mask_of(is_nearer(local.z, upstream.z));
            const std::uint32_t front = select(local_in_front, local.argb, upstream.argb);
            const std::uint32_t back = select(local_in_front, upstream.argb, local.argb);
            const std::uint32_t alpha = front >> 24;
            argb[i] = over_channel(front, back, 24, alpha) | over_channel(front, back, 16, alpha) |
                      over_channel(front, back, 8, alpha) | over_channel(front, back, 0, alpha);
            z[i] = nearer_z(local.z, upstream.z);
        }
    }
};

struct MixSurroundings {
    struct Planes {
        const std::uint32_t* __restrict argb;
        const std::uint32_t* __restrict z;
    };

    METABUFFER_REFERENCE_LOOP static std::uint32_t seen_or_own(std::uint32_t argb, std::uint32_t z,
                                                               std::uint32_t own, std::uint32_t far_z,
                                                               std::uint32_t key_mask) {
        // Without a key every alpha passes.
        const std::uint32_t seen = mask_of(z != far_z) & mask_of(((argb >> 24) | ~key_mask) != 0);
        return select(seen, argb, own);
    }

    METABUFFER_REFERENCE_LOOP void operator()(std::uint32_t key_mask, std::uint32_t far_z, Planes own,
                                              Planes beside, Planes across, Planes diagonal,
                                              const std::uint32_t* __restrict weight_x,
                                              std::uint32_t weight_y, std::size_t count,
                                              std::uint32_t* __restrict argb,
                                              std::uint32_t* __restrict z) const {
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t p = own.argb[i];
            const std::uint32_t px = seen_or_own(beside.argb[i], beside.z[i], p, far_z, key_mask);
            const std::uint32_t py = seen_or_own(across.argb[i], across.z[i], p, far_z, key_mask);
            const std::uint32_t pxy = seen_or_own(diagonal.argb[i], diagonal.z[i], p, far_z, key_mask);
            const std::uint32_t wx = weight_x[i];
            const std::uint32_t of_p = (256 - wx) * (256 - weight_y);
            const std::uint32_t of_px = wx * (256 - weight_y);
            const std::uint32_t of_py = (256 - wx) * weight_y;
            const std::uint32_t of_pxy = wx * weight_y;
            std::uint32_t mixed = 0;
            for (int shift = 0; shift < 32; shift += 8) {
                const std::uint32_t sum = ((p >> shift) & 0xFFU) * of_p + ((px >> shift) & 0xFFU) * of_px +
                                          ((py >> shift) & 0xFFU) * of_py +
                                          ((pxy >> shift) & 0xFFU) * of_pxy + 32768U;
                mixed |= (sum >> 16) << shift;
            }
            // What the key hides must stay hidden, whatever lies around it.
            const std::uint32_t hidden = key_mask & mask_of((p >> 24) == 0);
            argb[i] = select(hidden, p, mixed);
            z[i] = own.z[i];
        }
    }
};

struct JoinPlanes {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict argb,
                                              const std::uint32_t* __restrict z, std::size_t count,
                                              Pixel* __restrict pixels) const {
        for (std::size_t i = 0; i < count; ++i) pixels[i] = Pixel((std::uint64_t{z[i]} << 32) | argb[i]);
    }
};

/// Each value kTimes times. A constant lets the compiler replace the inner loop by shuffles.
template <int kTimes>
struct Repeat {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict values, std::size_t count,
                                              std::uint32_t* __restrict target) const {
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t n = 0; n < kTimes; ++n) target[i * kTimes + n] = values[i];
        }
    }
};

struct DropAlpha {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict argb, std::size_t count,
                                              std::uint32_t* __restrict colours) const {
        for (std::size_t x = 0; x < count; ++x) colours[x] = argb[x] & kColourMask;
    }
};

/// Red and blue are added up in the halves of one word, green in another: sixteen samples of 255 need 12
/// bits.
template <int kSize>
struct AverageSquares {
    METABUFFER_REFERENCE_LOOP void operator()(const std::uint32_t* __restrict argb, std::size_t stride,
                                              std::size_t count, std::uint32_t* __restrict colours) const {
        constexpr std::uint32_t kRedBlue = 0xFF'00FFU;
        constexpr std::uint32_t kSamples = kSize * kSize;
        constexpr int kShift = kSize == 2 ? 2 : 4;
        static_assert(kSamples == 1U << kShift);
        for (std::size_t x = 0; x < count; ++x) {
            std::uint32_t red_blue = (kSamples / 2) * 0x1'0001U;
            std::uint32_t green = kSamples / 2;
            for (std::size_t j = 0; j < kSize; ++j) {
                for (std::size_t i = 0; i < kSize; ++i) {
                    const std::uint32_t sample = argb[j * stride + x * kSize + i];
                    red_blue += sample & kRedBlue;
                    green += (sample >> 8) & 0xFFU;
                }
            }
            colours[x] = ((red_blue >> kShift) & kRedBlue) | ((green >> kShift) << 8);
        }
    }
};

}  // namespace

void take_over_link(const Pixel* pixels, std::size_t count, DepthFormat format, TargetRun target) {
    const DepthLayout& layout = layout_of(format);
    const std::uint32_t argb_lost = layout.has_alpha() ? 0U : 0xFF00'0000U;
    const std::uint32_t z_kept = 0xFF'FFFFU >> (kColourBits - layout.z_bits);
    run_loop(TakeOverLink{}, pixels, count, argb_lost, z_kept, target.argb, target.z);
}

void replicate(const std::uint32_t* values, std::size_t count, int multiple, std::uint32_t* target) {
    switch (multiple) {
        case 2:
            return run_loop(Repeat<2>{}, values, count, target);
        case 3:
            return run_loop(Repeat<3>{}, values, count, target);
        case 4:
            return run_loop(Repeat<4>{}, values, count, target);
        default:
            for (std::size_t i = 0; i < count; ++i) target = std::fill_n(target, multiple, values[i]);
    }
}

void fill(Pixel pixel, std::size_t count, TargetRun target) {
    run_loop(FillPlanes{}, static_cast<std::uint32_t>(pixel.word()), pixel.z(), count, target.argb, target.z);
}

void merge(Composition composition, SourceRun local, std::size_t count, TargetRun pipeline) {
    switch (composition) {
        case Composition::kZ:
            return run_loop(KeepNearest{}, local.argb, local.z, count, pipeline.argb, pipeline.z);
        case Composition::kZAlphaKey:
            return run_loop(KeepNearestUnlessClear{}, local.argb, local.z, count, pipeline.argb, pipeline.z);
        case Composition::kOver:
            return run_loop(PremultipliedOver{}, local.argb, local.z, count, pipeline.argb, pipeline.z);
    }
}

void mix(Composition composition, std::uint32_t far_z, const Surroundings& source, std::size_t count,
         TargetRun target) {
    const auto planes = [](const SourceRun& run) { return MixSurroundings::Planes{run.argb, run.z}; };
    run_loop(MixSurroundings{}, mask_of(composition == Composition::kZAlphaKey), far_z, planes(source.own),
             planes(source.beside), planes(source.across), planes(source.diagonal), source.weight_x,
             source.weight_y, count, target.argb, target.z);
}

void join(SourceRun source, std::size_t count, Pixel* pixels) {
    run_loop(JoinPlanes{}, source.argb, source.z, count, pixels);
}

void average(const std::uint32_t* argb, std::size_t stride, int supersample, std::size_t count,
             std::uint32_t* colours) {
    switch (supersample) {
        case 1:
            return run_loop(DropAlpha{}, argb, count, colours);
        case 2:
            return run_loop(AverageSquares<2>{}, argb, stride, count, colours);
        case 4:
            return run_loop(AverageSquares<4>{}, argb, stride, count, colours);
        default:
            throw std::invalid_argument("supersample " + std::to_string(supersample) + " is not 1, 2 or 4");
    }
}

}  // namespace metabuffer::functional
