#include "rtl/bus_registers.h"

#include "rtl/wires.h"

namespace metabuffer::rtl {

template <typename Value>
BusRegisters::Line<Value> BusRegisters::line(const std::string& wire, int stages) {
    Line<Value> line;
    for (int stage = 1; stage <= stages; ++stage) {
        line.push_back(
            std::make_unique<Register<Value>>(registers_, wire + "_stage_" + std::to_string(stage)));
    }
    return line;
}

BusRegisters::BusRegisters(const sc_core::sc_module_name& name, int stages, std::size_t composers)
    : Block(name),
      busready_i("busready_i", composers),
      busready_o("busready_o", composers),
      tableready_i("tableready_i", composers),
      tableready_o("tableready_o", composers),
      bus_(line<BusBeat>("bus", stages)) {
    for (std::size_t composer = 0; composer < composers; ++composer) {
        busready_.push_back(line<bool>(numbered("busready", composer), stages));
        tableready_.push_back(line<bool>(numbered("tableready", composer), stages));
    }
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void BusRegisters::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= bus_i.value_changed_event();
    for (std::size_t composer = 0; composer < busready_i.size(); ++composer) {
        wake_events_ |= busready_i[composer].value_changed_event();
        wake_events_ |= tableready_i[composer].value_changed_event();
    }
}

/// True if any register changes.
template <typename Value>
bool BusRegisters::shift(Line<Value>& line, const Value& input) {
    bool changes = false;
    for (std::size_t stage = line.size(); stage-- > 0;) {
        const Value& next = stage == 0 ? input : line[stage - 1]->value();
        if (!(*line[stage] == next)) {
            *line[stage] = next;
            changes = true;
        }
    }
    return changes;
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
    bool changes = shift(bus_, bus_i.read());
    for (std::size_t composer = 0; composer < busready_.size(); ++composer) {
        changes = shift(busready_[composer], busready_i[composer].read()) || changes;
        changes = shift(tableready_[composer], tableready_i[composer].read()) || changes;
    }
    if (changes) {
        drive();
    }
    if (gate_.idle_edge(!changes)) {
        next_trigger(wake_events_);
    }
}

void BusRegisters::drive() {
    bus_o.write(*bus_.back());
    for (std::size_t composer = 0; composer < busready_.size(); ++composer) {
        busready_o[composer].write(*busready_[composer].back());
        tableready_o[composer].write(*tableready_[composer].back());
    }
}

void BusRegisters::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
