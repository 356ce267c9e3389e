#pragma once

#include <cstddef>
#include <cstdint>

#include "scenario/scenario.h"

namespace metabuffer::analysis {

/// The clocks that a memory takes from the bursts for something else: to refresh itself and, with shared ports, to write
/// the link's words. Of any T clocks in a row these are at most share * T + once.
struct TakenClocks {
    double share = 0.0;
    double once = 0.0;

    /// What is left of T clocks is at least (T - latency()) / stretch(). So work of c clocks, the bus's and that of
    /// opening pages, is done after stretch() * c + latency() clocks at the latest.
    double stretch() const;
    double latency() const { return stretch() * once; }
};

/// A refresh, or a block of the link's words, as an interruption of a burst.
struct Interruption {
    double cycles = 0.0;     ///< with the clocks to open the burst's page again; 0: there is none
    double per_cycle = 0.0;  ///< how many there are in a clock, as a mean over a long time
    double share() const { return cycles * per_cycle; }
};
Interruption refreshes(const MemoryConfig& memory);
/// Of a block of the link's words: it opens a page and closes the burst's.
double write_cycles(const MemoryConfig& memory);
/// Of a link that always sends, at its fastest.
Interruption link_writes(const Scenario& scenario, std::size_t renderer);

/// The least clocks of the memory in which the link's words of one image are written: each page opened once.
std::int64_t least_write_cycles(const MemoryConfig& memory, std::int64_t image_words);

/// opens_each: the bursts' own clocks have a page miss at the first word of each. Otherwise an interruption between two
/// bursts costs the second one a page miss that its own clocks do not have.
TakenClocks taken_clocks(const Scenario& scenario, std::size_t renderer, bool opens_each);

}  // namespace metabuffer::analysis
