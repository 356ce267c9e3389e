#pragma once

#include <vector>

#include "datapath/arbitration/arbitration_policy.h"

namespace metabuffer {

/// A cyclic slot table, with or without recovery of the slots that their owner cannot use:
///
/// | slots | recovered | lost |
/// | --- | --- | --- |
/// | in proportion | irsa | slot-allocation |
/// | equal | round-robin | |
class SlotTablePolicy final : public ArbitrationPolicy {
  public:
    explicit SlotTablePolicy(IdleSlots idle_slots) : idle_slots_(idle_slots) {}

    /// slots: row indices, at least one slot for each row.
    void start_frame(const std::vector<int>& slots, std::size_t rows) override;
    BusGrant grant(const std::vector<BusRequest>& requests) const override;
    void take(const BusGrant& grant) override;
    int slot() const override { return static_cast<int>(next_); }

  private:
    void find_distances(std::size_t rows);

    IdleSlots idle_slots_;
    std::vector<int> table_;
    std::vector<int> distances_;  ///< by row and slot: slots to pass from that slot to the row's next one
    std::size_t next_ = 0;
};

}  // namespace metabuffer
