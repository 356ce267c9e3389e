#include "handshake_coverage.h"

namespace metabuffer::coverage {

HandshakeCoverage::HandshakeCoverage(Coverage& coverage, const rtl::MachineFaults& faults) {
    for (const rtl::MachineFaults::Handshaking& handshake : faults.handshakes()) {
        handshakes_.emplace_back(&handshake,
                                 Bin(coverage, "faults/handshake", to_string(handshake.handshake)));
    }
}

void HandshakeCoverage::clock_edge() {
    for (auto& [handshake, bin] : handshakes_) {
        bin.hit_if(handshake->driven.read() != handshake->seen.read());
    }
}

}  // namespace metabuffer::coverage
