#pragma once

#include <cstddef>
#include <vector>

#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The registers between an input framebuffer and its composers (bus.register_stages), which let a long bus run at the
/// core clock. What goes to the composers passes through all of them, one stage per clock, and their answers pass
/// through as many. Not in the paper (its Figure 1 has a bus without them). Only machines with stages have this block.
///
/// All outputs are registered. Reset empties every stage.
class BusRegisters final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<BusBeat> bus_i{"bus_i"};   ///< from the input framebuffer
    Out<BusBeat> bus_o{"bus_o"};
    PinVector<In<bool>> busready_i;  ///< one per composer of the row
    PinVector<Out<bool>> busready_o;
    PinVector<In<bool>> tableready_i;
    PinVector<Out<bool>> tableready_o;

    /// stages: 1 or more. composers: number in the row. lanes: words that the waveform shows of a beat.
    BusRegisters(const sc_core::sc_module_name& name, int stages, std::size_t composers,
                 int lanes = kMaximumBeatPixels);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void reset();
    void drive();

    RegisterSet registers_;
    RegisterLine<BusBeat> bus_;
    std::vector<RegisterLine<bool>> busready_;  ///< by composer
    std::vector<RegisterLine<bool>> tableready_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &BusRegisters::clock_edge, &BusRegisters::reset};
};

}  // namespace metabuffer::rtl
