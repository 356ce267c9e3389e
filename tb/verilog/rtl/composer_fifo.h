#pragma once

#include <cstdint>
#include <memory>

#include "rtl/block.h"
#include "rtl/fifo_wires.h"
#include "rtl/signals.h"

class VerilatedContext;
class VerilatedComposerFifo;

namespace metabuffer::rtl {

/// The FIFO of tb/verilog/composer_fifo.sv, verilated, in the place of model/rtl's: the same ports with the same meaning
/// and timing, which are written at that class, and the same errors.
///
/// Raises /metabuffer/composer_fifo/size at elaboration for a capacity beyond the memory that the module was verilated
/// with, and /metabuffer/composer_fifo/smoothing for a window of more rows than it was verilated with.
class ComposerFifo final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high; what is stored stays
    sc_core::sc_in<FifoWrite> write_i{"write_i"};
    sc_core::sc_in<FifoRead> read_i{"read_i"};
    sc_core::sc_in<FifoRelease> release_i{"release_i"};
    sc_core::sc_out<std::uint64_t> word_o{"word_o"};
    sc_core::sc_out<std::uint32_t> free_o{"free_o"};

    std::unique_ptr<SecondRowPins> second_row;  ///< null with a window of one row

    /// capacity_pixels: 1 or more; window_rows: 1 or 2.
    ComposerFifo(const sc_core::sc_module_name& name, int capacity_pixels, int window_rows = 1);
    ~ComposerFifo() override;
    SC_HAS_PROCESS(ComposerFifo);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void drive_inputs();
    void report_error() const;

    std::unique_ptr<VerilatedContext> context_;
    std::unique_ptr<VerilatedComposerFifo> verilated_;
};

}  // namespace metabuffer::rtl
