#include "rtl/machine_faults.h"

#include <algorithm>
#include <string>
#include <utility>

#include "scenario/fault_keys.h"
#include "scenario/fault_kinds.h"

namespace metabuffer::rtl {
namespace {

/// The names of a wire and of the fault module in it, for the waveform.
struct WireName {
    std::string wire;   ///< "BUSREADY_1_2"
    std::string fault;  ///< "busready_fault_1_2"
};

WireName name_of(Handshake handshake, std::size_t renderer, std::size_t display) {
    const char* const wire = to_string(handshake);
    switch (handshake) {
        case Handshake::kBusready:
            return {numbered(wire, renderer, display), numbered("busready_fault", renderer, display)};
        case Handshake::kTableready:
            return {numbered(wire, renderer, display), numbered("tableready_fault", renderer, display)};
        case Handshake::kPipeready:
            return {numbered(wire, renderer, display), numbered("pipeready_fault", renderer, display)};
        case Handshake::kPairRequest:
            return {numbered(wire, renderer), numbered("pair_request_fault", renderer)};
        case Handshake::kStall:
            return {numbered(wire, renderer, display), numbered("stall_fault", renderer, display)};
        case Handshake::kFramedone:
            return {numbered(wire, display), numbered("framedone_fault", display)};
        case Handshake::kSwaplock:
        case Handshake::kSwapskip:
            return {wire, "swap_lock_fault"};
    }
    return {};
}

bool is_of_display(const Fault& fault, std::size_t display) {
    return fault.display == static_cast<int>(display) + 1;
}

}  // namespace

MachineFaults::MachineFaults(const Scenario& scenario, Wires& wires)
    : scenario_(scenario), wires_(wires), tally_(scenario.faults.size()) {}

template <typename Predicate>
std::vector<std::size_t> MachineFaults::faults_that(Predicate concerned) const {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < scenario_.faults.size(); ++i) {
        if (concerned(scenario_.faults[i])) {
            indices.push_back(i);
        }
    }
    return indices;
}

std::vector<std::size_t> MachineFaults::faults_of_wire(Handshake handshake, std::size_t renderer,
                                                       std::size_t display) const {
    return faults_that([&](const Fault& fault) {
        const auto row = static_cast<std::size_t>(handshake == Handshake::kPipeready
                                                      ? HandshakeFault::pipeready_row(fault.renderer)
                                                      : fault.renderer);
        if (row != renderer) {
            // The stalls of the last row hold back the output framebuffers below it too.
            return fault.kind == FaultKind::kRandomStalls && handshake == Handshake::kPipeready &&
                   renderer == scenario_.renderers.size() && row + 1 == renderer;
        }
        switch (fault.kind) {
            case FaultKind::kBusreadyLow:
                return handshake == Handshake::kBusready && is_of_display(fault, display);
            case FaultKind::kPipereadyLow:
                return handshake == Handshake::kPipeready && is_of_display(fault, display);
            case FaultKind::kRandomStalls:
                // In glitch mode nothing reads STALL.
                return handshake != Handshake::kStall || scenario_.composer.may_stall();
            default:
                return false;
        }
    });
}

sc_core::sc_signal<bool>* MachineFaults::drifting_clock(std::size_t renderer,
                                                        std::int64_t nominal_period_picoseconds) {
    const auto drifts = faults_that([renderer](const Fault& fault) {
        return fault.kind == FaultKind::kDrift && static_cast<std::size_t>(fault.renderer) == renderer;
    });
    if (drifts.empty()) {
        return nullptr;
    }
    signals_.push_back(std::make_unique<sc_core::sc_signal<bool>>(numbered("dvi_in_clk", renderer).c_str()));
    link_clocks_.push_back(
        std::make_unique<LinkClock>(numbered("link_clock", renderer).c_str(), nominal_period_picoseconds));
    link_clocks_.back()->clock_ppm_i(wires_.clock_ppm[renderer]);
    link_clocks_.back()->clk_o(*signals_.back());
    blocks_.push_back(link_clocks_.back().get());
    return signals_.back().get();
}

void MachineFaults::stop_clocks() {
    for (const auto& clock : link_clocks_) clock->stop();
}

sc_core::sc_signal<TmdsLink>& MachineFaults::encoded(std::size_t renderer, sc_core::sc_signal<bool>& clk,
                                                     sc_core::sc_signal<bool>& reset) {
    if (disturbs_characters(scenario_, renderer)) {
        std::vector<std::size_t> noise = faults_that([renderer](const Fault& fault) {
            return fault.kind == FaultKind::kTmdsNoise &&
                   static_cast<std::size_t>(fault.renderer) == renderer;
        });
        tmds_faults_.push_back(std::make_unique<TmdsFault>(numbered("tmds_fault", renderer).c_str(),
                                                           scenario_, std::move(noise), tally_));
        TmdsFault& module = *tmds_faults_.back();
        module.clk_i(clk);
        module.reset_i(reset);
        module.disturbance_i(wires_.disturbance[renderer]);
        module.tmds_i(wires_.own_tmds_in(renderer));
        module.tmds_o(wires_.tmds_in[renderer]);
        blocks_.push_back(&module);
    }
    return wires_.tmds_in_driven(renderer);
}

