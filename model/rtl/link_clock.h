#pragma once

#include <cstdint>

#include "rtl/block.h"

namespace metabuffer::rtl {

/// The clock of a renderer's link where a fault lets it drift (FaultKind::kDrift). It rises at time 0, as all clocks
/// do, and its period is the nominal period divided by 1 + ppm / 10^6. Edges are at whole picoseconds; remainders are
/// carried over, so the average is exact. A change of clock_ppm_i takes effect at the next rising edge.
class LinkClock final : public Block {
  public:
    In<int> clock_ppm_i{"clock_ppm_i"};  ///< -100000..100000; positive: fast
    Out<bool> clk_o{"clk_o"};

    LinkClock(const sc_core::sc_module_name& name, std::int64_t nominal_period_picoseconds);
    SC_HAS_PROCESS(LinkClock);

    void trace(sc_core::sc_trace_file* file) const override;
    /// It does not change again.
    void stop() { stopped_ = true; }

  private:
    void step();

    std::int64_t nominal_period_picoseconds_;
    bool high_ = false;
    bool stopped_ = false;
    int ppm_ = 0;
    std::int64_t remainder_ = 0;  ///< carried over, in units of 1 / (10^6 + ppm_) picoseconds
    std::int64_t low_picoseconds_ = 0;
};

}  // namespace metabuffer::rtl
