#pragma once

#include <optional>
#include <vector>

#include "formats/viewport_table.h"

namespace metabuffer {

/// The longest slot table in exact proportions; longer ones are rounded to about as many slots.
constexpr int kSlotTableLimit = 256;
/// Slots that no table of so many rows exceeds. Rounding may give each row up to one slot more than its share.
constexpr int most_slots(int rows) { return kSlotTableLimit + rows; }

/// The cyclic table of idle-recovery slot allocation (sections 5.1 and 5.3 of the paper): the composer of row i gets
/// slots in proportion to C_i / T_i = sdx_i / dmultiple_i, at least one, spread evenly over the table. The result holds
/// row indices. Proportions are exact up to kSlotTableLimit slots (for tables whose multiples have a common multiple of
/// at most 2^32; others are rounded to 20 fraction bits); beyond it each row's share is rounded to nearest. Empty for
/// an empty table. The rows must be valid (see validate_table). limit_slots: the longest table in exact proportions, 1
/// to kSlotTableLimit.
std::vector<int> slot_table(const ViewportTable& rows, int limit_slots = kSlotTableLimit);

/// One slot for each row: the table of plain round robin.
std::vector<int> equal_slot_table(const ViewportTable& rows, int limit_slots = kSlotTableLimit);

/// Converts the slot table that a host has sent from indices in the sent table to indices among its valid rows. None if
/// it is wrong: it has a slot of a row that is missing or was dropped, no slot of a valid row, or more slots than
/// most_slots() of the number of rows sent.
std::optional<std::vector<int>> judge_slots(const std::vector<int>& places, const ValidatedTable& table);

/// The other way round: the index in the sent table of each valid row.
std::vector<int> places_of_rows(const ValidatedTable& table);

}  // namespace metabuffer
