#include "rtl/handshake_fault.h"

#include <algorithm>
#include <utility>

#include "rtl/mixed_bits.h"

namespace metabuffer::rtl {
namespace {

constexpr std::uint64_t kPercent = 100;

}  // namespace

WireHolds::WireHolds(const Scenario& scenario, const HeldWire& wire, std::vector<std::size_t> faults,
                     FaultTally& tally)
    : scenario_(scenario),
      wire_(wire),
      faults_(std::move(faults)),
      tally_(tally),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)) {}

bool WireHolds::holds(std::size_t fault, std::int64_t core_cycle, std::int64_t edge) const {
    const Fault& cause = scenario_.faults[fault];
    if (!cause.lasts_at(core_cycle)) {
        return false;
    }
    if (cause.kind != FaultKind::kRandomStalls) {
        return true;
    }
    std::uint64_t word = mixed_bits(cause.seed);
    word = mixed_bits(word ^ static_cast<std::uint64_t>(wire_.handshake));
    word = mixed_bits(word ^ wire_.renderer);
    word = mixed_bits(word ^ wire_.display);
    word = mixed_bits(word ^ static_cast<std::uint64_t>(edge));
    return word % kPercent < static_cast<std::uint64_t>(cause.percent);
}

bool WireHolds::any_holds(std::int64_t core_cycle, std::int64_t edge) const {
    return std::any_of(faults_.begin(), faults_.end(),
                       [&](std::size_t fault) { return holds(fault, core_cycle, edge); });
}

bool WireHolds::at_next_edge(bool changed) {
    ++edge_;
    if (changed) {
        for (const std::size_t fault : faults_) {
            if (holds(fault, core_cycle_, edge_)) {
                tally_.took_effect(fault);
            }
        }
    }
    core_cycle_ = clock_edge_number(core_period_picoseconds_) + 1;
    return any_holds(core_cycle_, edge_ + 1);
}

// ---- one wire ----

HandshakeFault::HandshakeFault(const sc_core::sc_module_name& name, const Scenario& scenario, HeldWire wire,
                               std::vector<std::size_t> faults, FaultTally& tally)
    : Block(name),
      wire_(std::move(wire)),
      holds_(scenario, wire_, std::move(faults), tally),
      stopped_burst_cycles_(stopped_burst_cycles(scenario)),
      hold_("hold", holds_.at_first_edge()) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.port().pos();
    dont_initialize();
    SC_METHOD(update);
    sensitive << wire_i << hold_;
}

void HandshakeFault::clock_edge() {
    const bool raised = wire_i.read();
    const bool seen_high = wire_o.read();
    bool hold = holds_.at_next_edge(raised != seen_high);
    if (wire_.handshake == Handshake::kPipeready || wire_.handshake == Handshake::kFramedone) {
        hold = hold && !seen_high;
    } else if (wire_.handshake == Handshake::kBusready) {
        if (hold && seen_high) {
            stopped_left_ = stopped_burst_cycles_;
        } else if (stopped_left_ > 0) {
            stopped_left_ = raised ? stopped_left_ - 1 : 0;
        }
        hold = hold || stopped_left_ > 0;
    }
    hold_.write(hold);
}

void HandshakeFault::update() {
    wire_o.write(holds_high() ? wire_i.read() || hold_.read() : wire_i.read() && !hold_.read());
}

void HandshakeFault::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, wire_i.port(), path("wire_in"));
    sc_core::sc_trace(file, wire_o.port(), path("wire"));
    sc_core::sc_trace(file, hold_, path("hold"));
}

std::string HandshakeFault::waiting_for() const {
    if (wire_i.read() == wire_o.read()) {
        return "";
    }
    return "holds " + wire_.name + (holds_high() ? " high" : " low");
}

// ---- the swap lock ----

SwapLockFault::SwapLockFault(const sc_core::sc_module_name& name, const Scenario& scenario,
                             std::vector<std::size_t> faults, FaultTally& tally)
    : Block(name),
      holds_(scenario, {Handshake::kSwaplock, scenario.renderers.size() - 1, 0, "SWAPLOCK"},
             std::move(faults), tally),
      hold_("hold", holds_.at_first_edge()),
      hold_skip_("hold_skip", hold_.read()) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.port().pos();
    dont_initialize();
    SC_METHOD(update);
    sensitive << swaplock_i << swapskip_i << hold_ << hold_skip_;
}

void SwapLockFault::clock_edge() {
    const bool locked = swaplock_o.read();
    const bool skipped = swapskip_o.read();
    const bool held = holds_.at_next_edge(swaplock_i.read() != locked || swapskip_i.read() != skipped);
    hold_.write(held && !locked);
    hold_skip_.write(held && !locked && !skipped);
}

void SwapLockFault::update() {
    swaplock_o.write(swaplock_i.read() && !hold_.read());
    swapskip_o.write(swapskip_i.read() && !hold_skip_.read());
}

void SwapLockFault::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, swaplock_i.port(), path("SWAPLOCK_in"));
    sc_core::sc_trace(file, swaplock_o.port(), path("SWAPLOCK"));
    sc_core::sc_trace(file, swapskip_i.port(), path("SWAPSKIP_in"));
    sc_core::sc_trace(file, swapskip_o.port(), path("SWAPSKIP"));
    sc_core::sc_trace(file, hold_, path("hold"));
}

std::string SwapLockFault::waiting_for() const {
    return swaplock_i.read() && !swaplock_o.read() ? "holds SWAPLOCK low" : "";
}

}  // namespace metabuffer::rtl
