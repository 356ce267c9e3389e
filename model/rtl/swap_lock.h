#pragma once

#include "rtl/block.h"

namespace metabuffer::rtl {

/// The swap lock between the output framebuffers, combinational. SWAPLOCK is high while every FRAMEDONE is: every column
/// has composited its frame. SWAPSKIP is high while any FRAMEBAD is: a frame has lost pixels, and all displays keep their
/// pictures.
class SwapLock final : public Block {
  public:
    PinVector<In<bool>> framedone_i;
    PinVector<In<bool>> framebad_i;
    Out<bool> swaplock_o{"swaplock_o"};
    Out<bool> swapskip_o{"swapskip_o"};

    SwapLock(const sc_core::sc_module_name& name, int displays);
    SC_HAS_PROCESS(SwapLock);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void update();
};

/// One column's stall wire: COLUMNSTALL is high while any composer of the column raises STALL. Combinational.
class ColumnStall final : public Block {
  public:
    PinVector<In<bool>> stall_i;
    Out<bool> column_stall_o{"column_stall_o"};

    ColumnStall(const sc_core::sc_module_name& name, int renderers);
    SC_HAS_PROCESS(ColumnStall);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void update();
};

}  // namespace metabuffer::rtl
