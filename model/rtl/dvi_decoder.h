#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datapath/link/pair_follower.h"
#include "formats/dvi_timing.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The DVI frame decoder between a renderer's link and its input framebuffer (section 4 of the paper). It finds frames
/// from VSYNC and DE, colour and depth from the control scanline, and pairs from the frame numbers (PairFollower).
///
/// Timing; all outputs are registered:
///
/// | what the edge reads | what is driven at that edge |
/// | --- | --- |
/// | a pixel of the image | pixel_o |
/// | three bytes of a depth frame's control scanline | event_o: payload (the slot table) |
/// | DE low after a colour frame's control scanline | event_o: its verdict; then a table row at each edge |
/// | DE low after a depth frame's control scanline | event_o: its verdict |
/// | VSYNC high after a frame | event_o: the frame's verdict |
///
/// Rejects and counts, by cause: a frame of the wrong geometry; a control scanline with a bad magic, version, CRC or
/// kind; a pair whose two numbers differ or that lacks a frame. After a rejection the decoder ignores everything up to
/// the next good colour frame.
class DviDecoder final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< DVI input clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<DviLink> link_i{"link_i"};
    Out<DecodedPixel> pixel_o{"pixel_o"};
    Out<DecoderEvent> event_o{"event_o"};

    /// timing: the mode of the renderer's link.
    DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    const std::array<std::int64_t, kRejectCauseCount>& rejected_frames() const { return pairs_->rejected(); }

  private:
    void clock_edge();
    void reset();
    void take_pixel(std::uint32_t data, DecodedPixel& pixel, DecoderEvent& event);
    void pass_payload(std::uint32_t data, DecoderEvent& event);
    void end_line(DecoderEvent& event);
    void end_control_scanline(DecoderEvent& event);
    void end_frame(DecoderEvent& event);

    DviTiming timing_;

    // Two memories. Reset empties them, as it resets all registers.
    std::vector<std::uint32_t> control_;  ///< the scanline under way
    ViewportTable table_;                 ///< its rows from next_row_ on are still to be reported

    RegisterSet registers_;
    Register<PairFollower> pairs_{registers_, "pair"};
    Register<bool> previous_de_{registers_, "previous_de"};
    Register<bool> previous_vsync_{registers_, "previous_vsync"};
    Register<int> x_;
    Register<int> line_;
    Register<std::uint32_t> next_row_{registers_, "next_row", 16};
    Register<int> payload_at_;  ///< byte of the scanline at which the payload's length begins
    Register<std::uint32_t> payload_left_{registers_, "payload_left", 16};  ///< bytes still to pass
    Register<DecodedPixel> pixel_;
    Register<DecoderEvent> event_{registers_, "event"};
    Register<bool> event_pending_{registers_, "event_pending"};  ///< event_o must be cleared
    Clocked clocked_{*this, clk_i, reset_i, registers_, &DviDecoder::clock_edge, &DviDecoder::reset};
};

}  // namespace metabuffer::rtl
