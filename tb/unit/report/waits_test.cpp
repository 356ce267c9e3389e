#include "report/waits.h"

#include <catch2/catch.hpp>

namespace metabuffer {
namespace {

DecodedScanline good_scanline(FrameKind kind, std::uint32_t number) {
    DecodedScanline scanline;
    scanline.content.kind = kind;
    scanline.content.frame_number = number;
    return scanline;
}

TEST_CASE("waits: in words") {
    CHECK(waits::for_pair_request(3) == "waits for its input framebuffer to ask for pair 3");
    CHECK(waits::in_silence(4) == "is silent before pair 4");
    CHECK(waits::for_pair(1) == "waits for pair 1 from the link");

    PairFollower pairs;
    CHECK(waits::for_link_frame(pairs) == "waits for a good colour frame");
    PairEvent event;
    pairs.begin_frame();
    pairs.end_control_scanline(good_scanline(FrameKind::kColour, 4'000'000'000), event);
    pairs.end_frame(true, event);
    CHECK(waits::for_link_frame(pairs) == "waits for the depth frame of pair 4000000000");
    pairs.begin_frame();
    pairs.end_control_scanline(good_scanline(FrameKind::kDepth, 4'000'000'000), event);
    pairs.end_frame(true, event);
    CHECK(waits::for_link_frame(pairs) == "waits for the next colour frame");
    CHECK_FALSE(pairs.in_frame());
    CHECK(waits::for_tableready(2) ==
          "waits for TABLEREADY of every composer to broadcast the table of frame 2");
    CHECK(waits::for_memory_page() == "waits for its memory to open a page");
    CHECK(waits::for_lost_slot() == "lets a lost slot pass");
    CHECK(waits::for_busready({2}, 7, 0) ==
          "waits for BUSREADY of the composers of display 2 with 7 pixels of frame 0 to send");
    CHECK(waits::for_busready({1, 3, 4}, 70'000, 5) ==
          "waits for BUSREADY of the composers of display 1, 3, 4 with 70000 pixels of frame 5 to send");
    CHECK(waits::for_segment_pixel(12, 1, 30, 40) ==
          "waits for pixel 12 of its segment in frame 1 at raster position 30, 40");
    CHECK(waits::for_column() == "waits for its column to move on");
    CHECK(waits::for_table(1) == "waits for the table of frame 1");
    CHECK(waits::for_prefetch(1) == "waits for its buffer to be prefetched with frame 1");
    CHECK(waits::for_pipeready(0) == "waits for PIPEREADY from below for frame 0");
    CHECK(waits::for_startframe(0) == "waits for STARTFRAME of frame 0");
    CHECK(waits::for_raster_pixel(76'799, 2) == "waits for raster pixel 76799 of frame 2");
    CHECK(waits::for_swaplock(2) == "waits for SWAPLOCK to show frame 2");
}

}  // namespace
}  // namespace metabuffer
