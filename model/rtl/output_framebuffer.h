#pragma once

#include <cstdint>
#include <string>
#include <systemc>
#include <vector>

#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/display_memory.h"
#include "rtl/display_signals.h"
#include "rtl/dvi_output.h"
#include "rtl/frame_averager.h"
#include "rtl/signals.h"
#include "rtl/wire.h"

namespace metabuffer::rtl {

/// An output framebuffer, box D of the paper's Figure 1 (sections 2, 4, 5.4 and 7). It receives the pixels that leave its
/// pipeline and drives its display over DVI. It is made of
///
/// - frame_averager, in core clocks: receives the raster, averages it, corrects its colours, raises PIPEREADY, FRAMEDONE
///   and FRAMEBAD;
/// - display_memory: two pictures, front and back;
/// - dvi_output, in DVI output clocks: the display's timing, and the swap of the pictures.
///
/// Their headers say what each does at which clock.
class OutputFramebuffer final : public Block {
  public:
    In<bool> clk_i{"clk_i"};          ///< core clock
    In<bool> reset_i{"reset_i"};      ///< synchronous in both domains, active high
    In<bool> dvi_clk_i{"dvi_clk_i"};  ///< DVI output clock
    In<bool> startframe_i{"startframe_i"};
    In<PipePixel> pipe_i{"pipe_i"};
    In<bool> column_stall_i{"column_stall_i"};
    Out<bool> pipeready_o{"pipeready_o"};
    Out<bool> framedone_o{"framedone_o"};
    Out<bool> framebad_o{"framebad_o"};  ///< with FRAMEDONE: pixels of the frame were lost
    In<bool> swaplock_i{"swaplock_i"};
    In<bool> swapskip_i{"swapskip_i"};  ///< with SWAPLOCK: the frame is not to be shown
    Out<DviLink> link_o{"link_o"};

    /// display: its own, from 1.
    OutputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario, int display);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override { return frame_averager_.waiting_for(); }

    /// Number of the composited frame that is on the display, -1: none yet.
    int front_frame() const { return dvi_output_.front_frame(); }
    /// The swap to each frame since the last reset.
    const std::vector<Swap>& swaps() const { return dvi_output_.swaps(); }
    std::int64_t stalled_cycles() const { return frame_averager_.stalled_cycles(); }
    /// Frames that were not shown because pixels of them were lost.
    std::int64_t kept_frames() const { return dvi_output_.kept_frames(); }
    /// Raster pixels received so far, for the watchdog.
    std::int64_t pixels_taken() const { return frame_averager_.pixels_taken(); }

  private:
    Wire<bool> writes_{"writes"};
    Wire<DisplayWrite> write_{"write"};
    Wire<bool> reads_{"reads"};
    Wire<DisplayRead> read_{"read"};
    Wire<std::uint32_t> data_{"data"};
    Wire<bool> swapped_{"swapped"};
    Wire<bool> skipped_{"skipped"};
    FrameAverager frame_averager_;
    DisplayMemory display_memory_;
    DviOutput dvi_output_;
};

}  // namespace metabuffer::rtl
