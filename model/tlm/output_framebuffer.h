#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <systemc>

#include "formats/colour_table.h"
#include "formats/image.h"
#include "scenario/scenario.h"
#include "tlm/column_time.h"
#include "tlm/cycle.h"
#include "tlm/payload.h"
#include "tlm/swap_lock.h"

namespace metabuffer::tlm {

/// An output framebuffer, box D of the paper's Figure 1 (sections 2, 4, 5.4 and 7): receives the pixels of its pipeline,
/// averages them, corrects their colours if the scenario has a table for its display, keeps two banks, raises PIPEREADY
/// when one is free, and gives whole frames to its display when they have been on the DVI link.
class OutputFramebuffer final : public sc_core::sc_module {
  public:
    TargetSocket<OutputFramebuffer, PipelineFrame> pipe_socket{"pipe_socket"};
    InitiatorSocket<OutputFramebuffer, ShownFrame> dvi_socket{"dvi_socket"};

    /// Scenario, column and swap lock must outlive the module. display: its own, from 1. pipeready_cycle: the core
    /// clock in which PIPEREADY rises for the first time.
    OutputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
                      ColumnTime& column, SwapLock& swap_lock, std::int64_t pipeready_cycle);
    SC_HAS_PROCESS(OutputFramebuffer);

    /// Raster pixels received up to a core clock.
    std::int64_t pixels_taken(std::int64_t through_cycle) const;
    std::string waiting_for(std::int64_t through_cycle) const;

  private:
    void start_of_simulation() override;
    void raise_pipeready(int frame, std::int64_t cycle);
    void take_band(Payload& payload, sc_core::sc_time& delay);
    ::tlm::tlm_sync_enum take_startframe(Payload& payload, Phase& phase, sc_core::sc_time& delay);
    void take_swap(int frame, std::int64_t pipeready_cycle, std::int64_t shown_picoseconds);
    void wait_for_end_of_frame();
    void show();

    const Scenario& scenario_;
    ColumnTime& column_;
    SwapLock& swap_lock_;
    std::int64_t first_pipeready_cycle_;
    std::shared_ptr<const ColourTable> colour_table_;  ///< null: colours are shown as they are
    std::array<ColourImage, 2> banks_;                 ///< by frame, even and odd; empty without images
    /// Swapped, but not yet shown in full; the next frame may be composited meanwhile.
    struct Showing {
        int frame;
        std::int64_t picoseconds;
    };
    std::deque<Showing> showing_;
    sc_core::sc_event shown_event_;
    Message<PipelineFrame> pipeline_;
    Message<ShownFrame> shown_;
};

}  // namespace metabuffer::tlm
