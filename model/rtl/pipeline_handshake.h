#pragma once

#include <string>
#include <systemc>

#include "rtl/block.h"
#include "rtl/register.h"

namespace metabuffer::rtl {

/// A composer's part of the handshakes that start a frame (section 5.4 of the paper): PIPEREADY goes up its display's
/// pipeline and STARTFRAME comes down.
///
/// Timing, in core clocks:
/// - PIPEREADY rises after the edge that sees PIPEREADY from below while the next frame is fetched and none runs. It
///   falls after the edge that sees STARTFRAME.
/// - STARTFRAME is relayed one clock later, one clock ahead of pixel 0. The composer strapped PIPEMASTER answers its own
///   PIPEREADY instead. At an edge with COLUMNSTALL high it stands still. In `glitch` mode COLUMNSTALL is not read.
/// - PIPEREADY is combinational from registers, running_i and fetched_i, and start_o from these and startframe_i.
class PipelineHandshake final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> pipemaster_i{"pipemaster_i"};
    In<bool> column_stall_i{"column_stall_i"};
    In<bool> startframe_i{"startframe_i"};
    Out<bool> startframe_o{"startframe_o"};
    In<bool> pipeready_i{"pipeready_i"};   ///< from below
    Out<bool> pipeready_o{"pipeready_o"};  ///< to above
    In<bool> fetched_i{"fetched_i"};       ///< the next frame can be composited
    In<bool> running_i{"running_i"};       ///< a frame is composited
    Out<bool> start_o{"start_o"};          ///< a frame starts at the next edge, unless COLUMNSTALL is high

    /// may_stall: the machine is in `stall` mode.
    PipelineHandshake(const sc_core::sc_module_name& name, bool may_stall);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void reset();
    void drive();

    bool may_stall_;

    RegisterSet registers_;
    Register<bool> pipemaster_{registers_, "pipemaster"};  ///< the strap, read while reset is high
    Register<bool> startframe_{registers_, "startframe"};
    Register<bool> was_running_{registers_, "was_running"};  ///< before the last edge
    Register<bool> below_{registers_, "below"};              ///< PIPEREADY from below, at the last edge
    Register<bool> was_ready_{registers_, "was_ready"};      ///< PIPEREADY, before the last edge
    Clocked clocked_{
        *this, clk_i, reset_i, registers_, &PipelineHandshake::clock_edge, &PipelineHandshake::reset};
};

}  // namespace metabuffer::rtl
