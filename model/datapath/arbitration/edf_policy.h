#pragma once

#include <vector>

#include "datapath/arbitration/arbitration_policy.h"

namespace metabuffer {

/// Earliest deadline first: the ready composer whose next pixel is needed at the earliest raster position; on a tie, the
/// one of the earlier table row. The rasters of the columns are assumed to run in step.
class EdfPolicy final : public ArbitrationPolicy {
  public:
    void start_frame(const std::vector<int>& /*slots*/, std::size_t /*rows*/) override {}
    BusGrant grant(const std::vector<BusRequest>& requests) const override;
};

}  // namespace metabuffer
