#include "datapath/arbitration/arbitration_policy.h"

#include "datapath/arbitration/edf_policy.h"
#include "datapath/arbitration/slot_table_policy.h"

namespace metabuffer {

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

}  // namespace metabuffer
