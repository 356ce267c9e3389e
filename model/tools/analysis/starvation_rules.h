#pragma once

#include <cstddef>

#include "tools/analysis/buffer_case.h"
#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {

/// False if a composer could starve, as far as the rules of docs/analysis.md can tell: that of slots, that of polls and
/// that of rivals. True is certain: not one pixel of its segment can come too late. If nothing is proved of the policy, that
/// takes a buffer for the whole segment.
bool is_starvation_free(const BusTable& table, std::size_t row, const BufferCase& buffer);

}  // namespace metabuffer::analysis
