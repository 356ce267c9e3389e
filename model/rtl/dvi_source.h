#pragma once

#include <cstdint>

#include "formats/dvi_timing.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"
#include "scenario/link_program.h"

namespace metabuffer::rtl {

/// A renderer's graphics card as the link sees it, box A of the paper's Figure 1. This test double sends the scenario's
/// pairs, colour frame first, depth frame second. Each begins with a control scanline as the host would write it
/// (section 4).
///
/// LinkProgram (model/scenario) decides which frame comes next, and what the scenario's faults change in it.
///
/// | condition | clock | effect |
/// | --- | --- | --- |
/// | after reset | | one vertical sync, then frames of DviTiming |
/// | lockstep, pair_request_i read high, no pair under way | the same edge | a pair begins: one for each frame of the run |
/// | lockstep, no request | | the link stays in blanking |
/// | free-running | | pair follows pair, for ever |
/// | a pair begins, with a fault of kind drift | its first | clock_ppm_o changes; LinkClock makes the clock drift |
/// | a fault in the characters of link_o's pixel | the pixel's | disturbance_o has it; TmdsFault carries it out |
class DviSource final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< DVI input clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> pair_request_i{"pair_request_i"};
    Out<DviLink> link_o{"link_o"};
    /// How many millionths the link's clock must run fast, by the newest drift fault whose pair has begun; 0 at first.
    Out<int> clock_ppm_o{"clock_ppm_o"};
    Out<TmdsDisturbance> disturbance_o{"disturbance_o"};

    /// The scenario must outlive the module. renderer: index, from 0.
    DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// Faults of the scenario that have taken effect on the link.
    std::int64_t injected_faults() const { return program_.injected_faults(); }

    enum class State : std::uint8_t { kFirstSync, kIdle, kSilence, kFrame };

  private:
    void clock_edge();
    void reset();
    void start_frame_or_blank();
    void drive(const DviLink& link);
    void disturb(const TmdsDisturbance& disturbance);
    bool start_next_frame();
    int active_pixels_of_line() const;
    std::uint32_t active_data() const;
    void step_raster();

    const Scenario& scenario_;
    DviTiming timing_;
    LinkProgram program_;

    RegisterSet registers_;
    Register<State> state_{registers_, "state", 2};
    Register<std::int64_t> silence_clocks_;  ///< still to go
    Register<int> x_;
    Register<int> line_;
    Register<bool> vsync_line_{registers_, "vsync_line"};
    Register<int> line_active_pixels_;  ///< of the line under way
    Register<DviLink> link_{registers_, "DVI"};
    RegisterSet character_registers_{registers_};  ///< of links that have characters
    Register<TmdsDisturbance> disturbance_{character_registers_, "disturbance"};
    Register<bool> flips_bits_{character_registers_,
                               "flips_bits"};  ///< disturbance_o flips bits, for one clock
    Clocked clocked_{*this, clk_i, reset_i, registers_, &DviSource::clock_edge, &DviSource::reset};
};

}  // namespace metabuffer::rtl
