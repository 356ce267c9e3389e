#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rtl/block.h"
#include "rtl/fault_tally.h"
#include "rtl/register.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// What faults do to the characters between a link's encoder and its decoder. Only links with such faults have it.
///
/// The source says at disturbance_i, with a pixel, what goes wrong with that pixel's characters: bits are flipped, a
/// channel comes whole characters late, or its characters do not begin with the words. FaultKind::kTmdsNoise also flips
/// bits at a rate: which ones depends only on its seed and the number of the clock, so every run is the same.
///
/// tmds_o follows tmds_i without a clock between. Each character with flipped bits of kTmdsNoise counts in the tally.
class TmdsFault final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< the link's clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<TmdsDisturbance> disturbance_i{"disturbance_i"};
    In<TmdsLink> tmds_i{"tmds_i"};  ///< as the encoder drives it
    Out<TmdsLink> tmds_o{"tmds_o"};

    /// noise: indices in Scenario::faults of those that flip bits at a rate. Scenario and tally must outlive the module.
    TmdsFault(const sc_core::sc_module_name& name, const Scenario& scenario, std::vector<std::size_t> noise,
              FaultTally& tally);
    SC_HAS_PROCESS(TmdsFault);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void follow();
    TmdsLink disturbed() const;
    TmdsCharacter noise_of(std::size_t fault, std::size_t channel) const;

    const Scenario& scenario_;
    std::vector<std::size_t> noise_;
    FaultTally& tally_;
    std::int64_t core_period_picoseconds_;
    std::int64_t edge_ = 0;
    sc_core::sc_event clocked_;

    RegisterSet registers_;
    Register<TmdsDisturbance> disturbance_{registers_,
                                           "disturbance"};  ///< of the characters at tmds_i, noise included
    RegisterLine<TmdsLink> before_{registers_, "before",
                                   1 + kMostTmdsSkew};  ///< characters before those at tmds_i
};

}  // namespace metabuffer::rtl
