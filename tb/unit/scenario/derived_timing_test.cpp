#include "scenario/derived_timing.h"

#include <catch2/catch.hpp>
#include <utility>

#include "datapath/arbitration/arbitration_table.h"
#include "support/scenarios.h"

namespace metabuffer::test {
namespace {

Scenario machine_of(int image_width_pixels, int image_height_pixels, int link_timeout_pairs) {
    Scenario scenario = with_renderer(small_scenario(64, 48),
                                      renderer_of({PixelImage(image_width_pixels, image_height_pixels)}));
    scenario.link_timeout_pairs = link_timeout_pairs;
    return scenario;
}

TEST_CASE(
    "derived timing: the watchdog waits for the slowest link and for a reset, or as long as the scenario "
    "says") {
    const Scenario quick = machine_of(32, 24, 2);
    const Scenario patient = machine_of(32, 24, 50);
    const auto timeout_picoseconds = [](const Scenario& scenario) {
        return link_timeout_clocks(scenario, scenario.renderers.front()) *
               clock_period_picoseconds(scenario.clocks.dvi_in_mhz);
    };
    for (const Scenario& scenario : {quick, patient}) {
        CHECK(watchdog_interval_picoseconds(scenario) > 2 * timeout_picoseconds(scenario));
    }
    CHECK(watchdog_interval_picoseconds(patient) - watchdog_interval_picoseconds(quick) ==
          2 * (timeout_picoseconds(patient) - timeout_picoseconds(quick)));
    Scenario first_is_slow = machine_of(200, 150, 20);
    first_is_slow.renderers.push_back(machine_of(32, 24, 20).renderers.front());
    Scenario last_is_slow = machine_of(32, 24, 20);
    last_is_slow.renderers.push_back(machine_of(200, 150, 20).renderers.front());
    const std::int64_t interval = watchdog_interval_picoseconds(first_is_slow);
    CHECK(interval == watchdog_interval_picoseconds(last_is_slow));
    CHECK(interval > watchdog_interval_picoseconds(machine_of(200, 150, 20)));
    CHECK(least_reset_cycles({100.0, 100.0, 100.0}) == 2);
    CHECK(least_reset_cycles({100.0, 25.0, 400.0}) == 8);
    CHECK(least_reset_cycles({100.0, 400.0, 30.0}) == 7);
    CHECK(least_reset_cycles({25.0, 100.0, 50.0}) == 2);
    // Periods of 101 and 152 ps: two of the slower are one picosecond more than three of the core's.
    CHECK(least_reset_cycles({1e6 / 101, 1e6 / 152, 1e6 / 101}) == 4);

    const Scenario without = machine_of(32, 24, 2);
    Scenario with = without;
    Fault reset;
    reset.kind = FaultKind::kReset;
    reset.cycles = 70'000;
    with.faults = {reset};
    CHECK(watchdog_interval_picoseconds(with) - watchdog_interval_picoseconds(without) ==
          2 * 70'000 * clock_period_picoseconds(with.clocks.core_mhz));
    Scenario scenario = machine_of(32, 24, 2);
    scenario.clocks.core_mhz = 50;
    scenario.watchdog_cycles = 777;
    CHECK(watchdog_interval_picoseconds(scenario) == 777 * 20'000);
}

TEST_CASE("derived timing: the watchdog's default is twice the sum of the silences, and 10,000 clocks") {
    Scenario scenario = machine_of(32, 24, 3);
    scenario.clocks = {};
    scenario.clocks.core_mhz = 100;
    scenario.clocks.dvi_in_mhz = 50;
    scenario.clocks.dvi_out_mhz = 25;
    scenario.memory.page_miss_cycles = 7;
    scenario.bus.arbitration = Arbitration::kIrsa;
    const std::int64_t link = link_timeout_clocks(scenario, scenario.renderers.front()) * 20'000;
    const std::int64_t display = 2 * DviTiming{64, 48}.frame_clocks() * std::int64_t{40'000};
    const std::int64_t core = (2 * 7 + 1 + 10'000) * std::int64_t{10'000};
    CHECK(watchdog_interval_picoseconds(scenario) == 2 * (link + display) + core);
    Scenario characters = scenario;
    characters.links.layer = LinkLayer::kTmds;
    CHECK(watchdog_interval_picoseconds(characters) - watchdog_interval_picoseconds(scenario) ==
          2 * 7 * (20'000 + 40'000));

    SECTION(
        "a policy that loses slots may lose all of a table, those that were added for fresh composers too") {
        scenario.bus.arbitration = Arbitration::kSlotAllocation;
        REQUIRE(loses_slots(scenario.bus.arbitration));
        const std::int64_t slots = 256 + scenario.displays.count();
        CHECK(watchdog_interval_picoseconds(scenario) ==
              2 * (link + display) + core + 2 * slots * lost_slot_cycles(scenario) * 10'000);
        // The arbiter takes its clocks for each of them, and for the slot that is not lost.
        scenario.bus.grant_cycles = 100;
        CHECK(watchdog_interval_picoseconds(scenario) ==
              2 * (link + display) + core + 2 * (slots * (lost_slot_cycles(scenario) + 100) + 100) * 10'000);
    }
    SECTION("an arbiter that takes clocks for its answer is waited for") {
        scenario.bus.grant_cycles = 100;
        CHECK(watchdog_interval_picoseconds(scenario) == 2 * (link + display) + core + 2 * 100 * 10'000);
    }
    SECTION("the way of a beat and its answer, and a table that the hardware makes, are waited for") {
        scenario.memory.read_latency_cycles = 40;
        scenario.bus.register_stages = 30;
        scenario.bus.slot_table = SlotTableMaker::kBuilt;
        const int slots = 256 + scenario.displays.count();
        CHECK(watchdog_interval_picoseconds(scenario) ==
              2 * (link + display) + core + 2 * (40 + 2 * 30 + slots) * std::int64_t{10'000});
    }
    SECTION("each renderer adds a clock") {
        scenario.renderers.push_back(scenario.renderers.front());
        CHECK(watchdog_interval_picoseconds(scenario) == 2 * (link + display) + core + 10'000);
    }
}

TEST_CASE("derived timing: a pair is given up some pair times and a vertical sync after it was due") {
    for (const int pairs : {1, 3}) {
        const Scenario scenario = machine_of(32, 24, pairs);
        const Renderer& renderer = scenario.renderers.front();
        const DviTiming timing = renderer.timing();
        CHECK(link_timeout_clocks(scenario, renderer) ==
              std::int64_t{2} * pairs * timing.frame_clocks() +
                  std::int64_t{DviTiming::kVerticalSyncLines} * timing.line_clocks());
    }
    Scenario scenario = machine_of(32, 24, 1);
    scenario.renderers.push_back(scenario.renderers.front());
    scenario.clocks.dvi_in_mhz = 100.0;
    CHECK(shortest_link_period_picoseconds(scenario, 1) == 10'000);
    scenario.clocks.dvi_in_mhz = 0.5;
    CHECK(shortest_link_period_picoseconds(scenario, 1) == 2'000'000);
    scenario.clocks.dvi_in_mhz = 100.0;
    for (const int ppm : {-50'000, 20'000, 100'000, 3}) {
        Fault drift;
        drift.kind = FaultKind::kDrift;
        drift.renderer = 1;
        drift.ppm = ppm;
        scenario.faults.push_back(drift);
    }
    CHECK(shortest_link_period_picoseconds(scenario, 1) == 9'090);
    CHECK(shortest_link_period_picoseconds(scenario, 0) == 10'000);
}

TEST_CASE("derived timing: beats, what is in flight, and what can come between two of them") {
    MemoryConfig memory;
    BusConfig bus;
    const auto pixels = [&](int width_bits, int words_per_cycle) {
        bus.width_bits = width_bits;
        memory.words_per_cycle = words_per_cycle;
        return pixels_per_beat(bus, memory);
    };
    CHECK(pixels(16, 4) == 1);
    CHECK(cycles_per_beat(bus) == 4);
    CHECK(pixels(32, 4) == 1);
    CHECK(cycles_per_beat(bus) == 2);
    CHECK(pixels(64, 4) == 1);
    CHECK(cycles_per_beat(bus) == 1);
    CHECK(pixels(128, 4) == 2);
    CHECK(pixels(512, 4) == 4);
    CHECK(pixels(512, 1) == 1);
    CHECK(cycles_per_beat(bus) == 1);
    CHECK(idle_bus_bits(32, 1) == 0);
    CHECK(idle_bus_bits(128, 4) == 0);
    CHECK(idle_bus_bits(512, 1) == 7 * 64);
    CHECK(idle_bus_bits(512, 3) == 5 * 64);
    Scenario scenario;
    scenario.memory.words_per_cycle = 2;
    scenario.bus.width_bits = 128;
    CHECK(in_flight_pixels(scenario.bus, scenario.memory) == 2 * 2);
    scenario.memory.read_latency_cycles = 3;
    CHECK(bus_delay_cycles(scenario.bus, scenario.memory) == 3);
    CHECK(bus_loop_cycles(scenario.bus, scenario.memory) == 3);
    CHECK(in_flight_pixels(scenario.bus, scenario.memory) == (2 + 3) * 2);
    scenario.bus.register_stages = 2;
    CHECK(bus_delay_cycles(scenario.bus, scenario.memory) == 5);
    CHECK(bus_loop_cycles(scenario.bus, scenario.memory) == 7);
    CHECK(in_flight_pixels(scenario.bus, scenario.memory) == (2 + 7) * 2);
    // The registers do not move faster than the beats: with four clocks a beat, one more beat fits the loop of seven.
    scenario.bus.width_bits = 16;
    CHECK(in_flight_pixels(scenario.bus, scenario.memory) == 2 + 1);
    CHECK(longest_beat_gap_cycles(scenario) == scenario.memory.page_miss_cycles + 4);
    memory = MemoryConfig();
    bus = BusConfig();
    CHECK(busready_cut_cycles(bus, memory) == 1);
    memory.read_latency_cycles = 3;
    bus.register_stages = 2;
    CHECK(busready_cut_cycles(bus, memory) == 1 + 3 + 2 + 2);
    scenario = Scenario();
    scenario.bus.width_bits = 16;  // four clocks a beat
    scenario.memory.page_miss_cycles = 9;
    scenario.memory.precharge_cycles = 2;
    CHECK(longest_beat_gap_cycles(scenario) == 9 + 4);
    scenario.memory.refresh_cycles = 30;
    scenario.memory.refresh_interval_cycles = 500;
    CHECK(longest_beat_gap_cycles(scenario) == 9 + 30 + 7 + 4);
    scenario = Scenario();
    scenario.memory.words_per_cycle = 4;
    scenario.bus.width_bits = 256;
    for (const auto& [burst_pixels, beats] : {std::pair{1, 1}, {3, 1}, {4, 1}, {5, 2}, {32, 8}, {33, 9}}) {
        scenario.bus.burst_pixels = burst_pixels;
        CHECK(lost_slot_cycles(scenario) == beats);
    }
    scenario.bus.width_bits = 16;  // four clocks for each pixel
    CHECK(lost_slot_cycles(scenario) == 4 * 33);
}

TEST_CASE(
    "derived timing: a memory's images, banks and refreshes, and what a block of the link's words waits "
    "for") {
    MemoryConfig memory;
    memory.page_words = 8;
    for (const auto& [words, device] : {std::pair{1, 8}, {7, 8}, {8, 8}, {9, 16}, {16, 16}, {17, 24}}) {
        CHECK(memory.device_words(words) == device);
        CHECK(memory.memory_words(words) == words);
    }
    memory.ports = MemoryPorts::kShared;
    CHECK(memory.memory_words(9) == 16 + 9);
    memory.words_per_cycle = 4;
    for (const auto& [words, cycles] : {std::pair{1, 1}, {4, 1}, {5, 2}, {8, 2}}) {
        CHECK(memory.write_cycles(words) == cycles);
    }
    memory = MemoryConfig();
    CHECK_FALSE(memory.times_banks());
    CHECK_FALSE(memory.refreshes());
    memory.precharge_cycles = memory.refresh_cycles = 1;
    CHECK(memory.times_banks());
    CHECK(memory.refreshes());
    memory.page_miss_cycles = 5;
    CHECK(memory.opening_cycles(false) == 4);
    CHECK(memory.opening_cycles(true) == 5);
    Scenario scenario;
    scenario.memory.page_miss_cycles = 9;
    scenario.memory.words_per_cycle = 4;
    scenario.memory.write_block_words = 30;
    scenario.memory.ports = MemoryPorts::kShared;
    CHECK(longest_write_cycles(scenario.memory, 30) == 9 + 8);
    CHECK(longest_write_cycles(scenario.memory, 1) == 9 + 1);
    CHECK(longest_write_delay_cycles(scenario.memory) == 3 + 9 + 17);
    CHECK(longest_word_wait_cycles(scenario) == 9 + 3 * (17 + 9));
    scenario.memory.refresh_cycles = 30;
    scenario.memory.refresh_interval_cycles = 500;
    CHECK(longest_write_delay_cycles(scenario.memory) == 3 + 9 + 17 + 30 + 17);
    CHECK(longest_word_wait_cycles(scenario) == 9 + 30 + 9 + 3 * (17 + 9));
    CHECK(least_block_cycles(scenario.memory) == 3 + 9 + 17 + 30 + 17 + 9);
    CHECK(least_refresh_interval_cycles(scenario.memory) == 30 + 2 * 9 + 2 * 17 + 1);
    scenario.memory.ports = MemoryPorts::kDual;
    CHECK(least_refresh_interval_cycles(scenario.memory) == 30 + 9 + 1);
}

TEST_CASE("derived timing: how long an arbiter makes a slot table, and a fault lasts") {
    BusConfig bus;
    CHECK(bus.build_cycles(7) == 0);
    bus.slot_table = SlotTableMaker::kBuilt;
    CHECK(bus.build_cycles(7) == 7);
    Fault fault;
    fault.from_cycle = 10;
    for (const std::int64_t cycle : {10, 14, 15, 1'000'000'000}) CHECK(fault.lasts_at(cycle));
    CHECK_FALSE(fault.lasts_at(9));
    fault.cycles = 5;
    CHECK_FALSE(fault.lasts_at(9));
    CHECK(fault.lasts_at(10));
    CHECK(fault.lasts_at(14));
    CHECK_FALSE(fault.lasts_at(15));
}

}  // namespace
}  // namespace metabuffer::test
