#pragma once

#include <cstdint>

#include "datapath/composer_buffer.h"
#include "rtl/fields.h"
#include "rtl/register.h"
#include "scenario/scenario.h"

/// The values that the wires between a composer's parts carry, besides those of its FIFO (rtl/signals.h).
namespace metabuffer::rtl {

/// Bits of the index of a segment's pixel, or of none.
inline int segment_pixel_bits(const Scenario& scenario) {
    const DisplayConfig& displays = scenario.displays;
    return 1 + bits_for(most_segment_pixels(displays.raster_width_pixels(), displays.raster_height_pixels()));
}

/// Where the frame's pixels lie on the raster: of the frame that is composited, or is next.
struct HeadSegment {
    bool shown = false;  ///< false: none of it does
    Segment segment;

    template <typename See>
    static void visit_fields(const See& see) {
        see("shown", &HeadSegment::shown);
        const auto see_row = [&see](const char* name, auto member, int bits = kAllBits) {
            const auto access = [member](const HeadSegment& of) -> auto& { return of.segment.row().*member; };
            see(name, access, bits);
        };
        see_row("width", &ViewportRow::sdx);
        see_row("height", &ViewportRow::sdy);
        see_row("x", &ViewportRow::dx);
        see_row("y", &ViewportRow::dy);
        see_row("multiple", &ViewportRow::dmultiple, bits_for(kMaximumMultiple));
    }
};
inline bool operator==(const HeadSegment& a, const HeadSegment& b) {
    // Raster and smoothing are the composer's, so the row decides.
    return a.shown == b.shown && a.segment.row() == b.segment.row();
}

/// What has come of that segment.
struct SegmentProgress {
    bool abandoned = false;          ///< pixels or rows of the frame were lost: nothing of it shows any more
    std::int64_t arrived = 0;        ///< pixels, in their order
    std::uint32_t base_address = 0;  ///< of pixel 0 in the FIFO

    bool has_arrived(std::int64_t pixel) const { return pixel < arrived; }

    /// Without the address, which the receiver has among its registers.
    template <typename See>
    static void visit_fields(const See& see, int pixel_bits = kAllBits) {
        see("abandoned", &SegmentProgress::abandoned);
        see("arrived", &SegmentProgress::arrived, pixel_bits);
        see("base_address", &SegmentProgress::base_address, kUntraced);
    }
};

/// What is not needed any more after the position that is composited next: the pixels up to last_use, if that is one, and
/// the frame.
struct PixelUse {
    bool ends_frame = false;
    std::int64_t last_use = Segment::kNoPixel;

    bool any() const { return ends_frame || last_use != Segment::kNoPixel; }

    template <typename See>
    static void visit_fields(const See& see, int pixel_bits = kAllBits) {
        see("ends_frame", &PixelUse::ends_frame);
        see("last_use", &PixelUse::last_use, pixel_bits);
    }
};

}  // namespace metabuffer::rtl
