#include "rtl/tmds_encoder.h"

namespace metabuffer::rtl {

TmdsEncoder::TmdsEncoder(const sc_core::sc_module_name& name, ClockGating gating)
    : Block(name), gate_(gating) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void TmdsEncoder::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= link_i.value_changed_event();
}

void TmdsEncoder::clock_edge() {
    if (gate_.opened()) {
        return;
    }
    if (reset_i.read()) {
        registers_.reset();
        tmds_o.write(tmds_);
        return;
    }
    const DviLink& link = link_i.read();
    const TmdsLink tmds = link.de ? encode_pixel(link.data) : encode_blanking(link);
    const bool changes = !(tmds == tmds_.value());
    if (changes) {
        tmds_ = tmds;
        tmds_o.write(tmds_);
    }
    if (gate_.idle_edge(!link.de && !changes)) {
        next_trigger(wake_events_);
    }
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
