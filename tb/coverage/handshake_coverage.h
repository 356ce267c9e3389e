#pragma once

#include <utility>
#include <vector>

#include "coverage.h"
#include "rtl/machine_faults.h"

namespace metabuffer::coverage {

/// Follows the handshakes that have a fault on their way: which of them their readers have seen otherwise than their
/// blocks drove them.
class HandshakeCoverage {
  public:
    /// Coverage and faults must outlive it.
    HandshakeCoverage(Coverage& coverage, const rtl::MachineFaults& faults);

    /// A core clock edge, before the edge.
    void clock_edge();

  private:
    std::vector<std::pair<const rtl::MachineFaults::Handshaking*, Bin>> handshakes_;
};

}  // namespace metabuffer::coverage
