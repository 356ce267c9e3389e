#include "monitors/link_plan.h"

#include <algorithm>

#include "scenario/fault_kinds.h"

namespace metabuffer::monitors {

template <typename Predicate>
bool LinkPlan::has_fault(Predicate concerned) const {
    return std::any_of(scenario_.faults.begin(), scenario_.faults.end(), [&](const Fault& candidate) {
        return concerned(candidate) && candidate.renderer == renderer_ && candidate.pair == pair_ &&
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

void LinkPlan::restart() {
    pair_ = 0;
    kind_ = FrameKind::kColour;
    repeated_ = false;
}

LinkPlan::Frame LinkPlan::next() {
    const auto has_effect = [this](FaultEffect effect) {
        return has_fault([effect](const Fault& fault) { return fault_traits(fault.kind).effect == effect; });
    };
    while (has_effect(FaultEffect::kAbsence)) step();
    const Frame frame{pair_, kind_, has_effect(FaultEffect::kGeometry)};
    repeated_ =
        !repeated_ && has_fault([](const Fault& fault) { return fault.kind == FaultKind::kRepeated; });
    if (!repeated_) step();
    return frame;
}

}  // namespace metabuffer::monitors
