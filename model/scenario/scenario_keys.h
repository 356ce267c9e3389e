#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "scenario/limits.h"
#include "scenario/schema.h"

namespace metabuffer {

/// Every place of a scenario file.
const Schema& scenario_schema();

/// What a whole-number key takes.
struct WholeNumbers {
    IntegerRange range;
    std::vector<std::int64_t> only;  ///< ascending, if not all of the range will do
};

/// What the key of that pattern ("bus.width_bits") takes; nothing if its values are no whole numbers.
std::optional<WholeNumbers> whole_numbers_of(std::string_view pattern);

}  // namespace metabuffer
