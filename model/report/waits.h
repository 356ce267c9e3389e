#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datapath/link/pair_follower.h"

/// What a block waits for when the watchdog ends a run, in the words of the report: the same at every level, and for
/// any replacement of a block. Each is the rest of a line that begins with the block's name. Pairs and frames count
/// from 0, displays from 1.
namespace metabuffer::waits {

// ---- DVI source ----
std::string for_pair_request(std::int64_t pair);
std::string in_silence(std::int64_t pair);

// ---- DVI decoder ----
std::string for_link_frame(const PairFollower& pairs);

// ---- TMDS decoder ----
std::string for_control_characters();

// ---- input framebuffer ----
std::string for_pair(std::int64_t pair);
std::string for_tableready(std::int64_t frame);
std::string for_memory_page();
std::string for_memory_refresh();
std::string for_memory_write();
std::string for_lost_slot();
/// displays: of the composers that pixels are left for; pixels: how many are left for all of them.
std::string for_busready(const std::vector<int>& displays, std::int64_t pixels, std::int64_t frame);

// ---- composer ----
/// pixel: its index in the segment; x, y: the raster position that needs it.
std::string for_segment_pixel(std::int64_t pixel, std::int64_t frame, int x, int y);
std::string for_column();
std::string for_table(std::int64_t frame);
std::string for_prefetch(std::int64_t frame);
std::string for_pipeready(std::int64_t frame);

// ---- composer, output framebuffer ----
std::string for_startframe(std::int64_t frame);

// ---- output framebuffer ----
std::string for_raster_pixel(std::int64_t position, std::int64_t frame);
std::string for_swaplock(std::int64_t frame);

}  // namespace metabuffer::waits
