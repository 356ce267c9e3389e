#pragma once

#include <array>
#include <cstdint>

#include "host/enum_table.h"
#include "report/report.h"

namespace metabuffer {

/// What a bus does in a clock in which it is not idle.
enum class BusUse : std::uint8_t { kBusy, kTable, kPageMiss, kRefresh, kWrite, kGrant, kPoll, kLost };

struct BusUseTraits {
    BusUse value;
    std::int64_t BusCounters::*counter;  ///< of its clocks
};
inline constexpr std::array kBusUseTable{
    BusUseTraits{BusUse::kBusy, &BusCounters::busy_cycles},
    BusUseTraits{BusUse::kTable, &BusCounters::table_cycles},
    BusUseTraits{BusUse::kPageMiss, &BusCounters::page_miss_cycles},
    BusUseTraits{BusUse::kRefresh, &BusCounters::refresh_cycles},
    BusUseTraits{BusUse::kWrite, &BusCounters::write_cycles},
    BusUseTraits{BusUse::kGrant, &BusCounters::grant_cycles},
    BusUseTraits{BusUse::kPoll, &BusCounters::poll_cycles},
    BusUseTraits{BusUse::kLost, &BusCounters::lost_cycles},
};
static_assert(is_in_order(kBusUseTable));

}  // namespace metabuffer
