#include "rtl/handshake_fault.h"

#include <algorithm>
#include <utility>

namespace metabuffer::rtl {
namespace {

constexpr std::uint64_t kPercent = 100;

/// The finalizer of SplitMix64: every bit of the result depends on every bit of the word.
std::uint64_t mixed(std::uint64_t word) {
    word += 0x9E37'79B9'7F4A'7C15U;
    word = (word ^ (word >> 30U)) * 0xBF58'476D'1CE4'E5B9U;
    word = (word ^ (word >> 27U)) * 0x94D0'49BB'1331'11EBU;
    return word ^ (word >> 31U);
}

}  // namespace

HandshakeFault::HandshakeFault(const sc_core::sc_module_name& name, const Scenario& scenario, Wire wire,
                               std::vector<std::size_t> faults, FaultTally& tally)
    : Block(name),
      scenario_(scenario),
      wire_(std::move(wire)),
      faults_(std::move(faults)),
      tally_(tally),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      stopped_burst_cycles_(stopped_burst_cycles(scenario)),
      hold_("hold", any_holds(0, 0)) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
    SC_METHOD(update);
    sensitive << wire_i << hold_;
}

bool HandshakeFault::holds(std::size_t fault, std::int64_t core_cycle, std::int64_t edge) const {
    const Fault& cause = scenario_.faults[fault];
    const std::int64_t since = core_cycle - cause.from_cycle;
    if (since < 0 || (cause.cycles && since >= *cause.cycles)) {
        return false;
    }
    if (cause.kind != FaultKind::kRandomStalls) {
        return true;
    }
    std::uint64_t word = mixed(cause.seed);
    word = mixed(word ^ static_cast<std::uint64_t>(wire_.handshake));
    word = mixed(word ^ wire_.renderer);
    word = mixed(word ^ wire_.display);
    word = mixed(word ^ static_cast<std::uint64_t>(edge));
    return word % kPercent < static_cast<std::uint64_t>(cause.percent);
}

bool HandshakeFault::any_holds(std::int64_t core_cycle, std::int64_t edge) const {
    return std::any_of(faults_.begin(), faults_.end(),
                       [&](std::size_t fault) { return holds(fault, core_cycle, edge); });
}

void HandshakeFault::clock_edge() {
    ++edge_;
    const bool raised = wire_i.read();
    const bool seen_high = wire_o.read();
    if (raised && !seen_high) {
        for (const std::size_t fault : faults_) {
            if (holds(fault, core_cycle_, edge_)) {
                tally_.took_effect(fault);
            }
        }
    }
    core_cycle_ = clock_edge_number(core_period_picoseconds_) + 1;
    bool hold = any_holds(core_cycle_, edge_ + 1);
    if (wire_.handshake == Handshake::kPipeready) {
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

void HandshakeFault::update() { wire_o.write(wire_i.read() && !hold_.read()); }

void HandshakeFault::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, wire_i, path("wire_in"));
    sc_core::sc_trace(file, wire_o, path("wire"));
    sc_core::sc_trace(file, hold_, path("hold"));
}

std::string HandshakeFault::waiting_for() const {
    return wire_i.read() && !wire_o.read() ? "holds " + wire_.name + " low" : "";
}

}  // namespace metabuffer::rtl
