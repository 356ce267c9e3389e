#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <systemc>

#include "datapath/composer_buffer.h"
#include "scenario/scenario.h"

/// The values that the wires between a composer's parts carry, besides those of its FIFO (rtl/signals.h).
namespace metabuffer::rtl {

/// Bits of the index of any segment's pixel, or of none, where nobody says which raster it is for.
constexpr int kSegmentPixelBits = 34;

/// Bits of the index of a segment's pixel, or of none.
int segment_pixel_bits(const Scenario& scenario);

/// Where the frame's pixels lie on the raster: of the frame that is composited, or is next.
struct HeadSegment {
    bool shown = false;  ///< false: none of it does
    Segment segment;
};
inline bool operator==(const HeadSegment& a, const HeadSegment& b) {
    // Raster and smoothing are the composer's, so the row decides.
    return a.shown == b.shown && a.segment.row() == b.segment.row();
}
std::ostream& operator<<(std::ostream& out, const HeadSegment& value);
void sc_trace(sc_core::sc_trace_file* file, const HeadSegment& value, const std::string& name);

/// What has come of that segment.
struct SegmentProgress {
    bool abandoned = false;          ///< pixels or rows of the frame were lost: nothing of it shows any more
    std::int64_t arrived = 0;        ///< pixels, in their order
    std::uint32_t base_address = 0;  ///< of pixel 0 in the FIFO

    bool has_arrived(std::int64_t pixel) const { return pixel < arrived; }
};
inline bool operator==(const SegmentProgress& a, const SegmentProgress& b) {
    return a.abandoned == b.abandoned && a.arrived == b.arrived && a.base_address == b.base_address;
}
std::ostream& operator<<(std::ostream& out, const SegmentProgress& value);
/// Without the address, which the receiver has among its registers.
void sc_trace(sc_core::sc_trace_file* file, const SegmentProgress& value, const std::string& name,
              int pixel_bits = kSegmentPixelBits);

/// What is not needed any more after the position that is composited next: the pixels up to last_use, if that is one, and
/// the frame.
struct PixelUse {
    bool ends_frame = false;
    std::int64_t last_use = Segment::kNoPixel;

    bool any() const { return ends_frame || last_use != Segment::kNoPixel; }
};
inline bool operator==(const PixelUse& a, const PixelUse& b) {
    return a.ends_frame == b.ends_frame && a.last_use == b.last_use;
}
std::ostream& operator<<(std::ostream& out, const PixelUse& value);
void sc_trace(sc_core::sc_trace_file* file, const PixelUse& value, const std::string& name,
              int pixel_bits = kSegmentPixelBits);

}  // namespace metabuffer::rtl

// Found by the namespace of its argument, which is a plain structure of model/datapath.
namespace metabuffer {

std::ostream& operator<<(std::ostream& out, const RasterStep& value);
void sc_trace(sc_core::sc_trace_file* file, const RasterStep& value, const std::string& name,
              int pixel_bits = rtl::kSegmentPixelBits);

}  // namespace metabuffer
