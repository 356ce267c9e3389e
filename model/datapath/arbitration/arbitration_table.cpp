#include "datapath/arbitration/arbitration_table.h"

#include "datapath/arbitration/edf_policy.h"
#include "datapath/arbitration/slot_table_policy.h"

namespace metabuffer {

std::unique_ptr<ArbitrationPolicy> make_policy(Arbitration arbitration) {
    const ArbitrationRow& row = arbitration_row(arbitration);
    return row.make(row);
}

std::vector<int> slots_of(Arbitration arbitration, const ViewportTable& rows) {
    const ArbitrationRow& row = arbitration_row(arbitration);
    return row.slot_table != nullptr ? row.slot_table(rows) : std::vector<int>{};
}

std::unique_ptr<ArbitrationPolicy> make_slot_table_policy(const ArbitrationRow& row) {
    return std::make_unique<SlotTablePolicy>(row.idle_slots);
}

std::unique_ptr<ArbitrationPolicy> make_edf_policy(const ArbitrationRow& /*row*/) {
    return std::make_unique<EdfPolicy>();
}

}  // namespace metabuffer
