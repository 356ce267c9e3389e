#pragma once

#include <optional>
#include <vector>

#include "formats/viewport_table.h"

namespace metabuffer {

/// The longest slot table in exact proportions; longer ones are rounded to about as many slots.
constexpr int kSlotTableLimit = 256;
/// Slots that no table of so many rows exceeds. Rounding may give each row up to one slot more than its share.
constexpr int most_slots(int rows) { return kSlotTableLimit + rows; }

/// The cyclic table of idle-recovery slot allocation (sections 5.1 and 5.3 of the paper), as row indices: the composer of
/// row i gets slots in proportion to C_i / T_i = sdx_i / dmultiple_i, at least one, spread evenly over the table.
///
/// Proportions are exact up to limit_slots (1 to kSlotTableLimit) slots; beyond, each row's share is rounded to nearest.
/// If the rows' multiples have no common multiple up to 2^32, shares are first rounded to 20 fraction bits. The rows
/// must be valid (see validate_table).
std::vector<int> slot_table(const ViewportTable& rows, int limit_slots = kSlotTableLimit);

/// One slot for each row: the table of plain round robin.
std::vector<int> equal_slot_table(const ViewportTable& rows, int limit_slots = kSlotTableLimit);

/// The slot table that a host has sent, from indices of the rows sent to indices of the valid rows. None if it is wrong:
/// it has a slot of a row that is missing or was dropped, no slot of a valid row, or more than most_slots() of the rows.
std::optional<std::vector<int>> judge_slots(const std::vector<int>& indices, const ValidatedTable& table);

/// The other way round: by valid row, its index in the table as sent.
std::vector<int> sent_indices(const ValidatedTable& table);

}  // namespace metabuffer
