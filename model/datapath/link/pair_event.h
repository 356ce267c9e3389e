#pragma once

#include <cstdint>

#include "datapath/link/reject_cause.h"

namespace metabuffer {

/// What a decoder reports to its input framebuffer about frames and pairs. If several members report something at once,
/// it happened in their order.
struct PairEvent {
    bool rejected = false;  ///< a frame or a pair was rejected for `cause`
    RejectCause cause = RejectCause::kGeometry;
    bool pair_lost = false;  ///< pair `lost_number` will not come
    std::uint32_t lost_number = 0;
    bool colour_start =
        false;  ///< the pixels of a colour frame follow: the pair in the back device is overwritten
    bool pair_good = false;  ///< pair `number` is whole
    std::uint32_t number = 0;

    bool reports_anything() const { return rejected || pair_lost || colour_start || pair_good; }
};

}  // namespace metabuffer
