#include "rtl/bus_registers.h"

#include "rtl/wires.h"

namespace metabuffer::rtl {

BusRegisters::BusRegisters(const sc_core::sc_module_name& name, int stages, std::size_t composers, int lanes)
    : Block(name),
      busready_i("busready_i", composers),
      busready_o("busready_o", composers),
      tableready_i("tableready_i", composers),
      tableready_o("tableready_o", composers),
      bus_(registers_, "bus_stage", stages, lanes) {
    for (std::size_t composer = 0; composer < composers; ++composer) {
        busready_.emplace_back(registers_, numbered("busready", composer) + "_stage", stages);
        tableready_.emplace_back(registers_, numbered("tableready", composer) + "_stage", stages);
    }
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void BusRegisters::end_of_elaboration() {
    gate_.attach(clk_i);
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= bus_i.value_changed_event();
    for (std::size_t composer = 0; composer < busready_i.size(); ++composer) {
        wake_events_ |= busready_i[composer].value_changed_event();
        wake_events_ |= tableready_i[composer].value_changed_event();
    }
}

/// Every stage holds what comes in.
bool BusRegisters::settled() const {
    bool settled = bus_.holds(bus_i.read());
    for (std::size_t composer = 0; composer < busready_.size(); ++composer) {
        settled = settled && busready_[composer].holds(busready_i[composer].read()) &&
                  tableready_[composer].holds(tableready_i[composer].read());
    }
    return settled;
}

void BusRegisters::clock_edge() {
    if (gate_.opened()) {
        return;
    }
    if (reset_i.read()) {
        registers_.reset();
        drive();
        return;
    }
    const bool idle = settled();
    if (!idle) {
        shift();
        drive();
    }
    if (gate_.idle_edge(idle)) {
        next_trigger(wake_events_);
    }
}

void BusRegisters::shift() {
    bus_.shift(bus_i.read());
    for (std::size_t composer = 0; composer < busready_.size(); ++composer) {
        busready_[composer].shift(busready_i[composer].read());
        tableready_[composer].shift(tableready_i[composer].read());
    }
}

void BusRegisters::drive() {
    bus_o.write(bus_.last());
    for (std::size_t composer = 0; composer < busready_.size(); ++composer) {
        busready_o[composer].write(busready_[composer].last());
        tableready_o[composer].write(tableready_[composer].last());
    }
}

void BusRegisters::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
