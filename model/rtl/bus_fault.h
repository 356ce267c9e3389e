#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rtl/block.h"
#include "rtl/fault_tally.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// The last part of the bus before one composer, where faults of the scenario (lost_beat) remove beats: those of the
/// composer's pixels, those of tables, or any. Instead of a lost beat the composer sees a clock without a beat. Not in
/// the paper: a test double for a broken connector.
///
/// Combinational: a beat that is not lost is seen in the same clock. A fault from core cycle c on loses beats that the
/// composer would have read at the edge of core cycle c or later.
class BusFault final : public Block {
  public:
    In<BusBeat> bus_i{"bus_i"};
    Out<BusBeat> bus_o{"bus_o"};

    /// display: index, of the composer. faults: indices in Scenario::faults of its lost_beat faults. Scenario and tally
    /// must outlive the module.
    BusFault(const sc_core::sc_module_name& name, const Scenario& scenario, std::size_t display,
             std::vector<std::size_t> faults, FaultTally& tally);
    SC_HAS_PROCESS(BusFault);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// Pixels for the composer in the beats lost so far.
    std::int64_t lost_pixels() const { return lost_pixels_; }

  private:
    void update();
    bool is_of(const BusBeat& beat, LostBeats of) const;
    bool loses(const BusBeat& beat);

    const Scenario& scenario_;
    std::uint16_t destination_;
    std::vector<std::size_t> faults_;
    FaultTally& tally_;
    std::int64_t core_period_picoseconds_;
    std::int64_t lost_beats_ = 0;
    std::int64_t lost_pixels_ = 0;
};

}  // namespace metabuffer::rtl
