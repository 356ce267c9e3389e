#pragma once

#include <utility>
#include <vector>

#include "cover_group.h"
#include "rtl/handshake.h"
#include "rtl/machine_faults.h"

namespace metabuffer::coverage {

struct HandshakeGoals : CoverGroup {
    explicit HandshakeGoals(Coverage& coverage)
        : CoverGroup(coverage,
                     {"faults/handshake",
                      "handshakes that a fault holds low though they are raised, or, STALL, high"}) {}
    Cross<rtl::Handshake> held{*this, every<rtl::Handshake>()};
};

/// Follows the handshakes that pass through a fault: which of them a reader has seen with another value than its block
/// drove.
class HandshakeCoverage {
  public:
    /// Goals and faults must outlive it.
    HandshakeCoverage(const HandshakeGoals& goals, const rtl::MachineFaults& faults);

    /// A core clock edge, before the edge.
    void clock_edge();

  private:
    std::vector<std::pair<const rtl::MachineFaults::Handshaking*, Bin>> handshakes_;
};

}  // namespace metabuffer::coverage
