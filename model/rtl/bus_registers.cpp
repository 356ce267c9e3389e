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
}

void BusRegisters::reset() {
    registers_.reset();
    drive();
}

void BusRegisters::clock_edge() {
    bus_.shift(bus_i.read());
    for (std::size_t composer = 0; composer < busready_.size(); ++composer) {
        busready_[composer].shift(busready_i[composer].read());
        tableready_[composer].shift(tableready_i[composer].read());
    }
    drive();
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
