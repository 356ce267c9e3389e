#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "rtl/bus_fault.h"
#include "rtl/fault_tally.h"
#include "rtl/handshake_fault.h"
#include "rtl/link_clock.h"
#include "rtl/tmds_fault.h"
#include "rtl/wires.h"

namespace metabuffer::rtl {

/// The modules that carry out a scenario's faults inside the machine. One is made only where a fault needs it, between
/// a wire's sender and its reader. Wires holds what the readers see; this class holds what the senders drive.
class MachineFaults {
  public:
    /// Scenario and wires must outlive it. To be made, and its signals to be asked for, while the machine is built.
    MachineFaults(const Scenario& scenario, Wires& wires);

    /// The clock of a renderer's link if a fault lets it drift, else null. It follows wires.clock_ppm.
    sc_core::sc_signal<bool>* drifting_clock(std::size_t renderer, std::int64_t nominal_period_picoseconds);

    /// The signal that the block which raises `wire` must drive: the wire itself if no fault holds it. renderer and
    /// display (indices) are the wire's in Wires; clk is the clock of the block that reads it.
    sc_core::sc_signal<bool>& raised(Handshake handshake, std::size_t renderer, std::size_t display,
                                     sc_core::sc_signal<bool>& wire, sc_core::sc_signal<bool>& clk);

    /// Those that drift.
    void stop_clocks();

    /// The signal that a renderer's TMDS encoder must drive: wires.tmds_in itself if no fault disturbs it. reset, clk:
    /// of the link.
    sc_core::sc_signal<TmdsLink>& encoded(std::size_t renderer, sc_core::sc_signal<bool>& clk,
                                          sc_core::sc_signal<bool>& reset);

    /// What the swap lock must drive.
    struct SwapWires {
        sc_core::sc_signal<bool>& swaplock;
        sc_core::sc_signal<bool>& swapskip;
    };
    /// The same for SWAPLOCK and SWAPSKIP.
    SwapWires raised_swap(sc_core::sc_signal<bool>& core_clk);

    /// The bus for a composer to read; Wires::bus_seen_by gives the same from then on.
    sc_core::sc_signal<BusBeat>& bus_for(std::size_t renderer, std::size_t display);

    const std::vector<const Block*>& blocks() const { return blocks_; }

    /// A handshake wire with a fault module, as its block drives it and as its reader sees it, for monitors.
    struct Handshaking {
        Handshake handshake;
        std::size_t renderer;  ///< of the wire in Wires, index
        std::size_t display;
        const sc_core::sc_signal<bool>& driven;
        const sc_core::sc_signal<bool>& seen;
    };
    const std::vector<Handshaking>& handshakes() const { return handshakes_; }

    static constexpr std::int64_t kNoChange = std::numeric_limits<std::int64_t>::max();
    /// Whether a fault holds the machine in reset at that core clock; such a fault is counted.
    bool reset_at(std::int64_t cycle);
    /// The first core clock after `cycle` at which such a fault begins or ends; kNoChange if there is none.
    std::int64_t next_reset_change(std::int64_t cycle) const;

    /// How often faults inside the machine have taken effect on a renderer's row; a lost beat counts each time.
    std::int64_t injected_faults(std::size_t renderer) const;

  private:
    template <typename Predicate>
    std::vector<std::size_t> faults_that(Predicate concerned) const;
    std::vector<std::size_t> faults_of_wire(Handshake handshake, std::size_t renderer,
                                            std::size_t display) const;
    std::vector<std::size_t> resets() const;
    sc_core::sc_signal<bool>& driven(const HeldWire& wire, const sc_core::sc_signal<bool>& seen);

    const Scenario& scenario_;
    Wires& wires_;
    FaultTally tally_;
    std::vector<std::unique_ptr<sc_core::sc_signal<bool>>> signals_;
    std::vector<std::unique_ptr<LinkClock>> link_clocks_;
    std::vector<std::unique_ptr<TmdsFault>> tmds_faults_;
    std::vector<std::unique_ptr<HandshakeFault>> handshake_faults_;
    std::unique_ptr<SwapLockFault> swap_lock_fault_;
    std::vector<std::unique_ptr<BusFault>> bus_faults_;
    std::vector<Handshaking> handshakes_;
    std::vector<const Block*> blocks_;
};

}  // namespace metabuffer::rtl
