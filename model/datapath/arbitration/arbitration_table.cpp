#include "datapath/arbitration/arbitration_table.h"

#include <utility>

#include "datapath/arbitration/edf_policy.h"
#include "datapath/arbitration/slot_table_policy.h"
#include "formats/slot_payload.h"

namespace metabuffer {

std::unique_ptr<ArbitrationPolicy> make_policy(Arbitration arbitration) {
    const ArbitrationRow& row = arbitration_row(arbitration);
    return row.make(row);
}

std::vector<int> slots_of(Arbitration arbitration, const ViewportTable& rows) {
    const ArbitrationRow& row = arbitration_row(arbitration);
    return row.slot_table != nullptr ? row.slot_table(rows, kSlotTableLimit) : std::vector<int>{};
}

SentSlots sent_slots(Arbitration arbitration, const ValidatedTable& table,
                     const std::vector<std::uint8_t>& payload) {
    if (arbitration_row(arbitration).slot_table == nullptr || table.rows.empty()) return {};
    if (const auto indices = decode_slots(payload)) {
        if (auto slots = judge_slots(*indices, table)) return {std::move(*slots), false};
    }
    return {equal_slot_table(table.rows), true};
}

std::vector<std::uint8_t> slot_payload(Arbitration arbitration, const ValidatedTable& table,
                                       std::size_t room_bytes) {
    const ArbitrationRow& row = arbitration_row(arbitration);
    if (row.slot_table == nullptr || table.rows.empty()) return {};
    const std::size_t sent = table.rows.size() + table.rejected.size();
    const std::size_t room = slots_in_payload(room_bytes, sent);
    std::vector<int> slots;
    // Rounding gives a table a few slots more or fewer than its limit.
    int limit = kSlotTableLimit;
    do {
        slots = row.slot_table(table.rows, limit);
    } while (slots.size() > room && --limit > 0);
    if (slots.size() > room) return {};
    const std::vector<int> indices = sent_indices(table);
    for (int& slot : slots) slot = indices[static_cast<std::size_t>(slot)];
    return encode_slots(slots, sent);
}

std::unique_ptr<ArbitrationPolicy> make_slot_table_policy(const ArbitrationRow& row) {
    return std::make_unique<SlotTablePolicy>(row.idle_slots);
}

std::unique_ptr<ArbitrationPolicy> make_edf_policy(const ArbitrationRow& /*row*/) {
    return std::make_unique<EdfPolicy>();
}

}  // namespace metabuffer
