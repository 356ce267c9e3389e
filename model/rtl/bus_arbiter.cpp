#include "rtl/bus_arbiter.h"

#include "datapath/arbitration/edf_policy.h"
#include "datapath/arbitration/slot_table_policy.h"

namespace metabuffer::rtl {
namespace {

std::unique_ptr<ArbitrationPolicy> make_policy(Arbitration arbitration) {
    using Slots = SlotTablePolicy::Slots;
    using IdleSlots = SlotTablePolicy::IdleSlots;
    switch (arbitration) {
        case Arbitration::kIrsa:
            return std::make_unique<SlotTablePolicy>(Slots::kProportional, IdleSlots::kRecovered);
        case Arbitration::kSlotAllocation:
            return std::make_unique<SlotTablePolicy>(Slots::kProportional, IdleSlots::kLost);
        case Arbitration::kRoundRobin:
            return std::make_unique<SlotTablePolicy>(Slots::kEqual, IdleSlots::kRecovered);
        case Arbitration::kEdf:
            return std::make_unique<EdfPolicy>();
    }
    return nullptr;
}

}  // namespace

BusArbiter::BusArbiter(const sc_core::sc_module_name& name, Arbitration arbitration)
    : Block(name), policy_(make_policy(arbitration)) {}

void BusArbiter::start_frame(const std::vector<Segment>& segments) {
    policy_->start_frame(segments);
    slot_ = 0;
    granted_row_ = -1;
}

BusGrant BusArbiter::pick(const std::vector<BusRequest>& requests) {
    const BusGrant grant = policy_->pick(requests);
    slot_ = policy_->slot();
    if (grant.kind == BusGrant::Kind::kBurst) {
        granted_row_ = grant.row;
    }
    return grant;
}

void BusArbiter::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, slot_, path("slot"));
    sc_core::sc_trace(file, granted_row_, path("granted_row"));
}

}  // namespace metabuffer::rtl
