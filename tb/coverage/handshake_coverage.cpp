#include "handshake_coverage.h"

namespace metabuffer::coverage {
namespace {

const char* goal_of(rtl::Handshake handshake) {
    switch (handshake) {
        case rtl::Handshake::kBusready:
            return "BUSREADY";
        case rtl::Handshake::kTableready:
            return "TABLEREADY";
        case rtl::Handshake::kPipeready:
            return "PIPEREADY";
        case rtl::Handshake::kPairRequest:
            return "PAIR_REQUEST";
        case rtl::Handshake::kStall:
            return "STALL";
        case rtl::Handshake::kFramedone:
            return "FRAMEDONE";
        case rtl::Handshake::kSwaplock:
            return "SWAPLOCK";
        case rtl::Handshake::kSwapskip:
            return "SWAPSKIP";
    }
    return "";
}

}  // namespace

HandshakeCoverage::HandshakeCoverage(Coverage& coverage, const rtl::MachineFaults& faults) {
    for (const rtl::MachineFaults::Handshaking& handshake : faults.handshakes()) {
        handshakes_.emplace_back(&handshake, Bin(coverage, "faults/handshake", goal_of(handshake.handshake)));
    }
}

void HandshakeCoverage::clock_edge() {
    for (auto& [handshake, bin] : handshakes_) {
        bin.hit_if(handshake->driven.read() != handshake->seen.read());
    }
}

}  // namespace metabuffer::coverage
