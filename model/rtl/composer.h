#pragma once

#include <string>
#include <systemc>

#include "report/composer_record.h"
#include "rtl/beat_receiver.h"
#include "rtl/block.h"
#include "rtl/composer_fifo.h"
#include "rtl/composer_wires.h"
#include "rtl/merge_stage.h"
#include "rtl/pipeline_handshake.h"
#include "rtl/raster_recorder.h"
#include "rtl/raster_walker.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// A composer, box C of the paper's Figure 1 (sections 4, 5.2 to 5.4). It receives its segment's pixels from its
/// renderer's bus in its buffer and merges them with the pixels that come down its display's pipeline. It is made of
///
/// - beat_receiver: takes the bus's beats, keeps account of frames and pixels, raises BUSREADY and TABLEREADY;
/// - composer_fifo: the buffer;
/// - raster_walker: which of the segment's pixels each raster position shows;
/// - merge_stage: merges the pixels, raises STALL;
/// - pipeline_handshake: PIPEREADY and STARTFRAME.
///
/// Their headers say what each does at which clock, and what errors it raises. No output depends on an input of the same
/// clock.
class Composer final : public Block, public ComposerRecord {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> pipemaster_i{"pipemaster_i"};
    In<BusBeat> bus_i{"bus_i"};
    Out<bool> busready_o{"busready_o"};
    Out<bool> tableready_o{"tableready_o"};  ///< another frame's table can be taken
    In<bool> startframe_i{"startframe_i"};
    Out<bool> startframe_o{"startframe_o"};
    In<PipePixel> pipe_i{"pipe_i"};
    Out<PipePixel> pipe_o{"pipe_o"};
    In<bool> pipeready_i{"pipeready_i"};   ///< from below
    Out<bool> pipeready_o{"pipeready_o"};  ///< to above
    In<bool> column_stall_i{"column_stall_i"};
    Out<bool> stall_o{"stall_o"};

    /// display: from 1. The scenario gives raster, composition, background, buffer and bus parameters.
    Composer(const sc_core::sc_module_name& name, const Scenario& scenario, int display);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// The wires between the composer and its FIFO, if it has such a block inside; else null.
    FifoWires* fifo_wires() { return &wires_.fifo; }

  private:
    void bind_bus_side();
    void bind_fifo();
    void bind_pipeline_side();
    void bind_recorder();

    int pixels_per_beat_;

    ComposerWires wires_;
    BeatReceiver beat_receiver_;
    ComposerFifo fifo_;
    RasterWalker raster_walker_;
    MergeStage merge_stage_;
    PipelineHandshake pipeline_handshake_;
    RasterRecorder raster_recorder_;
};

}  // namespace metabuffer::rtl
