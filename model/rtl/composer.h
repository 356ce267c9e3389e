#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "datapath/composer_buffer.h"
#include "report/composer_record.h"
#include "rtl/block.h"
#include "rtl/composer_fifo.h"
#include "rtl/fifo_wires.h"
#include "rtl/register.h"
#include "rtl/signals.h"
#include "rtl/smoothing_window.h"

namespace metabuffer::rtl {

/// A composer, box C of the paper's Figure 1 (sections 4, 5.2 to 5.4). It receives its segment's pixels from its
/// renderer's bus in its buffer and merges them with the pixels that come down its display's pipeline.
///
/// It is made of a receiver of beats (ComposerBuffer), a walk over the raster (SegmentWalker), a merge stage and
/// handshakes, in one clocked process, and of composer_fifo, a block with pins.
///
/// Timing, in core clocks; all outputs are registered:
/// - pipeline: the pixel on pipe_i at an edge leaves, composited, on pipe_o after it. STARTFRAME is relayed
///   the same way, one clock ahead of pixel 0. The composer strapped PIPEMASTER makes the upstream pixel itself
///   (background, A = 0, far) and answers its own PIPEREADY with STARTFRAME one clock later.
/// - buffer: a pixel sampled from the bus at an edge can be composited at the next one. It is written into the FIFO
///   after that edge; until a read can return it, it is in a register next to the merge stage (bypass). The FIFO is
///   read one position ahead, unless its output has that pixel already, as it does while columns are replicated.
/// - BUSREADY: if no burst for this composer is under way, or its rest fits one beat, BUSREADY is high while
///   ready_space_pixels are free besides that rest: a slot would be taken. Earlier in a burst it is high while the beat
///   on its way and one more fit, and those that read latency and bus registers hold. The first low clock ends the
///   burst. Its last beat is the one sampled after that clock, or as many clocks later as a beat and its answer take.
///   BUSREADY stays low until then.
/// - PIPEREADY rises after the edge that sees PIPEREADY from below while this composer is prefetched, and falls after
///   the edge that sees STARTFRAME. Prefetched means that the next frame's table is complete, and that its segment is
///   empty or wholly in the buffer, or the buffer takes no further slot.
/// - smoothing: a raster pixel is mixed of up to four pixels of two source rows (SmoothingWindow), and waits for all of
///   them.
/// - starvation: the segment pixel of a covered raster pixel, or one that is mixed with it, is not there. `glitch`: the upstream pixel passes and is
///   counted. `stall`: STALL is raised one clock ahead, and the column stands still at the next edge; while COLUMNSTALL
///   is high no register of the pipeline side changes. In `glitch` mode COLUMNSTALL is not read.
/// - a pixel lost on the bus is noticed by the index that the next beat names, or by the next frame's table. The rest
///   of that frame is abandoned here: from the next clock on every raster pixel passes as it comes from above, marked
///   `lost`, and nothing is waited for. The mark keeps the frame off the displays. If no raster pixel is left, the
///   frame was composited without its lost pixels, which have starved.
/// - a lost frame start or table row is noticed by the frame that the next beat names, for whichever composer that is,
///   by the index that the next row names, or by pixels or another frame before the table's last row. When its turn
///   comes, the frame is abandoned from its first raster pixel on. Its pixels are dropped.
/// - a burst ends for the composer with its last beat, with what comes after its own BUSREADY's fall, or when no beat
///   of it has come for longest_beat_gap_cycles().
///
/// Raises /metabuffer/composer/protocol if the bus breaks its protocol: a pixel for a full buffer, a pixel, row or
/// frame that has come before, a frame more than 65535 ahead of the newest, a pixel without a table, a third frame's
/// table.
class Composer final : public Block, public ComposerRecord {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> pipemaster_i{"pipemaster_i"};
    sc_core::sc_in<BusBeat> bus_i{"bus_i"};
    sc_core::sc_out<bool> busready_o{"busready_o"};
    sc_core::sc_out<bool> tableready_o{"tableready_o"};  ///< another frame's table can be taken
    sc_core::sc_in<bool> startframe_i{"startframe_i"};
    sc_core::sc_out<bool> startframe_o{"startframe_o"};
    sc_core::sc_in<PipePixel> pipe_i{"pipe_i"};
    sc_core::sc_out<PipePixel> pipe_o{"pipe_o"};
    sc_core::sc_in<bool> pipeready_i{"pipeready_i"};   ///< from below
    sc_core::sc_out<bool> pipeready_o{"pipeready_o"};  ///< to above
    sc_core::sc_in<bool> column_stall_i{"column_stall_i"};
    sc_core::sc_out<bool> stall_o{"stall_o"};

