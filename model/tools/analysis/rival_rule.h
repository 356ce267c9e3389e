#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/analysis/buffer_case.h"
#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {

/// By portion: 1 if it is known to be in time.
using PortionFlags = std::vector<char>;

/// True if the rule of rivals (docs/analysis.md) shows that all portions are in time that are not known to be. From the
/// last time that the composer was not ready, the bus is busy. Meanwhile each rival takes at most its slots in the
/// table that come between the composer's own, and at most what it has room for. Without sure slots it takes at most
/// what is due before. The bus must be work-conserving.
///
/// The rule is checked for pairs of portions, in blocks. A block is divided where it must be, so this is as exact as a
/// check of every pair. Where that would take too long the check gives up and returns false.
bool rival_rule(const BusTable& table, std::size_t row, const Jobs& jobs, const BufferCase& buffer,
                const PortionFlags& known);

}  // namespace metabuffer::analysis
