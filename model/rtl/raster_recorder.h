#pragma once

#include <cstdint>
#include <systemc>

#include "report/composer_record.h"
#include "rtl/clocked.h"
#include "rtl/composer_signals.h"
#include "rtl/pins.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// What a composer's raster comes to in its record: when frames start, when their first and last pixels are composited,
/// which pixels starve, how many are replayed, and stalled clocks. It watches the wires between the composer's parts and is
/// not hardware.
class RasterRecorder final : public sc_core::sc_module {
  public:
    In<bool> clk_i{"clk_i"};
    In<bool> reset_i{"reset_i"};
    In<bool> column_stall_i{"column_stall_i"};
    In<bool> start_i{"start_i"};
    In<bool> running_i{"running_i"};
    In<RasterStep> ahead_i{"ahead_i"};
    In<SegmentProgress> progress_i{"progress_i"};
    In<bool> missing_i{"missing_i"};

    RasterRecorder(const sc_core::sc_module_name& name, const Scenario& scenario, ComposerRecord& record);
    SC_HAS_PROCESS(RasterRecorder);

    // The raster position that is composited next.
    int x() const { return static_cast<int>(composited_ % raster_width_); }
    int y() const { return static_cast<int>(composited_ / raster_width_); }

  private:
    void clock_edge();
    void reset() { composited_ = 0; }
    void count_pixel();
    void follow_missing();
    std::int64_t cycle() const;

    bool may_stall_;
    int raster_width_;
    std::int64_t raster_pixels_;
    std::int64_t core_period_picoseconds_;
    ComposerRecord& record_;

    std::int64_t composited_ = 0;  ///< raster pixels of the frame
    bool replays_ = false;         ///< so does the position that is composited next
    RegisterSet registers_;        ///< none
    Clocked clocked_{*this, clk_i, reset_i, registers_, &RasterRecorder::clock_edge, &RasterRecorder::reset};
};

}  // namespace metabuffer::rtl
