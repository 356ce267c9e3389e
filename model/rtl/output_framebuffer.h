#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "datapath/averaging.h"
#include "formats/colour_table.h"
#include "formats/dvi_timing.h"
#include "formats/image.h"
#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// An output framebuffer, box D of the paper's Figure 1 (sections 2, 4, 5.4 and 7). It receives the pixels that leave its
/// pipeline, averages them, corrects their colours if the scenario has a table for its display, stores them in two
/// banks, and drives its display over DVI. The table is configuration, like the size of the raster: it is there before
/// reset and never changes, so it is a memory and not a register, and costs no clock.
///
/// Timing: in the core clock, the raster's first pixel is received at the edge after the one that sees STARTFRAME, and
/// edges with COLUMNSTALL high do not count (`stall` mode only). A display pixel is stored with its block's last raster
/// pixel. FRAMEDONE rises after the edge that receives the raster's last pixel and falls once the swap is reported
/// back. PIPEREADY is high while a bank is free and no frame is under way. In the DVI output clock, frame follows frame
/// of DviTiming from reset on, in step on all displays. SWAPLOCK (every FRAMEDONE) crosses through two registers; if it
/// has been seen by the first clock of a DVI frame, the banks swap there. FRAMEBAD rises with the first pixel marked
/// `lost` and falls when the swap has been reported back. So SWAPSKIP (any FRAMEBAD) is stable while SWAPLOCK is high,
/// and is read where SWAPLOCK is seen. If it is high, the display keeps its picture, and the new frame's bank is free
/// again. Before the first swap with a good frame the display is black.
class OutputFramebuffer final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};          ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};      ///< synchronous in both domains, active high
    sc_core::sc_in<bool> dvi_clk_i{"dvi_clk_i"};  ///< DVI output clock
    sc_core::sc_in<bool> startframe_i{"startframe_i"};
    sc_core::sc_in<PipePixel> pipe_i{"pipe_i"};
    sc_core::sc_in<bool> column_stall_i{"column_stall_i"};
    sc_core::sc_out<bool> pipeready_o{"pipeready_o"};
    sc_core::sc_out<bool> framedone_o{"framedone_o"};
    sc_core::sc_out<bool> framebad_o{"framebad_o"};  ///< with FRAMEDONE: pixels of the frame were lost
    sc_core::sc_in<bool> swaplock_i{"swaplock_i"};
    sc_core::sc_in<bool> swapskip_i{"swapskip_i"};  ///< with SWAPLOCK: the frame is not to be shown
    sc_core::sc_out<DviLink> link_o{"link_o"};

    /// display: its own, from 1.
    OutputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
                      ClockGating gating = ClockGating::kOn);
    SC_HAS_PROCESS(OutputFramebuffer);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// Number of the composited frame that is on the display, -1: none yet.
    int front_frame() const { return front_frame_; }
    /// The swap to each frame since the last reset.
    const std::vector<Swap>& swaps() const { return swaps_; }
    std::int64_t stalled_cycles() const { return stalled_cycles_; }
    /// Frames that were not shown because pixels of them were lost.
    std::int64_t kept_frames() const { return kept_frames_; }
    /// Raster pixels received so far, for the watchdog.
    std::int64_t pixels_taken() const { return pixels_taken_; }

  private:
    void end_of_elaboration() override;
    void clock_edge();
    void reset();
    void take_pixel(const PipePixel& pixel);
    void mark_frame(bool bad);
    void dvi_clock_edge();
    void dvi_reset();
    void start_dvi_frame();

    DisplayConfig display_;
    DviTiming timing_;
    bool may_stall_;
    std::int64_t raster_pixels_;
    std::shared_ptr<const ColourTable> colour_table_;  ///< null: colours are shown as they are

    std::array<std::vector<std::uint32_t>, 2> banks_;
    /// DVI output clock: high from a swap until SWAPLOCK has been seen low. FRAMEDONE does not rise again
    /// before this has been seen low in turn, so no swap is missed whatever the ratio of the clocks.
    sc_core::sc_signal<bool> swapped_{"swapped"};

    ClockGate gate_;
    sc_core::sc_event_or_list wake_events_;

    // Core registers.
    RegisterSet core_registers_;
    Register<Averager> averager_;
    Synchronizer swapped_synchronizer_{core_registers_, "swapped"};
    Register<bool> swapped_seen_{core_registers_, "swapped_seen"};
    Register<bool> receiving_{core_registers_, "receiving"};
    Register<bool> frame_done_{core_registers_, "frame_done"};  ///< the back bank holds a whole frame
    Register<bool> framedone_{core_registers_, "framedone"};    ///< the wire
    Register<bool> framebad_{core_registers_, "framebad"};      ///< the wire; set while the frame comes in
    Register<bool> pipeready_{core_registers_, "pipeready"};
    Register<std::size_t> back_{core_registers_, "back", 1};
    Register<std::int64_t> raster_position_;
    Register<std::size_t> next_word_;
    Register<int> frames_taken_;

    // DVI output registers.
    RegisterSet dvi_registers_;
    Synchronizer swaplock_synchronizer_{dvi_registers_, "swaplock"};
    Register<bool> swap_pending_{dvi_registers_, "swap_pending"};
    Register<bool> swap_skipped_{dvi_registers_,
                                 "swap_skipped"};  ///< the last swap, or the pending one, shows nothing new
    Register<std::size_t> front_{dvi_registers_, "front", 1, 1};
    Register<int> front_frame_;
    Register<bool> picture_shown_{dvi_registers_, "picture_shown"};  ///< the front bank holds a frame
    Register<int> x_;
    Register<int> line_;
    Register<bool> active_line_{dvi_registers_, "active_line"};
    Register<bool> vsync_line_{dvi_registers_, "vsync_line"};
    Register<std::size_t> next_shown_;
    Register<DviLink> link_{dvi_registers_, "link"};

    // What a report says of the run.
    std::int64_t stalled_cycles_ = 0;
    std::int64_t pixels_taken_ = 0;
    std::int64_t kept_frames_ = 0;
    std::vector<Swap> swaps_;
};

}  // namespace metabuffer::rtl
