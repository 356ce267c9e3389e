#pragma once

#include <cstdint>
#include <systemc>
#include <vector>

#include "formats/dvi_timing.h"
#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/crossing.h"
#include "rtl/display_signals.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The DVI timing of an output framebuffer (sections 4 and 5.4 of the paper): it drives its display and swaps the two
/// pictures of the display memory, front (shown) and back (written).
///
/// Timing, in the DVI output clock; every output is registered:
///
/// | condition | clock | effect |
/// | --- | --- | --- |
/// | after reset | each | frame follows frame of DviTiming, in step on all displays |
/// | no good frame yet | each | the picture is black |
/// | SWAPLOCK (every FRAMEDONE) rises | 2 later | SWAPLOCK is seen, and SWAPSKIP (any FRAMEBAD) read with it |
/// | SWAPLOCK seen, SWAPSKIP low | first of a DVI frame | the pictures swap; swapped_o rises |
/// | SWAPLOCK seen, SWAPSKIP high | first of a DVI frame | they do not: swapped_o and skipped_o rise, the back picture is free |
/// | SWAPLOCK seen low | the same | swapped_o falls |
/// | a pixel is read from the memory | 2 later | it is on the link |
class DviOutput final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< DVI output clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> swaplock_i{"swaplock_i"};
    In<bool> swapskip_i{"swapskip_i"};  ///< with SWAPLOCK: the frame is not to be shown
    /// FRAMEDONE does not rise again before the core clock has seen this low, so no ratio of the clocks misses a swap.
    Out<bool> swapped_o{"swapped_o"};
    Out<bool> skipped_o{"skipped_o"};  ///< with swapped_o: the display keeps its picture
    Out<bool> reads_o{"reads_o"};      ///< the memory reads read_o
    Out<DisplayRead> read_o{"read_o"};
    In<std::uint32_t> data_i{"data_i"};
    Out<DviLink> link_o{"link_o"};

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
    Register<bool> swap_skipped_{registers_, "swap_skipped"};  ///< of the last swap, or of the pending one
    Register<bool> front_{registers_, "front", 1, true};
    Register<int> front_frame_;
    Register<bool> picture_shown_{registers_, "picture_shown"};  ///< the front picture is a frame
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
