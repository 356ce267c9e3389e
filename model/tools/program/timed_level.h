#pragma once

#include <cstdint>

#include "scenario/names.h"

namespace metabuffer {

/// The levels that have a clock.
enum class TimedLevel : std::uint8_t { kRtl, kTlm };

template <>
struct EnumNames<TimedLevel> {
    static constexpr const char* kWhat = "a level";
    static constexpr auto kTable =
        name_table<TimedLevel>({{TimedLevel::kRtl, "rtl"}, {TimedLevel::kTlm, "tlm"}});
};

}  // namespace metabuffer
