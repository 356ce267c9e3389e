#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "formats/viewport_table.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {

/// The tables of an input framebuffer (sections 5 and 5.3 of the paper): a viewport table and a slot table for each
/// device of the frame memory. The bus side sees those of the front device.
///
/// Each row of the pair that comes in is judged in the clock in which the decoder gives it, and kept if it is valid. A
/// slot table from the host that is missing or wrong is replaced by one slot for each row. A slot table that the
/// hardware makes (`bus.slot_table: built`) is ready at once; bus_arbiter spends the clocks of making it.
class TableUnit final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< DVI input clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<DecoderEvent> event_i{"event_i"};
    In<bool> front_i{"front_i"};         ///< which device the bus reads
    Out<FrontTable> table_o{"table_o"};  ///< of the front device

    TableUnit(const sc_core::sc_module_name& name, const BusConfig& bus, const ViewportLimits& limits);
    SC_HAS_PROCESS(TableUnit);

    void trace(sc_core::sc_trace_file* file) const override;

    /// The rows of the pair that came last, the dropped ones too.
    const ValidatedTable& back_table() const { return back().rows.result(); }
    /// The slot table of that pair is missing or wrong.
    bool back_slots_rejected() const { return slots_of(back()).rejected; }

  private:
    void link_edge();
    void reset();
    void note_back();
    void show_front();
    /// Of one device.
    struct Tables {
        TableJudge rows;
        std::vector<std::uint8_t> slots;  ///< as the host has sent them
    };
    Tables& back() { return tables_[front_i.read() ? 0 : 1]; }
    const Tables& back() const { return tables_[front_i.read() ? 0 : 1]; }
    SentSlots slots_of(const Tables& tables) const;

    BusConfig bus_;
    std::array<Tables, 2> tables_;  ///< by device
    RegisterSet registers_;
    Register<int> back_rows_;  ///< valid ones, of the pair that comes in
    Register<int> back_slot_bytes_{registers_, "back_slot_bytes", 16};
    Clocked clocked_{*this, clk_i, reset_i, registers_, &TableUnit::link_edge, &TableUnit::reset};
};

}  // namespace metabuffer::rtl
