#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rtl/block.h"
#include "rtl/fault_tally.h"
#include "rtl/handshake.h"
#include "scenario/derived_timing.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// A wire that faults of the scenario hold.
struct HeldWire {
    Handshake handshake;
    std::size_t renderer = 0;  ///< index, as in Wires; the last renderer's for FRAMEDONE and SWAPLOCK
    std::size_t display = 0;   ///< index; 0 where there is one for all
    std::string name;          ///< "BUSREADY_1_2", for the watchdog's report
};

/// At which edges of a wire's clock faults hold the wire: at all edges for some time (busready_low, pipeready_low) or at
/// random edges (random_stalls), which depend only on the fault's seed, the wire and the number of the edge.
class WireHolds {
  public:
    /// faults: indices in Scenario::faults. Scenario and tally must outlive it.
    WireHolds(const Scenario& scenario, const HeldWire& wire, std::vector<std::size_t> faults,
              FaultTally& tally);

    bool at_first_edge() const { return any_holds(0, 0); }
    /// Call it at each edge: true if the wire is held at the next edge. changed: at this edge the hold has changed the
    /// level that was read, so the faults that hold the wire have taken effect.
    bool at_next_edge(bool changed);

  private:
    bool holds(std::size_t fault, std::int64_t core_cycle, std::int64_t edge) const;
    bool any_holds(std::int64_t core_cycle, std::int64_t edge) const;

    const Scenario& scenario_;
    HeldWire wire_;
    std::vector<std::size_t> faults_;
    FaultTally& tally_;
    std::int64_t core_period_picoseconds_;
    std::int64_t edge_ = -1;       ///< number of the clock's edge
    std::int64_t core_cycle_ = 0;  ///< for which the faults of the next edge have been asked
};

/// A wire that faults hold low (STALL: high), in a renderer's row or of the outputs below the last row. The module lies
/// between the block that raises the wire and the block that reads it. Not in the paper: a test double for a broken
/// wire or a slow block.
///
/// Timing: while no fault holds the wire, the output follows the input within the clock. A fault from core cycle c on
/// holds the wire from the edge of core cycle c on. Each wire keeps its protocol:
///
/// | wire | under a hold |
/// | --- | --- |
/// | PIPEREADY, FRAMEDONE | rises later; once high it stays high until its block lowers it |
/// | BUSREADY | low, and after the hold until its composer has lowered it too, at most stopped_burst_cycles() |
/// | TABLEREADY, PAIR_REQUEST, STALL | changes at any clock |
///
/// BUSREADY stays low because a composer that still expects the rest of a stopped burst could be sent more than it has
/// room for. stopped_burst_cycles() is the time in which the composer notices from the silent bus that its burst was
/// stopped. The burst may just have been granted: the bus opens a page, sends beats until their answer comes back, and
/// stops, and the composer waits for the longest gap.
class HandshakeFault final : public Block {
  public:
    In<bool> clk_i{"clk_i"};    ///< the clock of the block that reads the wire
    In<bool> wire_i{"wire_i"};  ///< as it is raised
    Out<bool> wire_o{"wire_o"};

    /// The row (index) of the PIPEREADY wires that a fault of a renderer's composer holds: the composer's own. The
    /// PIPEMASTER answers its own PIPEREADY without a wire, so there the fault holds the PIPEREADY that it waits for.
    static constexpr int pipeready_row(int renderer) { return renderer == 0 ? 1 : renderer; }
    /// The most core cycles for which BUSREADY stays low after a fault.
    static int stopped_burst_cycles(const Scenario& scenario) {
        return scenario.bus.grant_cycles + 2 * longest_beat_gap_cycles(scenario) +
               cycles_per_beat(scenario.bus) + 2 + 2 * bus_loop_cycles(scenario.bus, scenario.memory);
    }

    /// faults: indices in Scenario::faults of those that hold this wire. Scenario and tally must outlive the module.
    HandshakeFault(const sc_core::sc_module_name& name, const Scenario& scenario, HeldWire wire,
                   std::vector<std::size_t> faults, FaultTally& tally);
    SC_HAS_PROCESS(HandshakeFault);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

  private:
    void clock_edge();
    void update();
    bool holds_high() const { return wire_.handshake == Handshake::kStall; }

    HeldWire wire_;
    WireHolds holds_;
    int stopped_burst_cycles_;

    sc_core::sc_signal<bool> hold_;
    int stopped_left_ = 0;  ///< BUSREADY: clocks for which it still stays low after a fault
};

/// The wires from the swap lock to every output framebuffer, where faults delay the swap. Both rise later, SWAPSKIP no
/// later than SWAPLOCK, and neither is taken back. One module has both, so all displays see a swap in the same clock.
class SwapLockFault final : public Block {
  public:
    In<bool> clk_i{"clk_i"};  ///< core clock, in which FRAMEDONE and FRAMEBAD are driven
    In<bool> swaplock_i{"swaplock_i"};
    In<bool> swapskip_i{"swapskip_i"};
    Out<bool> swaplock_o{"swaplock_o"};
    Out<bool> swapskip_o{"swapskip_o"};

    /// faults: indices in Scenario::faults. Scenario and tally must outlive the module.
    SwapLockFault(const sc_core::sc_module_name& name, const Scenario& scenario,
                  std::vector<std::size_t> faults, FaultTally& tally);
    SC_HAS_PROCESS(SwapLockFault);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

  private:
    void clock_edge();
    void update();

    WireHolds holds_;
    sc_core::sc_signal<bool> hold_;
    sc_core::sc_signal<bool> hold_skip_;
};

}  // namespace metabuffer::rtl
