#include "datapath/arbitration/slot_table_policy.h"

namespace metabuffer {

void SlotTablePolicy::start_frame(const std::vector<int>& slots, std::size_t rows) {
    table_ = slots;
    next_ = 0;
    find_distances(rows);
}

/// Goes backwards through the table twice, so that every slot also finds the row's next slot beyond the table's end.
void SlotTablePolicy::find_distances(std::size_t rows) {
    const std::size_t slots = table_.size();
    distances_.assign(rows * slots, 0);
    for (std::size_t row = 0; row < rows; ++row) {
        int distance = 0;
        for (std::size_t step = 2 * slots; step-- > 0;) {
            const std::size_t slot = step % slots;
            distance = table_[slot] == static_cast<int>(row) ? 0 : distance + 1;
            distances_[row * slots + slot] = distance;
        }
    }
}

BusGrant SlotTablePolicy::grant(const std::vector<BusRequest>& requests) const {
    const auto usable = [&](int row) {
        const BusRequest& request = requests[static_cast<std::size_t>(row)];
        return request.pending && request.ready;
    };
    if (idle_slots_ == IdleSlots::kLost) {
        const int row = table_[next_];
        return {usable(row) ? BusGrant::Kind::kBurst : BusGrant::Kind::kLost, row, 0};
    }
    BusGrant grant;  // a poll does not advance the table
    for (std::size_t row = 0; row < requests.size(); ++row) {
        const int passed = distances_[row * table_.size() + next_];
        if (usable(static_cast<int>(row)) && (grant.row < 0 || passed < grant.recovered_slots)) {
            grant = {BusGrant::Kind::kBurst, static_cast<int>(row), passed};
        }
    }
    return grant;
}

void SlotTablePolicy::take(const BusGrant& grant) {
    if (grant.kind != BusGrant::Kind::kPoll) {
        next_ = (next_ + static_cast<std::size_t>(grant.recovered_slots) + 1) % table_.size();
    }
}

}  // namespace metabuffer
