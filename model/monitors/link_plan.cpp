#include "monitors/link_plan.h"

#include <algorithm>

namespace metabuffer::monitors {

bool LinkPlan::has_fault(FaultKind fault) const {
    return std::any_of(scenario_.faults.begin(), scenario_.faults.end(), [&](const Fault& candidate) {
        return candidate.kind == fault && candidate.renderer == renderer_ && candidate.pair == pair_ &&
               candidate.frame == kind_;
    });
}

void LinkPlan::step() {
    if (kind_ == FrameKind::kColour) {
        kind_ = FrameKind::kDepth;
    } else {
        kind_ = FrameKind::kColour;
        ++pair_;
    }
}

LinkPlan::Frame LinkPlan::next() {
    while (has_fault(FaultKind::kMissing)) step();
    const bool spoilt = has_fault(FaultKind::kShortLine) || has_fault(FaultKind::kLongLine) ||
                        has_fault(FaultKind::kShortFrame) || has_fault(FaultKind::kLongFrame);
    const Frame frame{pair_, kind_, spoilt};
    repeated_ = !repeated_ && has_fault(FaultKind::kRepeated);
    if (!repeated_) step();
    return frame;
}

}  // namespace metabuffer::monitors
