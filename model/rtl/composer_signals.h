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

/// The segment of the head frame: the frame that is composited, or comes next.
struct HeadSegment {
    bool shown = false;  ///< the head frame has a segment here
    Segment segment;     ///< only if shown

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

/// How much of the head frame's segment has come.
struct SegmentProgress {
    bool abandoned = false;    ///< pixels or table rows of the frame were lost: its segment no longer shows
    std::int64_t arrived = 0;  ///< pixels 0 to arrived - 1 have come
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

/// What the raster position that is composited next uses for the last time.
struct PixelUse {
    bool ends_frame = false;                    ///< the position is the frame's last
    std::int64_t last_use = Segment::kNoPixel;  ///< the segment's pixels up to this one

    bool any() const { return ends_frame || last_use != Segment::kNoPixel; }

    template <typename See>
    static void visit_fields(const See& see, int pixel_bits = kAllBits) {
        see("ends_frame", &PixelUse::ends_frame);
        see("last_use", &PixelUse::last_use, pixel_bits);
    }
};

}  // namespace metabuffer::rtl
