#pragma once

#include <cstdint>
#include <memory>
#include <systemc>

#include "datapath/composition.h"
#include "rtl/block.h"
#include "rtl/composer_signals.h"
#include "rtl/pixel_window.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// A composer's merge stage (sections 2 and 5.2 of the paper): a stage of its display's pipeline that merges the segment
/// pixel of each raster position with the pixel from upstream. It reads the segment's pixels from the FIFO one position
/// ahead.
///
/// Timing, in core clocks:
/// - while running_i is high the pixel on pipe_i at an edge leaves, composited, on pipe_o after it. A composer strapped
///   PIPEMASTER makes the upstream pixel itself (background, A = 0, far).
/// - a pixel that has come at an edge can be composited at the next one (PixelWindow).
/// - read_o is combinational, from ahead_i, progress_i and registers.
/// - starvation: the segment pixel of a covered raster pixel, or one that is mixed with it, is not there.
///   missing_o, which is combinational from running_i, progress_i and registers, is high ahead of the edge at which it is
///   missing. `glitch`: the upstream pixel passes. `stall`: STALL is high as well; while COLUMNSTALL is high no register of
///   the pipeline changes. In `glitch` mode COLUMNSTALL is not read.
/// - from the clock on in which progress_i says that the frame is abandoned, every raster pixel passes as it comes from
///   upstream, marked `lost`, and nothing is waited for.
class MergeStage final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> pipemaster_i{"pipemaster_i"};
    // The pipeline.
    In<PipePixel> pipe_i{"pipe_i"};
    Out<PipePixel> pipe_o{"pipe_o"};
    In<bool> column_stall_i{"column_stall_i"};
    Out<bool> stall_o{"stall_o"};
    // The raster and the segment.
    In<bool> running_i{"running_i"};
    In<RasterStep> ahead_i{"ahead_i"};  ///< of the edge after next
    In<SegmentProgress> progress_i{"progress_i"};
    Out<bool> missing_o{"missing_o"};
    // The FIFO.
    In<FifoWrite> write_i{"write_i"};  ///< what it is about to store
    Out<FifoRead> read_o{"read_o"};
    In<std::uint64_t> word_i{"word_i"};
    /// With a window of two rows.
    struct SecondRowPins {
        In<std::uint64_t> next_word_i{"next_word_i"};
        Out<FifoRead> row_read_o{"row_read_o"};
        In<std::uint64_t> row_word_i{"row_word_i"};
        In<std::uint64_t> row_next_word_i{"row_next_word_i"};
    };
    std::unique_ptr<SecondRowPins> second_row;  ///< null in a composer that replicates

    MergeStage(const sc_core::sc_module_name& name, const Scenario& scenario);

    void trace(sc_core::sc_trace_file* file) const override;
    /// The newest pixel that the position composited next needs; only where the segment shows there.
    std::int64_t newest_pixel() const { return position_->newest(); }

  private:
    void clock_edge();
    void reset();
    bool missing() const;
    void composite();
    void drive();
    PixelWindow::Pins pins() const;

    Composition composition_;
    bool may_stall_;
    std::uint32_t far_z_;
    PipePixel background_;
    int pixel_bits_;

    RegisterSet registers_;
    Register<bool> pipemaster_{registers_, "pipemaster"};  ///< the strap, read while reset is high
    Register<bool> starved_{registers_, "starved"};  ///< the pixel that has just left lacks this composer's
    Register<RasterStep> position_;                  ///< composited at the next edge, while a frame runs
    PixelWindow window_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &MergeStage::clock_edge, &MergeStage::reset};
};

}  // namespace metabuffer::rtl
