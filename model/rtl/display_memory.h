#pragma once

#include <array>
#include <cstdint>
#include <systemc>
#include <vector>

#include "rtl/block.h"
#include "rtl/display_signals.h"

namespace metabuffer::rtl {

/// The memory of an output framebuffer (section 4 of the paper): two pictures, of which one is written while the other is
/// shown. It has a write port and a read port, each with a clock of its own, as a block RAM has.
///
/// | condition | clock | effect |
/// | --- | --- | --- |
/// | writes_i high | core edge | write_i is stored |
/// | reads_i high | DVI output edge | data_o has the pixel of read_i, until the next read |
/// | reads_i high, writes_i high, both with one address | DVI output edge | data_o has the colour of write_i |
///
/// The last line occurs only if a core clock is longer than the six blank lines before a frame.
/// Raises /metabuffer/display_memory/address for an address that it does not have.
class DisplayMemory final : public Block {
  public:
    In<bool> clk_i{"clk_i"};        ///< core clock
    In<bool> reset_i{"reset_i"};    ///< clears data_o; pixels stay
    In<bool> writes_i{"writes_i"};  ///< write_i is to be stored
    In<DisplayWrite> write_i{"write_i"};
    In<bool> dvi_clk_i{"dvi_clk_i"};  ///< DVI output clock
    In<bool> reads_i{"reads_i"};      ///< read_i is to be put out
    In<DisplayRead> read_i{"read_i"};
    Out<std::uint32_t> data_o{"data_o"};  ///< 0xRRGGBB

    /// pixels: of the display, 1 or more.
    DisplayMemory(const sc_core::sc_module_name& name, std::int64_t pixels);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void write_edge();
    void read_edge();
    void reset() { data_o.write(0); }
    std::uint32_t& at(bool picture, std::uint32_t address, const char* what);

    std::array<std::vector<std::uint32_t>, 2> pictures_;
    RegisterSet read_registers_;  ///< none besides data_o
    Clocked write_clocked_{*this, clk_i, &DisplayMemory::write_edge};
    Clocked read_clocked_{
        *this, dvi_clk_i, reset_i, read_registers_, &DisplayMemory::read_edge, &DisplayMemory::reset};
};

}  // namespace metabuffer::rtl
