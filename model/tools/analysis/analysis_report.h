#pragma once

#include <string>

#include "tools/analysis/bandwidth_analysis.h"

namespace metabuffer::analysis {

/// What `metabuffer analyze` prints.
std::string analysis_text(const Analysis& analysis);

/// The same as JSON, keys in a fixed order, units in the keys' names.
std::string analysis_json(const Analysis& analysis);

}  // namespace metabuffer::analysis
