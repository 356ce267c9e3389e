#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "datapath/composer_buffer.h"
#include "datapath/smoothing.h"
#include "rtl/fifo_wires.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The read side of a composer that smooths (section 5.2 of the paper, "advanced smoothing"): it has the pixels of two
/// source rows at hand that the next raster pixel is mixed of, up to two columns of each. Each row has a read port of the
/// FIFO, which gives two consecutive words, and two registers for words that bypass the FIFO.
///
/// As in a composer that replicates, a port is read one position ahead, unless its output has the words already, as it
/// does for half a source pixel. A pixel bypasses the FIFO that comes at the edge before its use, or that is still to be
/// used while the column stands still.
class SmoothingWindow {
  public:
    /// registers: the composer's. pixel_bits: of the index of a segment's pixel, or of none.
    SmoothingWindow(RegisterSet& registers, FifoWires& wires, int pixel_bits);

    /// The pixels of a window that have all arrived; next() was called with this window at the edge before.
    BlendWindow<Pixel> pixels(const BlendWindow<std::int64_t>& window) const;

    /// At this edge the FIFO puts out what it was commanded to read: call it once at each edge.
    void follow_read();
    /// The window of the position composited at the next edge. kept: this edge's beat brings pixels that are stored.
    void next(const BlendWindow<std::int64_t>& window, const ComposerBuffer& buffer, const BusBeat& beat,
              bool kept);
    /// Commands reads for the position after the next one; null if it needs none.
    void read_ahead(const BlendWindow<std::int64_t>* window, const ComposerBuffer& buffer);
    /// What is at hand belongs to a frame that is over.
    void forget();
    /// The FIFO reads for the other row at this edge.
    bool reads() const { return wires_.second_row->read.read().enable; }
    void reset();

  private:
    static constexpr std::size_t kRows = 2;     ///< the raster pixel's own source row, and the other one
    static constexpr std::size_t kColumns = 2;  ///< in the order of the raster
    using Row = std::array<std::int64_t, kColumns>;

    /// A column at a row's port.
    struct Tap {
        Tap(RegisterSet& registers, const std::string& name, int pixel_bits);
        Register<std::int64_t> read_pixel;    ///< that the FIFO was last commanded to read; -1: none
        Register<std::int64_t> stood_pixel;   ///< at the FIFO's output before this edge
        Register<std::int64_t> word_pixel;    ///< at the FIFO's output after this edge
        Register<std::int64_t> bypass_pixel;  ///< in bypass_word
        Register<std::uint64_t> bypass_word;

        bool has(std::int64_t pixel) const { return word_pixel == pixel || bypass_pixel == pixel; }
    };

    static std::array<Row, kRows> rows_of(const BlendWindow<std::int64_t>& window);
    const sc_core::sc_signal<std::uint64_t>& word(std::size_t row, std::size_t column) const;
    sc_core::sc_signal<FifoRead>& port(std::size_t row) {
        return row == 0 ? wires_.read : wires_.second_row->read;
    }

    FifoWires& wires_;
    std::array<std::array<std::unique_ptr<Tap>, kColumns>, kRows> taps_;
};

}  // namespace metabuffer::rtl
