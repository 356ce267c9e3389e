#include "handshake_coverage.h"

namespace metabuffer::coverage {

HandshakeCoverage::HandshakeCoverage(const HandshakeGoals& goals, const rtl::MachineFaults& faults) {
    for (const rtl::MachineFaults::Handshaking& handshake : faults.handshakes()) {
        handshakes_.emplace_back(&handshake, goals.held(handshake.handshake));
    }
}

void HandshakeCoverage::clock_edge() {
    for (auto& [handshake, bin] : handshakes_) {
        bin.hit_if(handshake->driven.read() != handshake->seen.read());
    }
}

}  // namespace metabuffer::coverage
