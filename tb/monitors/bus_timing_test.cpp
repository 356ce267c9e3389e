#include "monitors/bus_timing.h"

#include <catch2/catch.hpp>

#include "support/scenarios.h"

namespace metabuffer::test::bus_timing_test {

// The clocks that the monitors count, worked out by hand. The formulas of model/scenario have tests of their own.

TEST_CASE("bus timing: pixels and clocks of a beat", "[monitors]") {
    struct Beat {
        int width_bits;
        int words_per_cycle;
        int pixels;
        int cycles;
    };
    for (const Beat& beat : {Beat{16, 4, 1, 4},
                             {32, 4, 1, 2},
                             {64, 4, 1, 1},
                             {128, 4, 2, 1},
                             {512, 4, 4, 1},
                             {512, 8, 8, 1},
                             {512, 1, 1, 1}}) {
        Scenario scenario = small_scenario(8, 4);
        scenario.bus.width_bits = beat.width_bits;
        scenario.memory.words_per_cycle = beat.words_per_cycle;
        const monitors::BusTiming timing(scenario);
        INFO(beat.width_bits << " bits, " << beat.words_per_cycle << " words");
        CHECK(timing.beat_pixels == beat.pixels);
        CHECK(timing.beat_cycles == beat.cycles);
    }
}

TEST_CASE("bus timing: what comes of a burst once BUSREADY has fallen, and until when", "[monitors]") {
    struct Bus {
        int width_bits;
        int read_latency;
        int stages;
        int in_flight_beats;
        int cut_cycles;
    };
    for (const Bus& bus :
         {Bus{64, 0, 0, 2, 1},  // the beat at whose edge it falls, and the one that is under way
          {64, 3, 0, 5, 4},     // the memory holds three more
          {64, 0, 2, 6, 5},     // the registers two, and two leave while the fall passes them
          {64, 3, 2, 9, 8},
          {128, 3, 2, 9, 8},
          {32, 3, 2, 5, 8},  // seven clocks are three beats of two
          {16, 3, 2, 3, 8},  // and one of four
          {16, 0, 0, 2, 1}}) {
        Scenario scenario = small_scenario(8, 4);
        scenario.bus.width_bits = bus.width_bits;
        scenario.bus.register_stages = bus.stages;
        scenario.memory.read_latency_cycles = bus.read_latency;
        scenario.memory.words_per_cycle = 2;
        const monitors::BusTiming timing(scenario);
        INFO(bus.width_bits << " bits, read latency " << bus.read_latency << ", " << bus.stages << " stages");
        CHECK(timing.in_flight_pixels == bus.in_flight_beats * timing.beat_pixels);
        CHECK(timing.cut_cycles == bus.cut_cycles);
        CHECK(timing.loop_cycles == bus.read_latency + 2 * bus.stages);
    }
}

TEST_CASE("bus timing: the longest gap in a burst", "[monitors]") {
    Scenario scenario = small_scenario(8, 4);
    MemoryConfig& memory = scenario.memory;
    memory.page_miss_cycles = 9;
    CHECK(monitors::BusTiming(scenario).longest_wait_cycles == 9);
    CHECK(monitors::BusTiming(scenario).longest_gap_cycles == 9 + 1);
    scenario.bus.width_bits = 16;
    CHECK(monitors::BusTiming(scenario).longest_gap_cycles == 9 + 4);
    memory.precharge_cycles = 2;
    memory.refresh_cycles = 30;
    memory.refresh_interval_cycles = 1000;
    CHECK(monitors::BusTiming(scenario).longest_wait_cycles == 9 + 30 + 7);
    memory.ports = MemoryPorts::kShared;
    memory.write_block_words = 7;
    memory.words_per_cycle = 2;
    CHECK(monitors::BusTiming(scenario).longest_wait_cycles == 9 + 30 + 7 + 3 * (9 + 4 + 9));
}

}  // namespace metabuffer::test::bus_timing_test
