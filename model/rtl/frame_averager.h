#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <systemc>

#include "datapath/averaging.h"
#include "formats/colour_table.h"
#include "rtl/block.h"
#include "rtl/crossing.h"
#include "rtl/display_signals.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// An output framebuffer's side of its pipeline (sections 5.4 and 7 of the paper). It receives the pixels that leave the
/// pipeline, averages them, corrects their colours if the scenario has a table for its display, and has them written
/// into the back picture of the display memory. The table of colours is configuration, like the size of the raster:
/// reset keeps it, and it costs no clock.
///
/// Timing, in core clocks; every output is registered:
///
/// | the edge reads | effect at that edge |
/// | --- | --- |
/// | COLUMNSTALL high (`stall` mode) | no pixel is received |
/// | STARTFRAME high | the next edge receives the raster's first pixel |
/// | the last raster pixel of an s x s block | the display pixel is driven at write_o |
/// | a pixel marked `lost` | FRAMEBAD rises |
/// | the raster's last pixel, and swapped_i was seen low | FRAMEDONE rises |
/// | swapped_i high, two registers later | FRAMEDONE and FRAMEBAD fall |
/// | the back picture free, no frame under way | PIPEREADY is high |
///
/// Raises /metabuffer/output_framebuffer/bubble if there is no pixel at a raster position.
class FrameAverager final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> startframe_i{"startframe_i"};
    In<PipePixel> pipe_i{"pipe_i"};
    In<bool> column_stall_i{"column_stall_i"};
    Out<bool> pipeready_o{"pipeready_o"};
    Out<bool> framedone_o{"framedone_o"};
    Out<bool> framebad_o{"framebad_o"};  ///< with FRAMEDONE: pixels of the frame were lost
    Out<bool> writes_o{"writes_o"};      ///< a pixel stands at write_o
    Out<DisplayWrite> write_o{"write_o"};
    In<bool> swapped_i{"swapped_i"};  ///< DVI output clock: the swap is over
    In<bool> skipped_i{"skipped_i"};  ///< with swapped_i: the display keeps its picture

    /// display: its own, from 1.
    FrameAverager(const sc_core::sc_module_name& name, const Scenario& scenario, int display);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    std::int64_t stalled_cycles() const { return stalled_cycles_; }
    /// Raster pixels received so far, for the watchdog.
    std::int64_t pixels_taken() const { return pixels_taken_; }

  private:
    void clock_edge();
    void reset();
    bool take_pixel(const PipePixel& pixel);
    void mark_frame(bool bad);

    bool may_stall_;
    std::int64_t raster_pixels_;
    std::shared_ptr<const ColourTable> colour_table_;  ///< null: colours are shown as they are

    RegisterSet registers_;
    Register<Averager> averager_;
    Synchronizer swapped_{registers_, "swapped"};
    Register<bool> swapped_seen_{registers_, "swapped_seen"};
    Register<bool> receiving_{registers_, "receiving"};
    Register<bool> frame_done_{registers_, "frame_done"};  ///< the back picture is a whole frame
    Register<bool> framedone_{registers_, "framedone"};    ///< the wire
    Register<bool> framebad_{registers_, "framebad"};      ///< the wire; set while the frame comes in
    Register<bool> pipeready_{registers_, "pipeready"};
    Register<bool> back_{registers_, "back"};  ///< which picture frames are written to
    Register<std::int64_t> raster_position_;
    Register<std::uint32_t> next_word_;
    Register<bool> writes_{registers_, "writes"};
    Register<DisplayWrite> write_;
    Register<int> frames_taken_;

    // What a report says of the run.
    std::int64_t stalled_cycles_ = 0;
    std::int64_t pixels_taken_ = 0;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &FrameAverager::clock_edge, &FrameAverager::reset};
};

}  // namespace metabuffer::rtl
