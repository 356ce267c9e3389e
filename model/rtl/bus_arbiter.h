#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "datapath/arbitration/arbitration_policy.h"
#include "rtl/block.h"
#include "rtl/countdown.h"
#include "rtl/register.h"
#include "rtl/signals.h"
#include "scenario/limits.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// The bus arbiter of an input framebuffer (section 5.3 of the paper): it decides whose burst the bus carries next, by
/// the scenario's policy (datapath/arbitration). Line i of each kind belongs to row i of the frame's table; a frame
/// with fewer rows than displays leaves the last lines low.
///
/// Timing; G is grant_cycles:
///
/// | condition | clock | effect |
/// | --- | --- | --- |
/// | G = 0 | the same | grant lines and lost_o answer the request lines, combinationally; recovered slots cost nothing |
/// | G > 0, take_i high, a line can be granted or a slot lost | edge n | the answer is decided |
/// | take_i stays high | after edge n + G - 1 | the answer stands, whatever the request lines do, until the edge that takes it |
/// | take_i high with a grant or a lost slot | edge n | the bus takes the answer; the slot pointer moves past that slot |
/// | start_i high (one clock) | edge n | a frame begins; its slot table is used from slot 0 |
/// | start_i high, the hardware builds a table of S slots | edges n + 1 to n + S | no answer |
/// | the table is being built, or an answer can be decided and does not stand yet | the same | search_o is high |
class BusArbiter final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<bool> start_i{"start_i"};
    In<FrontTable> table_i{"table_i"};         ///< its slots and its number of rows are used
    In<bool> take_i{"take_i"};                 ///< the bus takes this clock's answer
    PinVector<In<bool>> pending_i;             ///< pixels of the row are still to be sent
    PinVector<In<bool>> ready_i;               ///< the row's composer takes a slot
    PinVector<In<std::uint64_t>> deadline_i;   ///< first raster position that needs the row's next
                                               ///< pixel; only under a policy that uses it
    PinVector<Out<bool>> grant_o;              ///< one-hot
    Out<bool> grant_valid_o{"grant_valid_o"};  ///< a line of grant_o is high
    Out<bool> search_o{"search_o"};
    Out<bool> lost_o{"lost_o"};                     ///< the slot's owner cannot use it, and nobody else may
    Out<std::uint16_t> recovered_o{"recovered_o"};  ///< slots passed over on the way to the one granted
    Out<std::uint16_t> slot_o{"slot_o"};            ///< the slot pointer

    /// lines: number of displays.
    BusArbiter(const sc_core::sc_module_name& name, const BusConfig& bus, int lines);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void reset();
    void decide();
    void answer();
    bool answer_stands() const { return found_ && !search_wait_.running(); }
    void drive_grant(int row);
    void drive_slot();

    static constexpr int kNoRow = -1;

    const BusConfig bus_;
    std::unique_ptr<ArbitrationPolicy> policy_;
    std::vector<BusRequest> requests_;  ///< one for each row of the frame

    RegisterSet registers_;
    Countdown build_wait_;  ///< slots of the table that are still to be built
    Countdown search_wait_{registers_, "search_wait",
                           static_cast<int>(limits::kGrantCycles.high)};  ///< edges until the answer
    Register<bool> found_{registers_, "found"};                           ///< the answer has been decided
    BusGrant found_grant_;

    BusGrant grant_;            ///< combinational: the answer
    BusGrant candidate_;        ///< combinational: what could be decided now
    int granted_row_ = kNoRow;  ///< whose line is high
    Clocked clocked_{*this, clk_i, reset_i, registers_, &BusArbiter::clock_edge, &BusArbiter::reset};
};

}  // namespace metabuffer::rtl