    /// display: from 1. The scenario gives raster, composition, background, buffer and bus parameters.
    Composer(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
             ClockGating gating = ClockGating::kOn);
    SC_HAS_PROCESS(Composer);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// The wires between the composer and its FIFO, if it has such a block inside; else null.
    FifoWires* fifo_wires() { return &fifo_wires_; }

  private:
    void end_of_elaboration() override;
    void clock_edge();
    void reset();
    Pixel local_pixel(std::int64_t pixel) const {
        return Pixel(bypass_pixel_ == pixel ? bypass_word_.value() : fifo_wires_.word.read());
    }
    Pixel smoothed_pixel() const {
        return blend(window_->pixels(walker_->window()), walker_->weight_x(), walker_->weight_y(),
                     composition_, far_z_);
    }
    void drive_fifo(int held_before);
    void follow_read();
    void read_ahead();
    std::int64_t pixel_ahead() const;
    std::optional<BlendWindow<std::int64_t>> window_ahead() const;
    void pipeline_edge();
    void start_frame();
    void composite(const PipePixel& upstream);
    void end_frame();
    void bus_edge();
    bool follow_frames(const BusBeat& beat);
    void begin_frame(const BusBeat& beat);
    void take_row(const BusBeat& beat);
    void lose_open_table();
    void take_pixels(const BusBeat& beat);
    bool keep_pixels(const BusBeat& beat);
    void lose_pixels(std::int64_t count);
    void protocol_error(const std::string& what) const;
    void drive_handshakes(bool was_running);
    bool idle(bool was_running) const;
    bool fifo_is_told() const;
    bool slot_ready() const;
    bool prefetched() const;
    bool next_pixel_missing() const;

    // Configuration, constant after elaboration.
    std::uint16_t display_;
    Composition composition_;
    StarvationMode on_starvation_;
    Smoothing smoothing_;
    std::uint32_t far_z_;
    PipePixel background_;
    int raster_width_;
    int raster_height_;
    int ready_space_pixels_;
    int pixels_per_beat_;
    int in_flight_pixels_;    ///< that may still come when BUSREADY falls in a burst, with that edge's beat
    int cut_cycles_;          ///< in which they come
    int longest_gap_cycles_;  ///< longest_beat_gap_cycles()
    std::int64_t core_period_picoseconds_;

    ClockGate gate_;
    sc_core::sc_event_or_list wake_events_;

    FifoWires fifo_wires_;
    ComposerFifo fifo_;

    RegisterSet registers_;
    Register<ComposerBuffer> buffer_;
    Register<SegmentWalker> walker_;
    Register<SegmentWalker> ahead_;                        ///< one position further, while a frame runs
    Register<bool> pipemaster_{registers_, "pipemaster"};  ///< the strap, read while reset is high
    Register<bool> running_{registers_, "running"};
    Register<bool> startframe_{registers_, "startframe"};
    Register<bool> pipeready_{registers_, "pipeready"};
    Register<bool> busready_{registers_, "busready"};
    Register<bool> tableready_{registers_, "tableready"};
    Register<bool> stall_{registers_, "stall"};
    Register<bool> pipe_valid_{registers_, "pipe_valid"};
    Register<bool> starved_{registers_, "starved"};  ///< the pixel that has just left lacks this composer's
    Register<std::int64_t> read_pixel_;    ///< the segment's pixel that the FIFO was last commanded to read
    Register<std::int64_t> word_pixel_;    ///< the pixel at the FIFO's output; -1: none
    Register<std::int64_t> bypass_pixel_;  ///< the pixel in bypass_word; -1: none
    Register<std::uint64_t> bypass_word_{registers_, "bypass_word", 64};
    std::unique_ptr<SmoothingWindow> window_;  ///< instead of those four; null in a composer that replicates
    Register<int> announced_;                  ///< pixels of the burst under way that are still to come
    Register<int> silent_cycles_;              ///< since its last beat, while announced_ > 0
    Register<int> burst_cut_;  ///< clocks in which beats may still come of a burst that BUSREADY has ended
    Register<std::uint32_t> next_row_;  ///< index in the newest frame's table of the row that must come next
    Register<int> frame_;               ///< number of the frame composited, from 0

    FifoWrite kept_;                      ///< written by this clock
    std::uint32_t abandoned_pixels_ = 0;  ///< of a frame that this clock has found incomplete
};

}  // namespace metabuffer::rtl
