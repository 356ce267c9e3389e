#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "datapath/arbitration/arbitration_policy.h"
#include "datapath/slot_table.h"
#include "host/enum_table.h"

namespace metabuffer {

/// What is proved about the order in which a policy serves composers. The buffer bound of `metabuffer analyze` is based
/// on it (docs/analysis.md).
enum class BufferProof : std::uint8_t {
    kNone,       ///< nothing, so there is no bound
    kSlots,      ///< a composer that is ready gets each of its slots, whatever the others do
    kDeadlines,  ///< of the composers that are ready, the one whose next pixel is needed first goes first
};

/// What a policy must know about a row that wants the bus.
enum class RequestKind : std::uint8_t {
    kReady,         ///< that it is ready
    kWithDeadline,  ///< also the first raster position that needs its next pixel
};

/// One policy: all that is known of a policy outside of its class. A new policy is a class, an enumerator and a row.
struct ArbitrationRow {
    Arbitration value;
    const char* name;
    std::unique_ptr<ArbitrationPolicy> (*make)(const ArbitrationRow& row);
    /// Rows by slot, for a table of valid rows; null: the policy has no slots.
    std::vector<int> (*slot_table)(const ViewportTable& rows, int limit_slots);
    IdleSlots idle_slots;
    BufferProof proof;
    RequestKind requests;
};

std::unique_ptr<ArbitrationPolicy> make_slot_table_policy(const ArbitrationRow& row);
std::unique_ptr<ArbitrationPolicy> make_edf_policy(const ArbitrationRow& row);

/// Messages list the names in this order.
inline constexpr std::array kArbitrationTable{
    ArbitrationRow{Arbitration::kIrsa, "irsa", make_slot_table_policy, slot_table, IdleSlots::kRecovered,
                   BufferProof::kSlots, RequestKind::kReady},
    ArbitrationRow{Arbitration::kSlotAllocation, "slot-allocation", make_slot_table_policy, slot_table,
                   IdleSlots::kLost, BufferProof::kSlots, RequestKind::kReady},
    ArbitrationRow{Arbitration::kRoundRobin, "round-robin", make_slot_table_policy, equal_slot_table,
                   IdleSlots::kRecovered, BufferProof::kSlots, RequestKind::kReady},
    ArbitrationRow{Arbitration::kEdf, "edf", make_edf_policy, nullptr, IdleSlots::kRecovered,
                   BufferProof::kDeadlines, RequestKind::kWithDeadline},
};
static_assert(is_in_order(kArbitrationTable));

constexpr const ArbitrationRow& arbitration_row(Arbitration arbitration) {
    return row_of(kArbitrationTable, arbitration);
}

/// Rows by slot for a frame of these valid rows; none under a policy without slots.
std::vector<int> slots_of(Arbitration arbitration, const ViewportTable& rows);

/// The slot table of a frame whose host sends one.
struct SentSlots {
    std::vector<int> slots;  ///< index of a valid row, by slot; none under a policy without slots
    bool rejected = false;   ///< it is missing or wrong: there is one slot for each row instead
};
/// The slot table in the payload of a depth frame's control scanline.
SentSlots sent_slots(Arbitration arbitration, const ValidatedTable& table,
                     const std::vector<std::uint8_t>& payload);

/// The payload that the host makes: the policy's slot table, with as many slots as there is room for. Empty under a
/// policy without slots, if no row is valid, and if there is too little room.
std::vector<std::uint8_t> slot_payload(Arbitration arbitration, const ValidatedTable& table,
                                       std::size_t room_bytes);

/// Whether the arbiter reads the requests' deadlines.
constexpr bool goes_by_deadlines(Arbitration arbitration) {
    return arbitration_row(arbitration).requests == RequestKind::kWithDeadline;
}

/// Whether slots may pass unused while a composer that could use them waits.
constexpr bool loses_slots(Arbitration arbitration) {
    return arbitration_row(arbitration).idle_slots == IdleSlots::kLost;
}

}  // namespace metabuffer
