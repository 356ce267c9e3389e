#pragma once

#include <memory>
#include <vector>

#include "datapath/arbitration/arbitration_policy.h"
#include "rtl/block.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// The bus arbiter of an input framebuffer (section 5.3 of the paper): gives the bus to one composer for a
/// burst, by the scenario's policy (datapath/arbitration).
///
/// Timing: an arbitration is combinational within the input framebuffer's clock, so a granted burst's first
/// beat follows the last beat of the burst before it without a gap, and recovering slots costs no clock. The
/// block has no clock of its own: its input framebuffer calls it at the edges where it needs a grant.
class BusArbiter final : public Block {
  public:
    BusArbiter(const sc_core::sc_module_name& name, Arbitration arbitration);

    /// A new frame's segments, in table order; requests are indexed alike.
    void start_frame(const std::vector<Segment>& segments);
    BusGrant pick(const std::vector<BusRequest>& requests);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    std::unique_ptr<ArbitrationPolicy> policy_;
    int slot_ = 0;
    int granted_row_ = -1;
};

}  // namespace metabuffer::rtl
