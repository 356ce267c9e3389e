#include "rtl/tmds_encoder.h"

namespace metabuffer::rtl {

TmdsEncoder::TmdsEncoder(const sc_core::sc_module_name& name) : Block(name) {}

void TmdsEncoder::reset() {
    registers_.reset();
    tmds_o.write(tmds_);
}

void TmdsEncoder::clock_edge() {
    const DviLink& link = link_i.read();
    const TmdsLink tmds = link.de ? encode_pixel(link.data) : encode_blanking(link);
    drive_output(tmds_, tmds_o, tmds);
}

TmdsLink TmdsEncoder::encode_pixel(std::uint32_t data) {
    constexpr unsigned kByteBits = 8;
    TmdsLink tmds;
    TmdsDisparities disparity = disparity_;
    for (std::size_t channel = 0; channel < kTmdsChannels; ++channel) {
        const auto byte = static_cast<std::uint8_t>(data >> (kByteBits * channel));
        const TmdsEncoded encoded = encode_tmds(byte, disparity.channels[channel]);
        tmds.channels[channel] = encoded.character;
        disparity.channels[channel] = encoded.disparity;
    }
    disparity_ = disparity;
    return tmds;
}

TmdsLink TmdsEncoder::encode_blanking(const DviLink& link) {
    disparity_ = TmdsDisparities();
    TmdsLink tmds;
    tmds.channels[static_cast<std::size_t>(TmdsChannel::kBlue)] = tmds_control(link.hsync, link.vsync);
    return tmds;
}

void TmdsEncoder::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, link_i.read(), path("DVI_in"));
    registers_.trace(file, path(""));
}

}  // namespace metabuffer::rtl
