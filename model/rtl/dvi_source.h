#pragma once

#include <cstdint>

#include "formats/dvi_timing.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"
#include "scenario/link_program.h"

namespace metabuffer::rtl {

/// A renderer's graphics card as the link sees it, box A of the paper's Figure 1: a test double that sends
/// the scenario's pairs, colour frame first, depth frame second, each under a control scanline written as the
/// host would write it (section 4).
///
/// Timing: after reset one vertical sync, then frame after frame of DviTiming. lockstep: the first clock of a
/// pair follows the clock that sees pair_request high with no pair under way, and one pair a frame is sent;
/// between pairs the link stays in blanking. free-running: pair follows pair without pause, for ever.
/// Faults of the scenario (see Fault) spoil, delay or repeat the frames they name, as LinkProgram tells. A clock that
/// drifts is not made here: clock_ppm_o, written with the first clock of a pair, tells how far it is to be off.
class DviSource final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< DVI input clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> pair_request_i{"pair_request_i"};
    sc_core::sc_out<DviLink> link_o{"link_o"};
    /// Millionths that the link's clock is to run fast: of the newest drift fault whose pair has begun, 0 at first.
    sc_core::sc_out<int> clock_ppm_o{"clock_ppm_o"};

    /// The scenario must outlive the module. renderer: index, from 0.
    DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
              ClockGating gating = ClockGating::kOn);
    SC_HAS_PROCESS(DviSource);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// Faults of the scenario that have taken effect on the link.
    std::int64_t injected_faults() const { return program_.injected_faults(); }

    enum class State : std::uint8_t { kFirstSync, kIdle, kSilence, kFrame };

  private:
    void end_of_elaboration() override;
    void clock_edge();
    void start_frame_or_blank();
    void drive(const DviLink& link);
    bool start_next_frame();
    int active_pixels_of_line() const;
    std::uint32_t active_data() const;
    void step_raster();

    const Scenario& scenario_;
    DviTiming timing_;
    LinkProgram program_;

    ClockGate gate_;
    sc_core::sc_event_or_list wake_events_;

    RegisterSet registers_;
    Register<State> state_{registers_, "state", 2};
    Register<std::int64_t> silence_clocks_;  ///< still to go
    Register<int> x_;
    Register<int> line_;
    Register<bool> vsync_line_{registers_, "vsync_line"};
    Register<int> line_active_pixels_;  ///< of the line under way
    Register<DviLink> link_{registers_, "DVI"};
};

}  // namespace metabuffer::rtl
