#pragma once

#include <cstdint>

#include "cover_group.h"
#include "rtl/fifo_wires.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

struct FifoGoals : CoverGroup {
    explicit FifoGoals(Coverage& coverage)
        : CoverGroup(coverage, {"fifo/ports", "what happens at the ports of a composer's FIFO"}) {}
    Bin write = bin("a write");
    Bin write_wraps = bin("a beat is written around the last address");
    Bin read = bin("a read");
    Bin read_of_written = bin("a word is read at the edge that writes it");
    Bin read_again = bin("an address is read again, for a row's next repetition");
    Bin both = bin("write, read and release at one edge");
    Bin release_one = bin("one pixel is released");
    Bin release_several = bin("several are released");
    Bin release_abandoned = bin("pixels of an abandoned frame are released");
    Bin full = bin("full");
    Bin drained = bin("empty again");
    Bin second_read = bin("both rows of a window are read at one edge");
};

/// Follows the wires between one composer and its FIFO, clock by clock.
class FifoCoverage {
  public:
    /// Goals must outlive it.
    FifoCoverage(const FifoGoals& goals, const Scenario& scenario);

    /// A clock without reset.
    void clock(rtl::FifoWires& wires);

  private:
    const FifoGoals& goals_;
    std::uint32_t capacity_;
    std::uint32_t addresses_;
    std::uint32_t last_read_ = 0;  ///< address
    bool has_read_ = false;
    std::uint32_t free_ = 0;  ///< in the clock before
};

}  // namespace metabuffer::coverage
