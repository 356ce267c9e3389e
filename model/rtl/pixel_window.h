#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datapath/smoothing.h"
#include "rtl/composer_signals.h"
#include "rtl/pins.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The read side of a composer's window (section 5.2 of the paper): the pixels of the next raster position, one, or with
/// smoothing up to two columns of two source rows. Each row has a read port of the FIFO, which then gives two words.
///
/// | pixel of the next position | where it is |
/// | --- | --- |
/// | read by the port one position ahead, or before, while columns are replicated | at the FIFO's output |
/// | arrived at the edge before its use | in the beat at the FIFO's write port |
/// | the same, but the column stood still, or the port has read another word since | in the bypass register |
///
/// Raises /metabuffer/merge_stage/pixel if a pixel that has arrived is in none of them.
class PixelWindow {
  public:
    static constexpr std::size_t kMostRows = 2;     ///< the raster pixel's own source row, and the other one
    static constexpr std::size_t kMostColumns = 2;  ///< in the order of the raster
    template <typename Value>
    using Grid = std::array<std::array<Value, kMostColumns>, kMostRows>;

    /// The FIFO's pins; null where the window has no such row or column.
    struct Pins {
        const In<FifoWrite>& write;  ///< what it is about to store
        Grid<const In<std::uint64_t>*> words{};
    };
    /// The positions around an edge.
    struct Steps {
        const RasterStep& next;   ///< composited at the edge after this one
        const RasterStep& ahead;  ///< whose pixels the FIFO reads at this edge, where it reads
    };

    /// lines: rows and columns of the window, 1 or 2. addresses: the FIFO's. pixel_bits: of the index of a segment's
    /// pixel, or of none.
    PixelWindow(RegisterSet& registers, std::size_t lines, int addresses, int pixel_bits, const Pins& pins);

    /// The pixels of a position that have all arrived.
    BlendWindow<Pixel> pixels(const RasterStep& step, const SegmentProgress& progress) const;
    /// The same where nothing is mixed.
    Pixel pixel(const RasterStep& step, const SegmentProgress& progress) const {
        return pixel_at(0, 0, step.pixel, progress);
    }

    /// Call it at each edge, after pixels().
    void clock_edge(const Steps& steps, const SegmentProgress& progress);
    /// Decides what each row's port reads, combinationally: of the position ahead, what has come and is not at hand. The
    /// address is that of the position's first pixel in the row, whether it is read or not.
    void choose_reads(const RasterStep& ahead, const SegmentProgress& progress);
    /// What a row's port reads at the next edge.
    const FifoRead& read(std::size_t row) const { return reads_[row]; }
    /// What is at hand belongs to a frame that is over.
    void forget();

  private:
    using Row = std::array<std::int64_t, kMostColumns>;

    /// A column at a row's port.
    struct Tap {
        Tap(RegisterSet& registers, const std::string& name, int pixel_bits);
        Register<std::int64_t> word_pixel;    ///< at the FIFO's output; -1: none
        Register<std::int64_t> bypass_pixel;  ///< in bypass_word; -1: none
        Register<std::uint64_t> bypass_word;

        bool has(std::int64_t pixel) const { return word_pixel == pixel || bypass_pixel == pixel; }
    };

    Row row_of(std::size_t row, const RasterStep& step) const;
    std::optional<std::uint64_t> at_hand(std::size_t row, std::size_t column, std::int64_t pixel,
                                         const SegmentProgress& progress) const;
    Pixel pixel_at(std::size_t row, std::size_t column, std::int64_t pixel,
                   const SegmentProgress& progress) const;
    const Tap& tap(std::size_t row, std::size_t column) const { return *taps_[row * lines_ + column]; }
    Tap& tap(std::size_t row, std::size_t column) { return *taps_[row * lines_ + column]; }

    FifoRead read_for(std::size_t row, const RasterStep& ahead, const SegmentProgress& progress) const;

    std::size_t lines_;
    int addresses_;
    Pins pins_;
    std::array<FifoRead, kMostRows> reads_{};
    std::vector<std::unique_ptr<Tap>> taps_;
};

}  // namespace metabuffer::rtl
