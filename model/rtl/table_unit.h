#pragma once

#include <array>

#include "formats/viewport_table.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The tables of an input framebuffer (sections 5 and 5.3 of the paper): one for each device of the frame memory. The
/// rows of the pair that comes in are judged one by one as the decoder gives them, and those that stand are kept. The
/// bus side sees the front device's rows, and the slot table that the bus's policy makes of them.
///
/// Judging a row takes the clock in which it comes. The slot table takes no time: it is there when the devices have
/// changed places. A table is whole long before that, since its rows come with the colour frame.
class TableUnit final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< DVI input clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<DecoderEvent> event_i{"event_i"};
    sc_core::sc_in<bool> front_i{"front_i"};         ///< which device the bus reads
    sc_core::sc_out<FrontTable> table_o{"table_o"};  ///< of the front device

    TableUnit(const sc_core::sc_module_name& name, Arbitration arbitration, const ViewportLimits& limits);
    SC_HAS_PROCESS(TableUnit);

    void trace(sc_core::sc_trace_file* file) const override;

    /// The rows of the pair that came last, those that were dropped among them.
    const ValidatedTable& back_table() const { return back().result(); }

  private:
    void end_of_elaboration() override;
    void link_edge();
    void show_front();
    TableJudge& back() { return tables_[front_i.read() ? 0 : 1]; }
    const TableJudge& back() const { return tables_[front_i.read() ? 0 : 1]; }

    Arbitration arbitration_;
    ClockGate gate_{ClockGating::kOn};
    sc_core::sc_event_or_list wake_events_;
    std::array<TableJudge, 2> tables_;  ///< by device
    RegisterSet registers_;
    Register<int> back_rows_;  ///< that stand, of the pair that comes in
};

}  // namespace metabuffer::rtl
