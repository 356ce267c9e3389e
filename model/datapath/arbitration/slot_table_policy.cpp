#include "datapath/arbitration/slot_table_policy.h"

#include "datapath/slot_table.h"

namespace metabuffer {

void SlotTablePolicy::start_frame(const std::vector<Segment>& segments) {
    ViewportTable rows;
    rows.reserve(segments.size());
    for (const Segment& segment : segments) {
        rows.push_back(segment.row());
    }
    table_ = slots_ == Slots::kProportional ? slot_table(rows) : equal_slot_table(rows);
    next_ = 0;
}

BusGrant SlotTablePolicy::pick(const std::vector<BusRequest>& requests) {
    const auto usable = [&](int row) {
        const BusRequest& request = requests[static_cast<std::size_t>(row)];
        return request.pending && request.ready;
    };
    if (idle_slots_ == IdleSlots::kLost) {
        const int row = table_[next_];
        step();
        return {usable(row) ? BusGrant::Kind::kBurst : BusGrant::Kind::kLost, row, 0};
    }
    const std::size_t start = next_;
    for (int passed = 0; passed < static_cast<int>(table_.size()); ++passed) {
        const int row = table_[next_];
        step();
        if (usable(row)) {
            return {BusGrant::Kind::kBurst, row, passed};
        }
    }
    next_ = start;  // a poll does not move the table on
    return {};
}

}  // namespace metabuffer
