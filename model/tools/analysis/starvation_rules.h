#pragma once

#include <cstddef>

#include "tools/analysis/buffer_case.h"
#include "tools/analysis/bus_table.h"

namespace metabuffer::analysis {

/// True if the rules of docs/analysis.md (of slots, of polls, of rivals) show that no pixel of the composer's segment
/// can come too late. That is certain. False: the composer may starve, or may not. If nothing is proved of the policy,
/// only a buffer that holds the whole segment gives true.
bool is_starvation_free(const BusTable& table, std::size_t row, const BufferCase& buffer);

}  // namespace metabuffer::analysis
