#include "monitors/bus_timing.h"

#include "monitors/delay_line.h"

namespace metabuffer::monitors {
namespace {

constexpr int kBitsOfPixel = 64;

struct CutBurst {
    int beats = 0;   ///< from the one on at whose edge BUSREADY falls
    int cycles = 0;  ///< from that edge to the last beat
};

/// A burst without end on an open page, clock by clock. BUSREADY falls at the edge that samples its second beat.
CutBurst cut_burst(int beat_cycles, int read_latency, int stages) {
    DelayLine<bool> to_composer(read_latency + stages, false);
    DelayLine<bool> to_framebuffer(stages, true);
    bool beat = false;     // driven by the framebuffer at the last edge
    bool busready = true;  // driven by the composer at the last edge
    int beat_left = 0;     // clocks of the beat that moves
    int beats_come = 0;
    CutBurst cut;
    int since_fall = 0;
    for (int silent = 0; busready || silent <= beat_cycles + read_latency + 2 * stages + 1; ++silent) {
        const bool comes = to_composer.pass(beat);
        const bool goes_on = to_framebuffer.pass(busready);
        // The framebuffer begins no beat once it has read the fall, and finishes the one that moves.
        if (beat_left == 0 && goes_on) beat_left = beat_cycles;
        beat = beat_left == 1;
        if (beat_left > 0) --beat_left;
        // The composer.
        if (!busready) ++since_fall;
        if (!comes) continue;
        silent = 0;
        if (++beats_come < 2) continue;
        busready = false;
        ++cut.beats;
        cut.cycles = since_fall;
    }
    return cut;
}

/// A word is wanted whose page is not open, and everything that may come between does, as late as it can.
int longest_wait(const MemoryConfig& memory) {
    const int page_miss = memory.page_miss_cycles;
    int clocks = page_miss;
    if (memory.refresh_cycles > 0) {
        // It begins with the clock that the word was to be read in, and leaves every bank closed.
        clocks += memory.refresh_cycles;
        clocks += page_miss - memory.precharge_cycles;
    }
    if (memory.ports == MemoryPorts::kShared) {
        for (int block = 0; block < 3; ++block) {
            clocks += page_miss;  // to the block's page
            for (int left = memory.write_block_words; left > 0; left -= memory.words_per_cycle) ++clocks;
            clocks += page_miss;  // and back
        }
    }
    return clocks;
}

}  // namespace

BusTiming::BusTiming(const Scenario& scenario) {
    const MemoryConfig& memory = scenario.memory;
    const int width = scenario.bus.width_bits;
    const int stages = scenario.bus.register_stages;
    int pixels = 0;
    for (int bits = 0; bits < width && pixels < memory.words_per_cycle; bits += kBitsOfPixel) ++pixels;
    int cycles = 0;
    for (int bits = 0; bits < kBitsOfPixel; bits += width) ++cycles;
    beat_pixels = pixels;
    beat_cycles = cycles;
    in_flight_pixels = std::int64_t{cut_burst(cycles, memory.read_latency_cycles, stages).beats} * pixels;
    // A beat that still moves when the framebuffer reads the fall announces nothing. What it has sent by then may be
    // as close together as beats of one clock.
    cut_cycles = cut_burst(1, memory.read_latency_cycles, stages).cycles;
    loop_cycles = cut_cycles - cut_burst(1, 0, 0).cycles;
    longest_wait_cycles = longest_wait(memory);
    longest_gap_cycles = longest_wait_cycles + beat_cycles;
}

}  // namespace metabuffer::monitors
