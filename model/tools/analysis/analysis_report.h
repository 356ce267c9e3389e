#pragma once

#include <string>

#include "tools/analysis/bandwidth_analysis.h"

namespace metabuffer::analysis {

/// What `metabuffer analyze` prints. details: also all that is known of each table.
std::string analysis_text(const Analysis& analysis, bool details);

/// The parts that cannot keep up with that rate, whatever the buffers, as in "the raster and the displays". Empty if
/// all can. buses: whether the buses count, too.
std::string too_slow_for(const Analysis& analysis, double frame_rate_hz, bool buses = true);

/// The same as JSON, keys in a fixed order, units in the keys' names.
std::string analysis_json(const Analysis& analysis);

}  // namespace metabuffer::analysis
