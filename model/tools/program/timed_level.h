#pragma once

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "host/enum_table.h"

namespace metabuffer {

/// The levels that have a clock.
enum class TimedLevel : std::uint8_t { kRtl, kTlm };

struct TimedLevelRow {
    TimedLevel value;
    const char* name;
};
inline constexpr std::array kTimedLevelTable{
    TimedLevelRow{TimedLevel::kRtl, "rtl"},
    TimedLevelRow{TimedLevel::kTlm, "tlm"},
};
static_assert(is_in_order(kTimedLevelTable));

constexpr const char* level_name(TimedLevel level) { return row_of(kTimedLevelTable, level).name; }

/// The level of this name. Throws std::out_of_range if there is none.
inline TimedLevel timed_level(const std::string& name) {
    for (const TimedLevelRow& row : kTimedLevelTable) {
        if (name == row.name) return row.value;
    }
    throw std::out_of_range("no level " + name);
}

}  // namespace metabuffer
