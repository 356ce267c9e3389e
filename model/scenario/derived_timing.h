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

/// Core clocks in which a memory with shared ports writes a block of the link's words, at the most: a page is closed,
/// another opened, and the words follow. words: of the block.
int longest_write_cycles(const MemoryConfig& memory, int words);

/// Core clocks from a block's last word to the end of its writing, at the most: two registers of the core clock and the
/// clock that begins, a page that is being opened, a refresh that leaves no room before it, and the writing.
int longest_write_delay_cycles(const MemoryConfig& memory);

/// Core clocks that a block of the link's words must take to come, at the least: it is written before the next one is
/// full, and the bus has its page open again before that.
int least_block_cycles(const MemoryConfig& memory);

/// Core clocks from one refresh to the next, at the least: in between a page can be opened and a beat read, or the bus
/// would never go on. With shared ports two blocks of the link's words may come before that, and each may close the page,
/// so that no wait for a word meets two refreshes.
std::int64_t least_refresh_interval_cycles(const MemoryConfig& memory);

/// Of a renderer's link, where its drift makes it fastest.
std::int64_t shortest_link_period_picoseconds(const Scenario& scenario, std::size_t renderer);

/// Core clocks that a burst waits for its next word, at the most: a page miss, or one with a refresh within it and the
/// page's opening anew. With shared ports blocks of the link's words may come between, three at the most, and each may
/// close the burst's page.
int longest_word_wait_cycles(const Scenario& scenario);

/// Core clocks from a beat of a burst to the next one, at the most: that wait, and the beat.
int longest_beat_gap_cycles(const Scenario& scenario);

/// Core clocks that a reset must last at the least for every clock of the machine to see it: two of the slowest.
std::int64_t least_reset_cycles(const ClockConfig& clocks);

/// Between two looks of the watchdog: watchdog_cycles if that is set, otherwise a little more than twice the
/// longest silence that a healthy run can have.
std::int64_t watchdog_interval_picoseconds(const Scenario& scenario);

}  // namespace metabuffer
