#include "rtl/table_unit.h"

#include "scenario/link_program.h"

namespace metabuffer::rtl {

TableUnit::TableUnit(const sc_core::sc_module_name& name, const BusConfig& bus, const ViewportLimits& limits)
    : Block(name),
      bus_(bus),
      tables_{Tables{TableJudge(limits), {}}, Tables{TableJudge(limits), {}}},
      back_rows_(registers_, "back_rows", bits_for(limits.displays)) {
    SC_METHOD(show_front);
    sensitive << front_i << reset_i;
    dont_initialize();
}

void TableUnit::reset() {
    for (Tables& tables : tables_) {
        tables.rows.clear();
        tables.slots.clear();
    }
    note_back();
}

void TableUnit::link_edge() {
    const DecoderEvent& event = event_i.read();
    if (event.colour_start) {
        back().rows.clear();
        back().slots.clear();
    }
    if (event.row) {
        back().rows.take(event.table_row);
    }
    back().slots.insert(back().slots.end(), event.payload.begin(),
                        event.payload.begin() + event.payload_bytes);
    if (event.row || event.payload_bytes > 0) {
        clocked_.stay_awake();
    }
    note_back();
}

void TableUnit::note_back() {
    back_rows_ = static_cast<int>(back_table().rows.size());
    back_slot_bytes_ = static_cast<int>(back().slots.size());
}

void TableUnit::show_front() {
    if (reset_i.read()) {
        table_o.write(FrontTable{});
        return;
    }
    const Tables& front = tables_[front_i.read() ? 1 : 0];
    table_o.write({front.rows.result().rows, slots_of(front).slots});
}

SentSlots TableUnit::slots_of(const Tables& tables) const {
    return machine_slots(bus_, tables.rows.result(), tables.slots);
}

void TableUnit::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
