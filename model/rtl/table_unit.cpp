#include "rtl/table_unit.h"

#include "datapath/arbitration/arbitration_table.h"

namespace metabuffer::rtl {

TableUnit::TableUnit(const sc_core::sc_module_name& name, Arbitration arbitration,
                     const ViewportLimits& limits)
    : Block(name),
      arbitration_(arbitration),
      tables_{TableJudge(limits), TableJudge(limits)},
      back_rows_(registers_, "back_rows", bits_for(limits.displays)) {
    SC_METHOD(link_edge);
    sensitive << clk_i.pos();
    dont_initialize();
    SC_METHOD(show_front);
    sensitive << front_i << reset_i;
    dont_initialize();
}

void TableUnit::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= event_i.value_changed_event();
}

void TableUnit::link_edge() {
    if (gate_.opened()) {
        return;
    }
    const DecoderEvent& event = event_i.read();
    if (reset_i.read()) {
        for (TableJudge& table : tables_) {
            table.clear();
        }
        registers_.reset();
    } else {
        if (event.colour_start) {
            back().clear();
        }
        if (event.row) {
            back().take(event.table_row);
        }
        back_rows_ = static_cast<int>(back_table().rows.size());
    }
    if (gate_.idle_edge(!event.row && !event.colour_start)) {
        next_trigger(wake_events_);
    }
}

void TableUnit::show_front() {
    if (reset_i.read()) {
        table_o.write(FrontTable{});
        return;
    }
    const ViewportTable& rows = tables_[front_i.read() ? 1 : 0].result().rows;
    table_o.write({rows, slots_of(arbitration_, rows)});
}

void TableUnit::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
