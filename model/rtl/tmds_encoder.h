#pragma once

#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The encoder at the sender's end of a DVI link: in a renderer's graphics card, or between an output framebuffer and
/// its display. DVI 1.0 defines the characters (formats/tmds.h); the paper names DVI alone. Only machines with
/// `links.layer: tmds` have it.
///
/// Timing: registered. The characters of a pixel are on tmds_o kTmdsEncoderClocks after the pixel is at link_i. While
/// DE is high, blue, green and red carry the bytes [7:0], [15:8] and [23:16] of the data. While it is low, blue carries
/// HSYNC and VSYNC, and the disparity of each channel starts again from 0. Reset drives control characters.
class TmdsEncoder final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< the link's clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<DviLink> link_i{"link_i"};
    Out<TmdsLink> tmds_o{"tmds_o"};

    explicit TmdsEncoder(const sc_core::sc_module_name& name);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void reset();
    TmdsLink encode_pixel(std::uint32_t data);
    TmdsLink encode_blanking(const DviLink& link);

    RegisterSet registers_;
    Register<TmdsDisparities> disparity_{registers_, "disparity"};
    Register<TmdsLink> tmds_{registers_, "TMDS"};
    Clocked clocked_{*this, clk_i, reset_i, registers_, &TmdsEncoder::clock_edge, &TmdsEncoder::reset};
};

}  // namespace metabuffer::rtl
