#pragma once

#include <array>
#include <cstdint>

#include "datapath/composition.h"
#include "formats/pixel.h"
#include "formats/smoothing.h"
#include "formats/viewport_table.h"

/// Bilinear smoothing as a composer's hardware does it (section 5.2 of the paper): weights that are counted, and the
/// mixture of four pixels.
namespace metabuffer {

/// A weight of 1.
constexpr int kWholeWeight = 256;

/// floor(t / m), for t = 128 d with d up to 254 or t = 256, without a divider: a table of 255 reciprocals, and a product.
class BlendReciprocals {
  public:
    constexpr BlendReciprocals() {
        for (std::uint32_t m = 1; m <= kMaximumMultiple; ++m) {
            reciprocals_[m] = ((kWholeWeight / 2U << kFractionBits) + m - 1) / m;
        }
    }
    /// floor(128 d / m); exact, since d * m is less than 2^16.
    constexpr int quotient(int d, int m) const {
        return static_cast<int>((static_cast<std::uint32_t>(d) * reciprocals_[static_cast<std::size_t>(m)]) >>
                                kFractionBits);
    }

  private:
    static constexpr int kFractionBits = 16;
    std::array<std::uint32_t, kMaximumMultiple + 1> reciprocals_{};
};
inline constexpr BlendReciprocals kBlendReciprocals;

/// One axis of the smoothing, counted from raster pixel to raster pixel. Raster pixel i of a source pixel's block of m
/// lies d = |2i + 1 - m| halves of a raster pixel from the block's centre. Its weight of the neighbour on that side is
/// floor(256 d / 2m): d changes by 2 a step, so the weight by floor(256 / m), and by one more when the remainder
/// carries.
class BlendCounter {
  public:
    BlendCounter() = default;
    /// multiple: 1 to 255; phase: i at the start.
    BlendCounter(int multiple, int phase) : multiple_(multiple), phase_(phase) {
        const int distance = 2 * phase + 1 < multiple ? multiple - 1 - 2 * phase : 2 * phase + 1 - multiple;
        weight_ = kBlendReciprocals.quotient(distance, multiple);
        remainder_ = kWholeWeight / 2 * distance - weight_ * multiple;
        weight_step_ = kBlendReciprocals.quotient(2, multiple);
        remainder_step_ = kWholeWeight - weight_step_ * multiple;
    }

    /// Weight of the neighbour, of 256; less than 128.
    const int& weight() const { return weight_; }
    /// Where the neighbour is: -1 before, 1 after, 0 nowhere, in the very centre.
    int side() const { return 2 * phase_ + 1 < multiple_ ? -1 : (2 * phase_ + 1 > multiple_ ? 1 : 0); }
    int phase() const { return phase_; }

    /// Goes to the next raster pixel; after a block's last comes the next block's first.
    void step() {
        if (++phase_ == multiple_) {
            phase_ = 0;  // as far from its block's centre
        } else if (2 * phase_ + 1 <= multiple_) {
            weight_ -= weight_step_;
            remainder_ -= remainder_step_;
            if (remainder_ < 0) {
                remainder_ += multiple_;
                --weight_;
            }
        } else if (2 * phase_ - 1 >= multiple_) {
            weight_ += weight_step_;
            remainder_ += remainder_step_;
            if (remainder_ >= multiple_) {
                remainder_ -= multiple_;
                ++weight_;
            }
        }  // else: across the centre of an even block, nothing changes
    }

    /// Calls see(name, value, largest value) for each register, or with the smallest value too.
    template <typename See>
    void visit_state(const See& see) const {
        see("multiple", multiple_, kMaximumMultiple);
        see("phase", phase_, kMaximumMultiple - 1);
        see("weight", weight_, kWholeWeight / 2);
        see("remainder", remainder_, kMaximumMultiple, -kMaximumMultiple);
        see("weight_step", weight_step_, kWholeWeight);
        see("remainder_step", remainder_step_, kMaximumMultiple);
    }

  private:
    int multiple_ = 1;
    int phase_ = 0;
    int weight_ = 0;
    int remainder_ = 0;
    int weight_step_ = kWholeWeight;
    int remainder_step_ = 0;
};

/// The source pixels that a raster pixel is mixed of: its own one, those beside it in its source row and across in the
/// other one, and the one that is both.
template <typename Value>
struct BlendWindow {
    Value own{};
    Value beside{};
    Value across{};
    Value diagonal{};
};

/// A viewer does not see a pixel at the far plane, nor a transparent one where that is the key.
constexpr bool is_seen(Pixel pixel, Composition composition, std::uint32_t far_z) {
    return pixel.z() != far_z && (composition != Composition::kZAlphaKey || pixel.a() != 0);
}

namespace detail {

constexpr std::uint8_t blend_channel(const BlendWindow<int>& of, int weight_x, int weight_y) {
    const int own_row = of.own * (kWholeWeight - weight_x) + of.beside * weight_x;
    const int other_row = of.across * (kWholeWeight - weight_x) + of.diagonal * weight_x;
    return static_cast<std::uint8_t>(
        (own_row * (kWholeWeight - weight_y) + other_row * weight_y + kWholeWeight * kWholeWeight / 2) /
        (kWholeWeight * kWholeWeight));
}

}  // namespace detail

/// The local pixel of a raster pixel: colour and alpha mixed, Z of its own source pixel. A neighbour that is not seen
/// counts as the own pixel. A pixel that the key hides stays hidden.
constexpr Pixel blend(const BlendWindow<Pixel>& window, int weight_x, int weight_y, Composition composition,
                      std::uint32_t far_z) {
    const Pixel own = window.own;
    if (composition == Composition::kZAlphaKey && own.a() == 0) return own;
    const Pixel beside = is_seen(window.beside, composition, far_z) ? window.beside : own;
    const Pixel across = is_seen(window.across, composition, far_z) ? window.across : own;
    const Pixel diagonal = is_seen(window.diagonal, composition, far_z) ? window.diagonal : own;
    return {detail::blend_channel({own.r(), beside.r(), across.r(), diagonal.r()}, weight_x, weight_y),
            detail::blend_channel({own.g(), beside.g(), across.g(), diagonal.g()}, weight_x, weight_y),
            detail::blend_channel({own.b(), beside.b(), across.b(), diagonal.b()}, weight_x, weight_y),
            detail::blend_channel({own.a(), beside.a(), across.a(), diagonal.a()}, weight_x, weight_y),
            own.z()};
}

}  // namespace metabuffer
