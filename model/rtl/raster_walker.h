#pragma once

#include <cstdint>
#include <systemc>

#include "datapath/composer_buffer.h"
#include "rtl/block.h"
#include "rtl/composer_signals.h"
#include "rtl/register.h"

namespace metabuffer::rtl {

/// A composer's walk over its display's raster (section 5.2 of the paper). For each raster position it says which pixels
/// of the segment show there, one position ahead of the merge stage, and which of them have then had their last use.
///
/// Timing, in core clocks:
/// - a frame starts at the edge that sees start_i while COLUMNSTALL is low. running_o is high from then on until the edge
///   at which the raster's last position is composited.
/// - ahead_o is what the position after the next one shows; the next edge composites the next one. Before a frame ahead_o
///   is the first position of the segment at segment_i; this alone is combinational.
/// - use_o is about the position that is composited at the next edge.
/// - while COLUMNSTALL is high no register changes. In `glitch` mode COLUMNSTALL is not read.
class RasterWalker final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> column_stall_i{"column_stall_i"};
    In<bool> start_i{"start_i"};
    In<HeadSegment> segment_i{"segment_i"};  ///< of the next frame; read at its start
    Out<bool> running_o{"running_o"};
    Out<RasterStep> ahead_o{"ahead_o"};
    Out<bool> uses_o{"uses_o"};  ///< there is something at use_o
    Out<PixelUse> use_o{"use_o"};

    RasterWalker(const sc_core::sc_module_name& name, const Scenario& scenario);
    SC_HAS_PROCESS(RasterWalker);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void reset();
    void move();
    void start_frame();
    SegmentWalker at_start() const;
    void drive_ahead();
    void drive_use();

    int raster_width_;
    int raster_height_;
    bool may_stall_;
    bool smooths_;
    int pixel_bits_;

    RegisterSet registers_;
    Register<bool> running_{registers_, "running"};
    Register<int> frame_;  ///< number of the frame composited, from 0
    Register<SegmentWalker>
        walker_;                     ///< the position that is composited at the next edge, while a frame runs
    Register<SegmentWalker> ahead_;  ///< the one after it
    Register<bool> uses_{registers_, "uses"};
    Register<PixelUse> use_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &RasterWalker::clock_edge, &RasterWalker::reset};
};

}  // namespace metabuffer::rtl
