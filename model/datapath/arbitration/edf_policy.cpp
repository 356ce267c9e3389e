#include "datapath/arbitration/edf_policy.h"

namespace metabuffer {

BusGrant EdfPolicy::pick(const std::vector<BusRequest>& requests) {
    BusGrant grant;
    std::int64_t earliest = 0;
    for (std::size_t row = 0; row < requests.size(); ++row) {
        if (!requests[row].pending || !requests[row].ready) {
            continue;
        }
        const std::int64_t deadline = segments_[row].first_use(requests[row].next_pixel);
        if (grant.row < 0 || deadline < earliest) {
            grant = {BusGrant::Kind::kBurst, static_cast<int>(row), 0};
            earliest = deadline;
        }
    }
    return grant;
}

}  // namespace metabuffer
