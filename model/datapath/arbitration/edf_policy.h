#pragma once

#include <vector>

#include "datapath/arbitration/arbitration_policy.h"

namespace metabuffer {

/// Earliest deadline first: the composer whose buffer runs dry first, that is, whose next pixel to be sent is
/// needed at the earliest raster position; the earlier table row on a tie. The columns' rasters are taken to
/// run side by side.
class EdfPolicy final : public ArbitrationPolicy {
  public:
    void start_frame(const std::vector<int>& /*slots*/, std::size_t /*rows*/) override {}
    BusGrant grant(const std::vector<BusRequest>& requests) const override;
};

}  // namespace metabuffer
