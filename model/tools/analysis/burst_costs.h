#pragma once

#include <cstdint>
#include <vector>

#include "datapath/segment.h"
#include "scenario/scenario.h"

namespace metabuffer::analysis {

/// Up to three pixels at either end of a smoothed source row may be needed, or released, at once: the raster's edges cut
/// short what lies beside it. So arithmetic goes one pixel beyond those. Between the ends the raster takes one pixel every
/// Dmultiple positions. Where the raster's top or bottom cuts a row, all of the row may be needed or released at once.
constexpr std::int64_t kUnevenPixels = 4;

/// Whether the first word of a burst finds its page open.
enum class FirstWord : std::uint8_t {
    kMisses,  ///< another composer's burst may have come between and have opened another page
    kExact,   ///< no other burst comes between: the page is open if the burst before ended in it
    kHits,    ///< all that the table sends lies in one page: only the frame's very first word misses
};

/// How long the bursts of one composer's segment hold the bus, in core clocks, if none is cut short. Burst b carries
/// the pixels from b * burst_pixels on. Every page miss and every beat follows from their addresses. The arbiter's clocks
/// are a burst's first.
///
/// Every time is `stretch` times what the bus and the open pages need: TakenClocks::stretch(), where the memory has
/// something else to do now and then. Only total_cycles() is without.
class BurstCosts {
  public:
    BurstCosts(const Segment& segment, int image_width_pixels, const BusConfig& bus,
               const MemoryConfig& memory, FirstWord first_word, double stretch = 1.0);

    std::int64_t bursts() const { return static_cast<std::int64_t>(latest_start_.size()); }
    /// Clocks of all bursts before burst b; b from 0 to bursts().
    double before(std::int64_t b) const {
        return stretch_ * static_cast<double>(before_[static_cast<std::size_t>(b)]);
    }
    double total() const { return before(bursts()); }
    std::int64_t total_cycles() const { return before_.back(); }
    std::int64_t page_misses() const { return page_misses_; }
    std::int64_t beats() const { return beats_; }
    /// The clock of this raster position is the last one in which burst b may be granted so that none of its pixels
    /// comes too late. A pixel that comes `cycles` clocks after the grant allows its first use less `cycles`.
    double latest_start(std::int64_t b) const { return latest_start_[static_cast<std::size_t>(b)]; }
    /// Clocks from its burst's grant until pixel k is on the bus, those of its own beat included. From there it may take
    /// some more to its composer.
    double until_pixel(std::int64_t k) const;

    /// The longest burst, wherever in the segment it begins.
    double longest() const { return longest_; }
    /// Any `count` bursts in a row take at most count * average + excess clocks.
    double average() const { return average_; }
    double excess() const { return excess_; }

    /// How many pixels of the segment, from k on and without a gap, lie in k's page; k is included.
    std::int64_t pixels_in_page(std::int64_t k) const;

  private:
    /// Pixels of a burst that lie in one source row and in one page.
    struct Piece {
        std::int64_t first = 0;
        std::int64_t last = 0;
        std::int64_t run_first =
            0;  ///< first pixel since the burst began or opened this page; a beat begins with it
        std::int64_t waited = 0;  ///< clocks of the burst before that beat
        bool opens_page = false;
        bool begins_run = false;
    };

    template <typename Visit>
    void walk(std::int64_t b, Visit visit) const;
    std::int64_t address_of(std::int64_t k) const;
    std::int64_t page_of(std::int64_t k) const { return address_of(k) / page_words_; }
    std::int64_t piece_end(std::int64_t k) const;
    std::int64_t cycles_to(std::int64_t k, const Piece& piece) const {
        return piece.waited + ((k - piece.run_first) / pixels_per_beat_ + 1) * cycles_per_beat_;
    }
    void add_burst(std::int64_t b);
    void find_longest();
    void find_excess();

    Segment segment_;
    std::int64_t image_width_;
    std::int64_t burst_pixels_;
    std::int64_t page_words_;
    std::int64_t page_miss_cycles_;
    std::int64_t pixels_per_beat_;
    std::int64_t cycles_per_beat_;
    std::int64_t grant_cycles_;
    std::int64_t delay_cycles_;
    FirstWord first_word_;
    double stretch_;
    std::vector<std::int64_t> before_;
    std::vector<double> latest_start_;
    std::int64_t page_misses_ = 0;
    std::int64_t beats_ = 0;
    double longest_ = 0.0;
    double average_ = 0.0;
    double excess_ = 0.0;
};

}  // namespace metabuffer::analysis
