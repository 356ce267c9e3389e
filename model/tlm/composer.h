#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <systemc>

#include "datapath/composition.h"
#include "datapath/span.h"
#include "scenario/scenario.h"
#include "tlm/agenda.h"
#include "tlm/buffer_time.h"
#include "tlm/column_time.h"
#include "tlm/cycle.h"
#include "tlm/payload.h"
#include "tlm/relay.h"
#include "tlm/schedule_observer.h"

namespace metabuffer::tlm {

/// A composer, box C of the paper's Figure 1 (sections 4, 5.2 to 5.4): answers its bus for its buffer, signals the
/// composer above when it is prefetched, and composites its segment onto what comes down the pipeline, a band of raster
/// rows at a time. Rules and clocks are those of level rtl (docs/design.md).
///
/// The composer strapped PIPEMASTER starts the column's frames and, when one has been composited, sends it down
/// the pipeline.
class Composer final : public sc_core::sc_module {
  public:
    TargetSocket<Composer, BusTransfer> bus_socket{"bus_socket"};  ///< BusTransfer, BusNotice
    OptionalTargetSocket<Composer, PipelineFrame> pipe_in_socket{"pipe_in_socket"};  ///< from above
    InitiatorSocket<Composer, PipelineFrame> pipe_out_socket{"pipe_out_socket"};

    struct Settings {
        int renderer = 0;  ///< index in the column, from 0; composer 0 is the PIPEMASTER
        int display = 1;   ///< from 1
        bool images = true;
        ScheduleObserver* observer = nullptr;
    };
    /// Scenario, agenda, column and relays must outlive the module. All composers of a column share it and its relays.
    Composer(const sc_core::sc_module_name& name, const Scenario& scenario, const Agenda& agenda,
             ColumnTime& column, ColumnRelays& relays, const Settings& settings);
    SC_HAS_PROCESS(Composer);

    const BufferTime& buffer() const { return buffer_; }
    /// Counts up to a core clock, which must be the present one. Call it once.
    const ComposerCounters& finish(std::int64_t through_cycle);
    std::string waiting_for(std::int64_t through_cycle) const;

  private:
    bool pipemaster() const { return settings_.renderer == 0; }

    void take_transfer(Payload& payload, sc_core::sc_time& delay);
    void take_table(const BusTransfer& transfer);
    void take_beats(BusTransfer& transfer);
    void give_slot(BusTransfer& transfer);
    void report_slot();
    void report_table(int frame);

    ::tlm::tlm_sync_enum take_pipeready(Payload& payload, Phase& phase, sc_core::sc_time& delay);
    void raise_pipeready();
    void start_column(int frame, std::int64_t cycle);
    ::tlm::tlm_sync_enum take_startframe(Payload& payload, Phase& phase, sc_core::sc_time& delay);
    void start_frame(Payload& payload);

    void send_frame_down();
    void take_band(Payload& payload, sc_core::sc_time& delay);
    void composite(const PipelineFrame& band);
    void composite_row(const PipelineFrame& band, int y, const PixelPlanes& content, const Segment& segment);
    PixelSpan smoothed_row(const PipelineFrame& band, int y, const PixelPlanes& content,
                           const Segment& segment) const;

    const Scenario& scenario_;
    Settings settings_;
    ClockDomain core_;
    const Agenda& agenda_;
    ColumnTime& column_;
    ColumnRelays& relays_;
    BufferTime buffer_;
    std::array<FrameContent, kFramesKept> content_;
    bool slot_wanted_ = false;  ///< the bus waits for the notice
    std::int64_t earliest_slot_ = 0;

    int next_frame_ = 0;                            ///< to start next
    std::int64_t below_pipeready_ = kUnknownCycle;  ///< for that frame
    std::int64_t own_pipeready_ = kUnknownCycle;    ///< for the frame before it
    sc_core::sc_event composited_event_;            ///< PIPEMASTER: the column has composited a frame
    std::size_t next_starved_ = 0;
    int line_row_ = -1;  ///< source row that the band's line holds

    Message<BusNotice> notice_;
    Message<PipelineFrame> pipeline_;
    PixelPlanes raster_;  ///< PIPEMASTER
    PixelPlanes line_;
    std::unique_ptr<SmoothingLines> smoothing_lines_;  ///< PIPEMASTER of a machine that smooths
};

}  // namespace metabuffer::tlm
