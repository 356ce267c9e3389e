#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <systemc>

#include "datapath/segment.h"
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

/// What a raster position shows of the segment.
struct RasterStep {
    std::int64_t pixel = 0;
    // Of a smoothed segment: the pixels that are mixed here besides.
    std::int32_t across = 0;  ///< from a pixel of this source row to that of the other one; 0: none
    std::int32_t beside = 0;  ///< -1: the pixel before; 1: the one after; 0: neither
    std::uint8_t weight_x = 0;
    std::uint8_t weight_y = 0;
    bool last = false;      ///< the raster's last position
    bool covered = false;   ///< the segment shows here; else all but `last` is 0
    bool replayed = false;  ///< its source row is shown for the second time or a later one

    BlendWindow<std::int64_t> window() const;
    /// The newest pixel that is needed here.
    std::int64_t newest() const { return pixel + (across > 0 ? across : 0) + (beside > 0 ? 1 : 0); }
};
inline bool operator==(const RasterStep& a, const RasterStep& b) {
    return a.pixel == b.pixel && a.across == b.across && a.beside == b.beside && a.weight_x == b.weight_x &&
           a.weight_y == b.weight_y && a.last == b.last && a.covered == b.covered && a.replayed == b.replayed;
}
std::ostream& operator<<(std::ostream& out, const RasterStep& value);
void sc_trace(sc_core::sc_trace_file* file, const RasterStep& value, const std::string& name,
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
