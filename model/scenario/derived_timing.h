#pragma once

#include <cstdint>

#include "scenario/scenario.h"

/// Times that follow from a scenario, for every level that has time.
namespace metabuffer {

/// A pair on the renderer's link, in DVI input clocks.
std::int64_t pair_clocks(const Renderer& renderer);

/// DVI input clocks after which a pair that has not come is given up: link_timeout_pairs pair times and, since a
/// link that comes up shows one vertical sync before its first pair, one vertical sync.
std::int64_t link_timeout_clocks(const Scenario& scenario, const Renderer& renderer);

/// Core clocks that a lost slot takes: the beats of a full burst.
int lost_slot_cycles(const Scenario& scenario);

/// The most core clocks in which a memory with shared ports writes a block of the link's words: a page is closed,
/// another opened, and the words follow. words: of the block.
int longest_write_cycles(const MemoryConfig& memory, int words);

/// The most core clocks from a pair's last word to the end of its writing, which its verdict must wait for. words: of its
/// image.
std::int64_t longest_last_write_cycles(const MemoryConfig& memory, std::int64_t words);
/// The clocks of a link from a pair's last word to its verdict.
std::int64_t verdict_link_clocks(const Renderer& renderer);

/// The most core clocks from a block's last word to the end of its writing: two registers of the core clock and a clock
/// to begin, a page that is being opened, a refresh before which the writing would not end, and the writing.
int longest_write_delay_cycles(const MemoryConfig& memory);

/// The least core clocks in which a block of the link's words may come: before the next one is full the block must be
/// written, and the bus must have its page open again.
int least_block_cycles(const MemoryConfig& memory);

/// The least core clocks from one refresh to the next: enough to open a page and read a beat, otherwise the bus would
/// never go on. With shared ports also enough for two blocks of the link's words before that, each of which may close
/// the page, so that no wait for a word meets two refreshes.
std::int64_t least_refresh_interval_cycles(const MemoryConfig& memory);

/// The clock period of a renderer's link where its drift makes it fastest.
std::int64_t shortest_link_period_picoseconds(const Scenario& scenario, std::size_t renderer);

/// With shared ports, the clock periods with which the link's words are written in time on every link, each with the
/// others as they are: the core clock may have this period or a shorter one, the DVI input clock this or a longer one.
std::int64_t longest_core_period_picoseconds(const Scenario& scenario);
std::int64_t shortest_dvi_in_period_picoseconds(const Scenario& scenario);

/// The most core clocks that a burst waits for its next word: a page miss; with refreshes, one that a refresh interrupts,
/// so that the page is opened again. With shared ports up to three blocks of the link's words may come between, and each
/// may close the burst's page.
int longest_word_wait_cycles(const Scenario& scenario);

/// The most core clocks from a beat of a burst to the next one: that wait, and the beat.
int longest_beat_gap_cycles(const Scenario& scenario);

/// The least core clocks that a reset must last so that every clock of the machine sees it: two of the slowest clock.
std::int64_t least_reset_cycles(const ClockConfig& clocks);

/// The time between two checks of the watchdog: watchdog_cycles if that is set, otherwise a little more than twice the
/// longest silence that a healthy run can have.
std::int64_t watchdog_interval_picoseconds(const Scenario& scenario);

}  // namespace metabuffer