sc_core::sc_signal<bool>& MachineFaults::raised(Handshake handshake, std::size_t renderer,
                                                std::size_t display, sc_core::sc_signal<bool>& wire,
                                                sc_core::sc_signal<bool>& clk) {
    std::vector<std::size_t> faults = faults_of_wire(handshake, renderer, display);
    if (faults.empty()) {
        return wire;
    }
    const WireName name = name_of(handshake, renderer, display);
    const HeldWire held{handshake, renderer, display, name.wire};
    sc_core::sc_signal<bool>& from = driven(held, wire);
    handshake_faults_.push_back(
        std::make_unique<HandshakeFault>(name.fault.c_str(), scenario_, held, std::move(faults), tally_));
    HandshakeFault& module = *handshake_faults_.back();
    module.clk_i(clk);
    module.wire_i(from);
    module.wire_o(wire);
    blocks_.push_back(&module);
    return from;
}

/// Makes a new signal for the block that raises the wire.
sc_core::sc_signal<bool>& MachineFaults::driven(const HeldWire& wire, const sc_core::sc_signal<bool>& seen) {
    signals_.push_back(std::make_unique<sc_core::sc_signal<bool>>((wire.name + "_raised").c_str()));
    handshakes_.push_back({wire.handshake, wire.renderer, wire.display, *signals_.back(), seen});
    return *signals_.back();
}

MachineFaults::SwapWires MachineFaults::raised_swap(sc_core::sc_signal<bool>& core_clk) {
    const std::size_t last_row = scenario_.renderers.size() - 1;
    std::vector<std::size_t> faults = faults_of_wire(Handshake::kSwaplock, last_row, 0);
    if (faults.empty()) {
        return {wires_.swaplock, wires_.swapskip};
    }
    const SwapWires from{driven({Handshake::kSwaplock, last_row, 0, "SWAPLOCK"}, wires_.swaplock),
                         driven({Handshake::kSwapskip, last_row, 0, "SWAPSKIP"}, wires_.swapskip)};
    swap_lock_fault_ = std::make_unique<SwapLockFault>(
        name_of(Handshake::kSwaplock, last_row, 0).fault.c_str(), scenario_, std::move(faults), tally_);
    swap_lock_fault_->clk_i(core_clk);
    swap_lock_fault_->swaplock_i(from.swaplock);
    swap_lock_fault_->swapskip_i(from.swapskip);
    swap_lock_fault_->swaplock_o(wires_.swaplock);
    swap_lock_fault_->swapskip_o(wires_.swapskip);
    blocks_.push_back(swap_lock_fault_.get());
    return from;
}

sc_core::sc_signal<BusBeat>& MachineFaults::bus_for(std::size_t renderer, std::size_t display) {
    const std::size_t composer = renderer * wires_.framedone.size() + display;
    std::vector<std::size_t> faults = faults_that([&](const Fault& fault) {
        return fault.kind == FaultKind::kLostBeat && static_cast<std::size_t>(fault.renderer) == renderer &&
               is_of_display(fault, display);
    });
    if (!faults.empty()) {
        bus_faults_.push_back(std::make_unique<BusFault>(numbered("bus_fault", renderer, display).c_str(),
                                                         scenario_, display, std::move(faults), tally_));
        bus_faults_.back()->bus_i(wires_.bus[renderer]);
        bus_faults_.back()->bus_o(wires_.own_bus(composer));
        blocks_.push_back(bus_faults_.back().get());
    }
    return wires_.bus_seen_by(composer);
}

std::vector<std::size_t> MachineFaults::resets() const {
    return faults_that([](const Fault& fault) { return fault.kind == FaultKind::kReset; });
}

bool MachineFaults::reset_at(std::int64_t cycle) {
    bool in_reset = false;
    for (const std::size_t i : resets()) {
        if (scenario_.faults[i].lasts_at(cycle)) {
            tally_.took_effect(i);
            in_reset = true;
        }
    }
    return in_reset;
}

std::int64_t MachineFaults::next_reset_change(std::int64_t cycle) const {
    std::int64_t next = kNoChange;
    for (const std::size_t i : resets()) {
        const Fault& fault = scenario_.faults[i];
        for (const std::int64_t change : {fault.from_cycle, fault.from_cycle + fault.cycles.value_or(0)}) {
            if (change > cycle) {
                next = std::min(next, change);
            }
        }
    }
    return next;
}

std::int64_t MachineFaults::injected_faults(std::size_t renderer) const {
    std::int64_t count = 0;
    for (std::size_t i = 0; i < scenario_.faults.size(); ++i) {
        const Fault& fault = scenario_.faults[i];
        const bool whole_machine = !fault_traits(fault.kind).names_renderer();
        if (whole_machine || static_cast<std::size_t>(fault.renderer) == renderer) {
            count += tally_.count(i);
        }
    }
    return count;
}

}  // namespace metabuffer::rtl
