#include "datapath/arbitration/edf_policy.h"

namespace metabuffer {

BusGrant EdfPolicy::grant(const std::vector<BusRequest>& requests) const {
    BusGrant grant;
    std::int64_t earliest = 0;
    for (std::size_t row = 0; row < requests.size(); ++row) {
        if (!requests[row].pending || !requests[row].ready) {
            continue;
        }
        if (grant.row < 0 || requests[row].deadline < earliest) {
            grant = {BusGrant::Kind::kBurst, static_cast<int>(row), 0};
            earliest = requests[row].deadline;
        }
    }
    return grant;
}

}  // namespace metabuffer
