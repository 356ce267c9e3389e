#pragma once

#include <cstdint>
#include <string>
#include <systemc>

#include "datapath/composer_buffer.h"
#include "report/composer_record.h"
#include "rtl/block.h"
#include "rtl/composer_signals.h"
#include "rtl/countdown.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// A composer's side of its renderer's bus (sections 5.2 and 5.3 of the paper). It takes the beats, writes its segment's
/// pixels into the FIFO, keeps the account of what has come and what is held (ComposerBuffer), and says what may be
/// sent.
///
/// Timing, in core clocks; every output is registered:
/// - use_i: what is not needed any more after the position composited at an edge is released at that edge, unless
///   COLUMNSTALL is high. That comes before the edge's beat.
/// - a pixel sampled from the bus at an edge counts as arrived after it, and stands at write_o.
/// - BUSREADY: if no burst for this composer is under way, or its rest fits one beat, BUSREADY is high while
///   ready_space_pixels are free besides that rest: a slot would be taken. Earlier in a burst it is high while the beat
///   on its way and one more fit, and those that read latency and bus registers hold. The first low clock ends the
///   burst. Its last beat is the one sampled after that clock, or as many clocks later as a beat and its answer take.
///   BUSREADY stays low until then.
/// - fetched_o: the next frame's table is complete, and its segment is empty or wholly in the buffer, or the buffer takes
///   no further slot.
/// - a burst ends with its last beat, cut_cycles_ after BUSREADY's fall, or when none of its beats has come for
///   longest_beat_gap_cycles().
/// - lost beats; the frame is then abandoned:
///
///   | lost | what shows it |
///   | --- | --- |
///   | pixels | the index of the next pixels; the next frame's table |
///   | a table row | the index of the next row; pixels or another frame before the table's last row |
///   | a frame start | the frame number of any beat, for any composer |
///
/// Raises /metabuffer/composer/protocol if the bus breaks its protocol: a pixel for a full buffer, a pixel, row or frame
/// that has come before, a frame more than 65535 ahead of the newest, a pixel without a table, a third frame's table. A
/// pixel of a frame whose table has no row for this composer is dropped and counted as late: the bus's monitor finds it.
class BeatReceiver final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<BusBeat> bus_i{"bus_i"};
    Out<bool> busready_o{"busready_o"};
    Out<bool> tableready_o{"tableready_o"};  ///< another frame's table can be taken
    // The raster.
    In<bool> column_stall_i{"column_stall_i"};
    In<bool> start_i{"start_i"};  ///< a frame starts at the edge, unless COLUMNSTALL is high
    In<bool> uses_i{"uses_i"};    ///< there is something at use_i
    In<PixelUse> use_i{"use_i"};
    Out<HeadSegment> segment_o{"segment_o"};
    Out<SegmentProgress> progress_o{"progress_o"};
    Out<bool> fetched_o{"fetched_o"};
    // The FIFO.
    Out<FifoWrite> write_o{"write_o"};
    Out<FifoRelease> release_o{"release_o"};

    /// display: the composer's, from 1. record: the composer's, which gets the counts of the bus side.
    BeatReceiver(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
                 ComposerRecord& record);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

  private:
    void clock_edge();
    void reset();
    void raster_edge();
    void bus_edge();
    bool follow_frames(const BusBeat& beat);
    void begin_frame(const BusBeat& beat);
    void take_row(const BusBeat& beat);
    void lose_open_table();
    void take_pixels(const BusBeat& beat);
    bool keep_pixels(const BusBeat& beat);
    void lose_pixels(std::int64_t count);
    void protocol_error(const std::string& what) const;
    void drive_fifo(int held_before);
    void drive_raster();
    void drive_handshakes();
    bool slot_ready() const;

    // Configuration, constant after elaboration.
    std::uint16_t display_;
    bool may_stall_;
    int ready_space_pixels_;
    int pixels_per_beat_;
    int pixel_bits_;
    int in_flight_pixels_;    ///< that may still come when BUSREADY falls in a burst, with that edge's beat
    int cut_cycles_;          ///< in which they come
    int longest_gap_cycles_;  ///< longest_beat_gap_cycles()
    std::int64_t core_period_picoseconds_;

    ComposerRecord& record_;

    RegisterSet registers_;
    Register<ComposerBuffer> buffer_;
    Register<bool> busready_{registers_, "busready"};
    Register<bool> tableready_{registers_, "tableready"};
    Register<bool> fetched_{registers_, "fetched"};
    Register<SegmentProgress> progress_;
    Register<bool> writes_{registers_, "writes"};  ///< pixels stand at write_o
    Register<FifoRelease> release_;
    Register<int> announced_;      ///< pixels of the burst under way that are still to come
    Register<int> silent_cycles_;  ///< since its last beat, while announced_ > 0
    Countdown burst_cut_;  ///< clocks in which beats may still come of a burst that BUSREADY has ended
    Register<std::uint32_t> next_row_;  ///< index in the newest frame's table of the row that must come next

    FifoWrite kept_;                      ///< this edge's pixels
    std::uint32_t abandoned_pixels_ = 0;  ///< of a frame that this edge has found incomplete
    bool segment_changes_ = false;        ///< this edge may have changed the head's segment
    Clocked clocked_{*this, clk_i, reset_i, registers_, &BeatReceiver::clock_edge, &BeatReceiver::reset};
};

}  // namespace metabuffer::rtl
