#include "report/waits.h"

namespace metabuffer::waits {

using std::to_string;

std::string for_pair_request(std::int64_t pair) {
    return "waits for its input framebuffer to ask for pair " + to_string(pair);
}

std::string in_silence(std::int64_t pair) { return "is silent before pair " + to_string(pair); }

std::string for_link_frame(const PairFollower& pairs) {
    switch (pairs.expect()) {
        case PairFollower::Expect::kAnyColour:
            return "waits for a good colour frame";
        case PairFollower::Expect::kColour:
            return "waits for the next colour frame";
        case PairFollower::Expect::kDepth:
            return "waits for the depth frame of pair " + to_string(pairs.number());
    }
    return {};
}

std::string for_control_characters() { return "waits for control characters on every channel"; }

std::string for_pair(std::int64_t pair) { return "waits for pair " + to_string(pair) + " from the link"; }

std::string for_tableready(std::int64_t frame) {
    return "waits for TABLEREADY of every composer to broadcast the table of frame " + to_string(frame);
}

std::string for_memory_page() { return "waits for its memory to open a page"; }

std::string for_memory_refresh() { return "waits for its memory's refresh to end"; }

std::string for_memory_write() { return "waits for the link's words to be written to its memory"; }

std::string for_lost_slot() { return "lets a lost slot pass"; }

std::string for_busready(const std::vector<int>& displays, std::int64_t pixels, std::int64_t frame) {
    std::string composers;
    for (const int display : displays) {
        composers += (composers.empty() ? "" : ", ") + to_string(display);
    }
    return "waits for BUSREADY of the composers of display " + composers + " with " + to_string(pixels) +
           " pixels of frame " + to_string(frame) + " to send";
}

std::string for_segment_pixel(std::int64_t pixel, std::int64_t frame, int x, int y) {
    return "waits for pixel " + to_string(pixel) + " of its segment in frame " + to_string(frame) +
           " at raster position " + to_string(x) + ", " + to_string(y);
}

std::string for_column() { return "waits for its column to move on"; }

std::string for_table(std::int64_t frame) { return "waits for the table of frame " + to_string(frame); }

std::string for_prefetch(std::int64_t frame) {
    return "waits for its buffer to be prefetched with frame " + to_string(frame);
}

std::string for_pipeready(std::int64_t frame) {
    return "waits for PIPEREADY from below for frame " + to_string(frame);
}

std::string for_startframe(std::int64_t frame) { return "waits for STARTFRAME of frame " + to_string(frame); }

std::string for_raster_pixel(std::int64_t position, std::int64_t frame) {
    return "waits for raster pixel " + to_string(position) + " of frame " + to_string(frame);
}

std::string for_swaplock(std::int64_t frame) {
    return "waits for SWAPLOCK to show frame " + to_string(frame);
}

}  // namespace metabuffer::waits
