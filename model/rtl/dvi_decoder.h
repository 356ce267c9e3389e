#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datapath/link/pair_follower.h"
#include "formats/dvi_timing.h"
#include "rtl/block.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The DVI frame decoder between a renderer's link and its input framebuffer (section 4 of the paper): finds
/// frames from VSYNC and DE, colour and depth from the control scanline, and pairs from the frame numbers
/// (PairFollower).
///
/// Timing, all outputs registered: a pixel on the link at one clock is on pixel_o after the next. The verdict
/// on the control scanline is on event_o after the clock that sees DE fall behind it, and the table's rows
/// follow one a clock. The verdict on a frame is on event_o after the clock that sees VSYNC rise behind it.
///
/// Rejects and counts, by cause: a frame of the wrong geometry, a control scanline with a bad magic, version,
/// CRC or kind, a pair whose two numbers differ or that lacks a frame. After a rejection it ignores
/// everything up to the next good colour frame.
class DviDecoder final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< DVI input clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<DviLink> link_i{"link_i"};
    sc_core::sc_out<DecodedPixel> pixel_o{"pixel_o"};
    sc_core::sc_out<DecoderEvent> event_o{"event_o"};

    /// timing: the mode of the renderer's link.
    DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing);
    SC_HAS_PROCESS(DviDecoder);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    const std::array<std::int64_t, kRejectCauseCount>& rejected_frames() const { return pairs_.rejected(); }

  private:
    void clock_edge();
    void reset();
    void take_pixel(std::uint32_t data);
    void end_line();
    void end_control_scanline();
    void end_frame();

    DviTiming timing_;

    PairFollower pairs_;
    bool previous_de_ = false;
    bool previous_vsync_ = false;
    int x_ = 0;
    int line_ = 0;
    std::vector<std::uint32_t> control_;
    ViewportTable table_;
    std::size_t next_row_ = 0;
    DecodedPixel pixel_;
    DecoderEvent event_;
    bool event_pending_ = false;  ///< event_o must be written: it changes or has to be taken back
};

}  // namespace metabuffer::rtl
