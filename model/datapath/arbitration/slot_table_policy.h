#pragma once

#include <vector>

#include "datapath/arbitration/arbitration_policy.h"

namespace metabuffer {

/// A cyclic slot table, with or without recovery of slots that their owner cannot use. Proportional slots
/// with recovery are IRSA, without it plain slot allocation; equal slots with recovery are round robin.
class SlotTablePolicy final : public ArbitrationPolicy {
  public:
    /// Makes a frame's table: row indices, at least one slot for each row.
    using TableMaker = std::vector<int> (*)(const ViewportTable& rows);

    SlotTablePolicy(TableMaker make_table, IdleSlots idle_slots)
        : make_table_(make_table), idle_slots_(idle_slots) {}

    void start_frame(const std::vector<Segment>& segments) override;
    BusGrant pick(const std::vector<BusRequest>& requests) override;
    int slot() const override { return static_cast<int>(next_); }

  private:
    void find_distances(std::size_t rows);
    void step() { next_ = next_ + 1 == table_.size() ? 0 : next_ + 1; }

    TableMaker make_table_;
    IdleSlots idle_slots_;
    std::vector<int> table_;
    std::vector<int> distances_;  ///< by row and slot: slots to pass from that slot to the row's next one
    std::size_t next_ = 0;
};

}  // namespace metabuffer
