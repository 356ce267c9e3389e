#pragma once

#include <cstdint>
#include <systemc>
#include <vector>

#include "formats/dvi_timing.h"
#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/display_signals.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The DVI timing of an output framebuffer (sections 4 and 5.4 of the paper): it drives its display and swaps the banks of
/// the display's memory.
///
/// Timing, in the DVI output clock; every output is registered. Frame follows frame of DviTiming from reset on, in step on
/// all displays. SWAPLOCK (every FRAMEDONE) crosses through two registers; if it has been seen by the first clock of a
/// DVI frame, the banks swap there. SWAPSKIP (any FRAMEBAD) is stable while SWAPLOCK is high, and is read where SWAPLOCK is
/// seen. If it is high, the display keeps its picture, and the new frame's bank is free again. Before the first swap with
/// a good frame the display is black. The memory is read two clocks before its pixel is on the link.
class DviOutput final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< DVI output clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> swaplock_i{"swaplock_i"};
    sc_core::sc_in<bool> swapskip_i{"swapskip_i"};  ///< with SWAPLOCK: the frame is not to be shown
    /// High from a swap until SWAPLOCK has been seen low. FRAMEDONE does not rise again before this has been seen low in
    /// turn, so no swap is missed whatever the ratio of the clocks.
    sc_core::sc_out<bool> swapped_o{"swapped_o"};
    sc_core::sc_out<bool> skipped_o{"skipped_o"};  ///< with swapped_o: the display keeps its picture
    sc_core::sc_out<bool> reads_o{"reads_o"};      ///< the pixel of read_o is to be put out
    sc_core::sc_out<DisplayRead> read_o{"read_o"};
    sc_core::sc_in<std::uint32_t> data_i{"data_i"};
    sc_core::sc_out<DviLink> link_o{"link_o"};

    DviOutput(const sc_core::sc_module_name& name, const Scenario& scenario);

    void trace(sc_core::sc_trace_file* file) const override;

    /// Number of the composited frame that is on the display, -1: none yet.
    int front_frame() const { return front_frame_; }
    /// The swap to each frame since the last reset.
    const std::vector<Swap>& swaps() const { return swaps_; }
    /// Frames that were not shown because pixels of them were lost.
    std::int64_t kept_frames() const { return kept_frames_; }

  private:
    void clock_edge();
    void reset();
    void follow_swaplock();
    void start_line();
    void start_frame();
    void read_ahead();
    void drive_link();
    bool is_active(int line) const {
        return line >= DviTiming::kVerticalBackLines &&
               line < DviTiming::kVerticalBackLines + timing_.active_lines;
    }

    DviTiming timing_;

    RegisterSet registers_;
    Synchronizer swaplock_{registers_, "swaplock"};
    Register<bool> swapped_{registers_, "swapped"};
    Register<bool> swap_pending_{registers_, "swap_pending"};
    Register<bool> swap_skipped_{registers_,
                                 "swap_skipped"};  ///< the last swap, or the pending one, shows nothing new
    Register<bool> front_{registers_, "front", 1, true};
    Register<int> front_frame_;
    Register<bool> picture_shown_{registers_, "picture_shown"};  ///< the front bank holds a frame
    Register<int> x_;
    Register<int> line_;
    Register<bool> active_line_{registers_, "active_line"};
    Register<bool> vsync_line_{registers_, "vsync_line"};
    Register<std::uint32_t> next_read_;
    Register<bool> reads_{registers_, "reads"};
    Register<DisplayRead> read_;
    Register<DviLink> link_{registers_, "link"};

    // What a report says of the run.
    std::int64_t kept_frames_ = 0;
    std::vector<Swap> swaps_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &DviOutput::clock_edge, &DviOutput::reset};
};

}  // namespace metabuffer::rtl
