#include "rtl/composer_signals.h"

#include "rtl/register.h"

namespace metabuffer::rtl {
namespace {

constexpr int kRasterBits = 16;
constexpr int kWeightBits = bits_for(kWholeWeight / 2);

}  // namespace

int segment_pixel_bits(const Scenario& scenario) {
    const DisplayConfig& displays = scenario.displays;
    return 1 + bits_for(most_segment_pixels(displays.raster_width_pixels(), displays.raster_height_pixels()));
}

std::ostream& operator<<(std::ostream& out, const HeadSegment& value) {
    if (!value.shown) {
        return out << "no segment";
    }
    const ViewportRow& row = value.segment.row();
    return out << row.sdx << 'x' << row.sdy << " pixels at " << row.dx << ',' << row.dy << ", each "
               << row.dmultiple << 'x' << row.dmultiple;
}

void sc_trace(sc_core::sc_trace_file* file, const HeadSegment& value, const std::string& name) {
    sc_core::sc_trace(file, value.shown, name + ".shown");
    const ViewportRow& row = value.segment.row();
    sc_core::sc_trace(file, row.sdx, name + ".width", kRasterBits);
    sc_core::sc_trace(file, row.sdy, name + ".height", kRasterBits);
    sc_core::sc_trace(file, row.dx, name + ".x", kRasterBits);
    sc_core::sc_trace(file, row.dy, name + ".y", kRasterBits);
    sc_core::sc_trace(file, row.dmultiple, name + ".multiple", bits_for(kMaximumMultiple));
}

std::ostream& operator<<(std::ostream& out, const SegmentProgress& value) {
    return out << value.arrived << " pixels from address " << value.base_address << " on"
               << (value.abandoned ? ", abandoned" : "");
}

void sc_trace(sc_core::sc_trace_file* file, const SegmentProgress& value, const std::string& name,
              int pixel_bits) {
    sc_core::sc_trace(file, value.abandoned, name + ".abandoned");
    trace_number(file, value.arrived, name + ".arrived", pixel_bits);
}

std::ostream& operator<<(std::ostream& out, const PixelUse& value) {
    if (value.last_use == Segment::kNoPixel) {
        out << "no pixel's last use";
    } else {
        out << "last use of pixel " << value.last_use;
    }
    return out << (value.ends_frame ? ", the frame's end" : "");
}

void sc_trace(sc_core::sc_trace_file* file, const PixelUse& value, const std::string& name, int pixel_bits) {
    sc_core::sc_trace(file, value.ends_frame, name + ".ends_frame");
    trace_number(file, value.last_use, name + ".last_use", pixel_bits, true);
}

}  // namespace metabuffer::rtl

namespace metabuffer {

std::ostream& operator<<(std::ostream& out, const RasterStep& value) {
    out << (value.last ? "last position, " : "");
    if (!value.covered) {
        return out << "not covered";
    }
    return out << "pixel " << value.pixel << (value.replayed ? " again" : "") << ", beside " << value.beside
               << " weighs " << int{value.weight_x} << ", across " << value.across << " weighs "
               << int{value.weight_y};
}

void sc_trace(sc_core::sc_trace_file* file, const RasterStep& value, const std::string& name,
              int pixel_bits) {
    sc_core::sc_trace(file, value.last, name + ".last");
    sc_core::sc_trace(file, value.covered, name + ".covered");
    sc_core::sc_trace(file, value.replayed, name + ".replayed");
    rtl::trace_number(file, value.pixel, name + ".pixel", pixel_bits);
    rtl::trace_number(file, value.beside, name + ".beside", 2, true);
    rtl::trace_number(file, value.across, name + ".across", rtl::kRasterBits + 1, true);
    sc_core::sc_trace(file, value.weight_x, name + ".weight_x", rtl::kWeightBits);
    sc_core::sc_trace(file, value.weight_y, name + ".weight_y", rtl::kWeightBits);
}

}  // namespace metabuffer
