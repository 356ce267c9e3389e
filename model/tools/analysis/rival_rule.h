#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/analysis/buffer_case.h"
#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {

/// By portion: 1 if it is known to be in time.
using PortionFlags = std::vector<char>;

/// The rule of rivals, for the portions that are not known to be in time: from the last time that the composer was not
/// ready, the bus is busy, and each rival takes no more than its slots beside the composer's own and no more than it
/// has room for (without sure slots: no more than is due before). For a bus that is work-conserving. Looks at pairs of
/// portions, in blocks that are divided where they must be, so that it is as exact as looking at every pair; gives up,
/// with false, where that would take too long.
bool rival_rule(const BusTable& table, std::size_t row, const Jobs& jobs, const BufferCase& buffer,
                const PortionFlags& known);

}  // namespace metabuffer::analysis
