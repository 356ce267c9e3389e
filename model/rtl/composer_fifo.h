#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rtl/block.h"
#include "rtl/fifo_wires.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// A composer's local memory (section 5.2 of the paper): a FIFO of the segment's pixels. Its read side is a window that
/// reads a source row again as often as the row is replicated, so a read does not release a pixel. The composer gives
/// the addresses, since it knows which pixels came late or not at all.
///
/// The memory has buffer_addresses(capacity) addresses; after the last comes the first. It never holds more pixels than
/// its capacity.
///
/// For a composer that smooths, the window holds two source rows: the FIFO then has a second read port, and each port
/// gives the word after the one that is read, too.
///
/// All outputs are registered. At a clock's edge
/// - the words of write_i are stored;
/// - with read_i.enable word_o becomes the word at the address, even one that is written at this edge; without, it
///   stays;
/// - free_o becomes what is free after write_i and release_i.
///
/// Raises /metabuffer/composer_fifo/full for more pixels than are free, /metabuffer/composer_fifo/empty for a release of
/// more than it holds, and /metabuffer/composer_fifo/address for an address that it does not have.
class ComposerFifo final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high; what is stored stays
    In<FifoWrite> write_i{"write_i"};
    In<FifoRead> read_i{"read_i"};
    In<FifoRelease> release_i{"release_i"};
    Out<std::uint64_t> word_o{"word_o"};
    Out<std::uint32_t> free_o{"free_o"};

    std::unique_ptr<SecondRowPins> second_row;  ///< null with a window of one row

    /// capacity_pixels: 1 or more; window_rows: 1 or 2.
    ComposerFifo(const sc_core::sc_module_name& name, int capacity_pixels, int window_rows = 1);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void clock_edge();
    void reset();
    void store(const FifoWrite& write);
    void put_out(const FifoRead& read, Out<std::uint64_t>& word, Out<std::uint64_t>* next_word);
    void account(const FifoWrite& write, const FifoRelease& release);
    void refuse(const char* kind, const std::string& what);

    std::uint32_t capacity_;
    std::vector<std::uint64_t> storage_;

    RegisterSet registers_;
    Register<std::uint32_t> level_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &ComposerFifo::clock_edge, &ComposerFifo::reset};
};

}  // namespace metabuffer::rtl
