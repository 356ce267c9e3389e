#include "monitors/bus_monitor.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "clocked_testbench.h"
#include "support/scenarios.h"
#include "violations.h"

namespace metabuffer::test::bus_monitor_test {

// A stream breaks each rule of docs/monitors.md once, and no other rule before it.
namespace {

using rtl::BusBeat;

constexpr int kImageWidth = 8;  // a page of the memory is a scanline
constexpr int kEnd = 60;

Scenario bus_scenario(int burst_pixels = 6, int width_bits = 128) {
    Scenario scenario = small_scenario(8, 4, 2);
    scenario.memory.page_words = kImageWidth;
    scenario.memory.page_miss_cycles = 3;
    scenario.memory.words_per_cycle = 2;
    scenario.bus.width_bits = width_bits;
    scenario.bus.burst_pixels = burst_pixels;
    scenario.composer.buffer_pixels = 16;
    scenario.composer.ready_space_pixels = 4;
    scenario.frames = 2;
    scenario.renderers.push_back(renderer_of({PixelImage(kImageWidth, 4)}));
    return scenario;
}

/// The input framebuffer and the composers' wires, played by the test.
struct BusBench {
    ClockedTestbench bench;
    Scenario scenario;
    Violations violations{bench.core};
    sc_core::sc_signal<BusBeat> bus{"BUS_1"};
    sc_core::sc_signal<bool> busready_1{"BUSREADY_1_1"};
    sc_core::sc_signal<bool> busready_2{"BUSREADY_1_2"};
    sc_core::sc_signal<bool> tableready_1{"TABLEREADY_1_1"};
    sc_core::sc_signal<bool> tableready_2{"TABLEREADY_1_2"};
    monitors::BusMonitor monitor;
    std::map<int, BusBeat> beats;  ///< by the clock that samples them
    std::set<int> busready_1_low;
    std::set<int> tableready_2_low;

    explicit BusBench(Scenario with = bus_scenario())
        : scenario(std::move(with)), monitor("monitor", scenario, 0, violations.log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.bus_i(bus);
        monitor.busready_i[0](busready_1);
        monitor.busready_i[1](busready_2);
        monitor.tableready_i[0](tableready_1);
        monitor.tableready_i[1](tableready_2);
        bench.core.each_clock([this](int clock) {
            const auto beat = beats.find(clock);
            bus.write(beat == beats.end() ? BusBeat{} : beat->second);
            busready_1.write(busready_1_low.count(clock) == 0);
            busready_2.write(true);
            tableready_1.write(true);
            tableready_2.write(tableready_2_low.count(clock) == 0);
        });
    }

    void run() { bench.run_through(kEnd); }

    void put(int clock, int destination, int first, int remaining, int count = 2) {
        BusBeat beat;
        beat.kind = BusBeat::Kind::kPixels;
        beat.destination = static_cast<std::uint16_t>(destination);
        beat.first = static_cast<std::uint32_t>(first);
        beat.remaining = static_cast<std::uint32_t>(remaining);
        beat.count = static_cast<std::uint8_t>(count);
        beats[clock] = beat;
    }
    void misname(int clock, std::uint32_t frame) { beats.at(clock).frame = frame; }
    /// A frame's start at clock 10, and two rows of 4 x 2 pixels after it.
    void put_table() {
        beats[10] = BusBeat::frame_start(0, false);
        beats[11] = BusBeat::table_row(0, 0, row(1), false);
        beats[12] = BusBeat::table_row(0, 1, row(2), true);
    }
    static ViewportRow row(int display) {
        return table_row(display, {display == 1 ? 0 : 4, 0}, {4, 2}, {1, 1});
    }
    /// A frame and the start of the next, by the timing table.
    void put_frame() {
        put_table();
        // Granted at 12, the page open three clocks later; two beats, another page, one beat.
        put(16, 1, 0, 4);
        put(17, 1, 2, 2);
        put(21, 1, 4, 0);
        put(25, 2, 0, 4);
        put(26, 2, 2, 2);
        put(30, 2, 4, 0);
        // What is left of both lies in the open page.
        put(31, 1, 6, 0);
        put(32, 2, 6, 0);
        beats[40] = BusBeat::frame_start(1, true);
    }
};

}  // namespace

TEST_CASE("bus monitor: a stream by the rules breaks none", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.bursts() == 4);
    CHECK(bench.monitor.pixels_sent() == 16);
    CHECK(bench.monitor.frames_started() == 2);
}

TEST_CASE("bus monitor: a frame starts only when every TABLEREADY was high", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.tableready_2_low = {39};
    bench.run();
    bench.violations.check_only("bus/tableready", "BUS_1", 40, 1);
}

TEST_CASE("bus monitor: a TABLEREADY that falls at the frame's start is in time", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.tableready_2_low = {38, 40};
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: a frame is sent to its end before the next one starts", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.beats.erase(32);
    bench.run();
    bench.violations.check_only("bus/incomplete", "BUS_1", 40, 0);
}

TEST_CASE("bus monitor: no more frames than the run has", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.beats[45] = BusBeat::frame_start(2, true);
    bench.run();
    bench.violations.check_only("bus/frames", "BUS_1", 45, 2);
}

TEST_CASE("bus monitor: a frame's start names the next frame", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.misname(40, 2);
    bench.run();
    bench.violations.check_only("bus/frame-number", "BUS_1", 40, 0);
}

TEST_CASE("bus monitor: a row names the frame that has started", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.misname(12, 1);
    bench.run();
    bench.violations.check_only("bus/frame-number", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: pixels name the frame that has started", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.misname(26, 255);
    bench.run();
    bench.violations.check_only("bus/frame-number", "BUS_1", 26, 0);
}

TEST_CASE("bus monitor: the frames' numbers go on", "[monitors]") {
    constexpr int kFrames = 300;
    Scenario scenario = bus_scenario();
    scenario.frames = kFrames;
    BusBench bench(scenario);
    for (int i = 0; i < kFrames; ++i)
        bench.beats[2 + 2 * i] = BusBeat::frame_start(static_cast<std::uint32_t>(i), true);
    bench.bench.run_through(2 * kFrames + 5);
    bench.violations.check_none();
    CHECK(bench.monitor.frames_started() == kFrames);
}

TEST_CASE("bus monitor: a row names its index in the table", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.beats[12].first = 2;
    bench.run();
    bench.violations.check_only("bus/row-number", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: a table row that is late", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.beats[13] = bench.beats[12];
    bench.beats.erase(12);
    bench.run();
    bench.violations.check_only("bus/table", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: a row after the last of its table", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.beats[11] = BusBeat::table_row(0, 0, BusBench::row(1), true);
    bench.run();
    bench.violations.check_only("bus/table", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: pixels before their table is complete", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.beats[12] = BusBeat::table_row(0, 1, BusBench::row(2), false);
    bench.run();
    bench.violations.check_first("bus/table", "BUS_1", 13, 0);
}

TEST_CASE("bus monitor: a second row for a display", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.beats[12] = BusBeat::table_row(0, 1, BusBench::row(1), true);
    bench.run();
    bench.violations.check_only("bus/row", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: a row for a display that is not there", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.beats[12] = BusBeat::table_row(0, 1, BusBench::row(3), true);
    bench.run();
    bench.violations.check_only("bus/row", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: a row whose last pixel lies off the raster", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.beats[12] = BusBeat::table_row(0, 1, table_row(2, {0, 0}, {4, 2}, {5, 1}), true);
    bench.run();
    bench.violations.check_only("bus/row", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: a row that the buffer can never serve", "[monitors]") {
    Scenario scenario = bus_scenario();
    scenario.composer.buffer_pixels = 7;
    BusBench bench(scenario);
    bench.put_table();
    bench.beats[12] = BusBeat::table_row(0, 1, table_row(2, {0, 0}, {4, 1}, {0, 0}, 2), true);
    bench.run();
    bench.violations.check_only("bus/row", "BUS_1", 12, 0);
}

TEST_CASE("bus monitor: pixels for a display without a row", "[monitors]") {
    BusBench bench;
    bench.beats[10] = BusBeat::frame_start(0, false);
    bench.beats[11] = BusBeat::table_row(0, 0, BusBench::row(1), true);
    bench.put(15, 2, 0, 4);
    bench.run();
    bench.violations.check_only("bus/destination", "BUS_1", 15, 0);
}

TEST_CASE("bus monitor: one burst at a time", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.put(16, 1, 0, 4);
    bench.put(17, 2, 0, 4);
    bench.put(18, 2, 2, 2);
    bench.put(22, 2, 4, 0);
    bench.run();
    bench.violations.check_only("bus/one-burst", "BUS_1", 17, 0);
}

TEST_CASE("bus monitor: a beat carries what the width and the page allow", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.put(26, 2, 2, 3, 1);
    bench.run();
    bench.violations.check_first("bus/count", "BUS_1", 26, 0);
}

TEST_CASE("bus monitor: a beat announces what comes after it", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.put(17, 1, 2, 3);
    bench.run();
    bench.violations.check_only("bus/remaining", "BUS_1", 17, 0);
}

TEST_CASE("bus monitor: a burst is no longer than it may be", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.put(16, 1, 0, 6);
    bench.run();
    bench.violations.check_only("bus/remaining", "BUS_1", 16, 0);
}

TEST_CASE("bus monitor: a pixel that is lost", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.put(17, 1, 3, 2);
    bench.run();
    bench.violations.check_only("bus/order", "BUS_1", 17, 0);
}

TEST_CASE("bus monitor: a pixel that comes twice", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.put(31, 1, 4, 0);
    bench.run();
    bench.violations.check_only("bus/order", "BUS_1", 31, 0);
}

TEST_CASE("bus monitor: a pixel after its segment's last", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.put(34, 1, 8, 0);
    bench.run();
    bench.violations.check_only("bus/beyond", "BUS_1", 34, 0);
}

TEST_CASE("bus monitor: a beat of a burst that is late", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.beats.erase(17);
    bench.run();
    bench.violations.check_first("bus/pace", "BUS_1", 17, 0);
}

TEST_CASE("bus monitor: a beat of a burst before its page is open", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.beats.erase(21);
    bench.put(20, 1, 4, 0);
    bench.run();
    bench.violations.check_only("bus/pace", "BUS_1", 20, 0);
}

TEST_CASE("bus monitor: a burst that begins before its page is open", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.put(15, 1, 0, 4);
    bench.put(16, 1, 2, 2);
    bench.put(20, 1, 4, 0);
    bench.run();
    bench.violations.check_only("bus/pace", "BUS_1", 15, 0);
}

TEST_CASE("bus monitor: a slot for a composer whose BUSREADY is low", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.busready_1_low = {30};
    bench.run();
    bench.violations.check_only("bus/busready", "BUSREADY_1_1", 31, 0);
}

TEST_CASE("bus monitor: BUSREADY counts at the clock of the grant, before the page is opened", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.busready_1_low = {11, 13, 14, 15};
    bench.run();
    bench.violations.check_none();
}

/// An arbiter that answers two clocks after the one in which it samples BUSREADY; the first is clock 12.
struct SlowArbiterBus : BusBench {
    SlowArbiterBus() : BusBench(slow_arbiter()) { put_table(); }

    static Scenario slow_arbiter() {
        Scenario scenario = bus_scenario();
        scenario.bus.grant_cycles = 2;
        return scenario;
    }
    void put_burst(int clock) {
        put(clock, 1, 0, 4);
        put(clock + 1, 1, 2, 2);
        put(clock + 5, 1, 4, 0);
        run();
    }
};

TEST_CASE("bus monitor: BUSREADY counts at the clock at which a slow arbiter decides", "[monitors]") {
    SlowArbiterBus bench;
    bench.busready_1_low = {11, 13, 14, 15, 16, 17};
    bench.put_burst(18);
    bench.violations.check_none();
}

TEST_CASE("bus monitor: a slot for a composer whose BUSREADY was low when a slow arbiter decided",
          "[monitors]") {
    SlowArbiterBus bench;
    bench.busready_1_low = {12};
    bench.put_burst(18);
    bench.violations.check_only("bus/busready", "BUSREADY_1_1", 18, 0);
}

TEST_CASE("bus monitor: a burst that begins before a slow arbiter can have answered", "[monitors]") {
    SlowArbiterBus bench;
    bench.put_burst(17);
    bench.violations.check_only("bus/pace", "BUS_1", 17, 0);
}

/// A memory that is refreshed from clocks 20 and 40 on, for four clocks.
struct RefreshedBus : BusBench {
    RefreshedBus() : BusBench(refreshed()) { put_table(); }

    static Scenario refreshed() {
        Scenario scenario = bus_scenario();
        scenario.memory.refresh_interval_cycles = 20;
        scenario.memory.refresh_cycles = 4;
        return scenario;
    }
    /// The last beat's page would be open at clock 20.
    void put_burst(int last_beat_clock) {
        put(16, 1, 0, 4);
        put(17, 1, 2, 2);
        put(last_beat_clock, 1, 4, 0);
    }
};

TEST_CASE("bus monitor: a page whose opening a refresh breaks off is opened after the refresh",
          "[monitors]") {
    RefreshedBus bench;
    bench.put_burst(20 + 4 + 3 + 1);
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: a beat that was read during a refresh", "[monitors]") {
    RefreshedBus bench;
    bench.put_burst(21);
    bench.run();
    bench.violations.check_first("bus/pace", "BUS_1", 21, 0);
}

TEST_CASE("bus monitor: a burst may have been granted in any clock of the refresh that it waited for",
          "[monitors]") {
    RefreshedBus bench;
    bench.put_burst(28);
    bench.put(48, 1, 6, 0);
    // An opening that begins three clocks before the refresh is broken off by it.
    bench.busready_1_low = {37, 38, 39, 40, 42, 43, 44};
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: a burst after a refresh that was granted in no clock with BUSREADY high",
          "[monitors]") {
    RefreshedBus bench;
    bench.put_burst(28);
    bench.put(48, 1, 6, 0);
    bench.busready_1_low = {37, 38, 39, 40, 41, 42, 43, 44};
    bench.run();
    bench.violations.check_only("bus/busready", "BUSREADY_1_1", 48, 0);
}

TEST_CASE("bus monitor: a burst whose first word was read during a refresh", "[monitors]") {
    RefreshedBus bench;
    bench.put(24, 1, 0, 4);
    bench.run();
    bench.violations.check_first("bus/pace", "BUS_1", 24, 0);
}

TEST_CASE("bus monitor: a burst that goes on after a low BUSREADY", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.busready_1_low = {17};
    bench.run();
    bench.violations.check_first("bus/busready", "BUSREADY_1_1", 21, 0);
}

TEST_CASE("bus monitor: a low BUSREADY in a burst passes the slot on in the same clock", "[monitors]") {
    BusBench bench;
    bench.put_table();
    bench.put(16, 1, 0, 4);
    bench.put(17, 1, 2, 2);  // driven at the edge before the one that reads BUSREADY
    bench.put(18, 2, 0, 4);
    bench.put(19, 2, 2, 2);
    bench.put(23, 2, 4, 0);
    bench.put(24, 1, 4, 2);
    bench.put(25, 1, 6, 0);
    bench.put(26, 2, 6, 0);
    bench.beats[40] = BusBeat::frame_start(1, true);
    bench.busready_1_low = {17};
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: BUSREADY is about the next slot while the rest of a burst fits one beat",
          "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.busready_1_low = {16, 18, 19, 20, 21};  // at 16 nothing is announced that it could answer
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: a composer is passed over after a burst of one beat", "[monitors]") {
    BusBench bench(bus_scenario(2));
    bench.put_table();
    bench.put(16, 1, 0, 0);
    bench.put(17, 1, 2, 0);
    bench.run();
    bench.violations.check_only("bus/passed-over", "BUSREADY_1_1", 17, 0);
}

TEST_CASE("bus monitor: a composer is passed over for one clock only and others are not", "[monitors]") {
    BusBench bench(bus_scenario(2));
    bench.put_table();
    bench.put(16, 1, 0, 0);
    bench.put(17, 2, 0, 0);
    bench.put(18, 1, 2, 0);
    bench.put(20, 1, 4, 0);
    bench.beats.erase(20);
    bench.put(23, 1, 4, 0);
    bench.run();
    bench.violations.check_none();
}

namespace {

/// A bus of 16 bits: a beat of a pixel takes four clocks, a table row eight.
struct NarrowBus : BusBench {
    NarrowBus() : BusBench(bus_scenario(6, 16)) {
        beats[10] = BusBeat::frame_start(0, false);
        beats[18] = BusBeat::table_row(0, 0, row(1), true);
        put(25, 1, 0, 5, 1);
        put(29, 1, 1, 4, 1);
        // BUSREADY low at 31 stops the burst while the next pixel moves, and that pixel becomes its last.
        busready_1_low = {31};
        put(33, 1, 2, 0, 1);
    }
};

}  // namespace

// ---- read latency and registers on the bus ----

namespace {

/// Bursts of one composer, by the timing table. The words of a beat were read `latency` clocks before the clock that
/// put them on the bus. The composer is passed over until its BUSREADY counts a burst's last beat.
struct DelayedBusBench : BusBench {
    static constexpr int kLatency = 2;
    static constexpr int kStages = 1;
    static constexpr int kLoop = kLatency + 2 * kStages;
    static constexpr int kFirst = 16 + kLatency;                       ///< edge that samples the first beat
    static constexpr int kSecond = 17 + kLatency + 1 + kLoop + 3 + 1;  ///< and that of the next burst

    DelayedBusBench() : BusBench(with_delays()) {
        beats[10 + kLatency] = BusBeat::frame_start(0, false);
        beats[11 + kLatency] = BusBeat::table_row(0, 0, row(1), true);
        put(kFirst, 1, 0, 2);
        put(kFirst + 1, 1, 2, 0);
    }
    static Scenario with_delays() {
        Scenario scenario = bus_scenario(4);
        scenario.memory.read_latency_cycles = kLatency;
        scenario.bus.register_stages = kStages;
        scenario.composer.ready_space_pixels = 12;
        return scenario;
    }
    /// The second burst, which opens a page, so many clocks earlier than it may begin.
    void put_second(int earlier = 0) {
        put(kSecond - earlier, 1, 4, 2);
        put(kSecond + 1 - earlier, 1, 6, 0);
    }
};

}  // namespace

TEST_CASE("bus monitor: a stream by the rules of a bus with read latency and registers breaks none",
          "[monitors]") {
    DelayedBusBench bench;
    bench.put_second();
    bench.beats[50] = BusBeat::frame_start(1, true);
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.bursts() == 2);
}

TEST_CASE("bus monitor: a composer whose BUSREADY has not come back all the way is passed over",
          "[monitors]") {
    DelayedBusBench bench;
    bench.put_second(1);
    bench.run();
    bench.violations.check_only("bus/passed-over", "BUSREADY_1_1", DelayedBusBench::kSecond - 1, 0);
}

/// The grant of the second burst. Its page is opened for three clocks. A word is on the bus a clock and the latency
/// after its read.
constexpr int kDelayedGrant = DelayedBusBench::kSecond - 1 - DelayedBusBench::kLatency - 3;

TEST_CASE("bus monitor: BUSREADY counts at the clock of the grant, not while the words come", "[monitors]") {
    DelayedBusBench bench;
    bench.put_second();
    bench.busready_1_low = {kDelayedGrant - 1, kDelayedGrant + 1, kDelayedGrant + 2, kDelayedGrant + 3};
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: a slot with BUSREADY low at the clock of the grant, before the words come",
          "[monitors]") {
    DelayedBusBench bench;
    bench.put_second();
    bench.busready_1_low = {kDelayedGrant};
    bench.run();
    bench.violations.check_only("bus/busready", "BUSREADY_1_1", DelayedBusBench::kSecond, 0);
}

TEST_CASE("bus monitor: TABLEREADY counts at the clock that decided on a frame's start", "[monitors]") {
    constexpr int kStart = 50;
    constexpr int kDecision = kStart - 1 - DelayedBusBench::kLatency;
    DelayedBusBench bench;
    bench.put_second();
    bench.beats[kStart] = BusBeat::frame_start(1, true);
    bench.tableready_2_low = {kDecision};
    bench.run();
    bench.violations.check_only("bus/tableready", "BUS_1", kStart, 1);
}

TEST_CASE("bus monitor: a frame that starts before TABLEREADY has come back all the way", "[monitors]") {
    DelayedBusBench bench;
    bench.beats.clear();
    bench.beats[20] = BusBeat::frame_start(0, true);
    bench.beats[21 + DelayedBusBench::kLoop] = BusBeat::frame_start(1, true);
    bench.run();
    bench.violations.check_only("bus/tableready", "BUS_1", 21 + DelayedBusBench::kLoop, 1);
}

TEST_CASE("bus monitor: a frame that starts as soon as TABLEREADY has come back is in time", "[monitors]") {
    DelayedBusBench bench;
    bench.beats.clear();
    bench.beats[20] = BusBeat::frame_start(0, true);
    bench.beats[22 + DelayedBusBench::kLoop] = BusBeat::frame_start(1, true);
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: a burst stopped while a beat of a narrow bus moves", "[monitors]") {
    NarrowBus bench;
    bench.put(38, 1, 3, 4, 1);  // granted at 34, one clock after it could have been
    bench.put(45, 1, 4, 3, 1);
    bench.put(49, 1, 5, 2, 1);
    bench.put(53, 1, 6, 1, 1);
    bench.put(57, 1, 7, 0, 1);
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: the last beat of a stopped burst says so", "[monitors]") {
    NarrowBus bench;
    bench.put(33, 1, 2, 3, 1);
    bench.run();
    bench.violations.check_only("bus/remaining", "BUS_1", 33, 0);
}

TEST_CASE("bus monitor: a composer is passed over after a stopped beat", "[monitors]") {
    NarrowBus bench;
    bench.put(37, 1, 3, 4, 1);
    bench.run();
    bench.violations.check_first("bus/passed-over", "BUSREADY_1_1", 37, 0);
}

TEST_CASE("bus monitor: a beat of a narrow bus that comes too soon", "[monitors]") {
    NarrowBus bench;
    bench.beats.erase(29);
    bench.put(28, 1, 1, 4, 1);
    bench.run();
    bench.violations.check_first("bus/pace", "BUS_1", 28, 0);
}

TEST_CASE("bus monitor: one report of a rule for a frame", "[monitors]") {
    BusBench bench;
    bench.put_frame();
    bench.put(17, 1, 2, 3);
    bench.put(26, 2, 2, 3);
    bench.run();
    bench.violations.check_only("bus/remaining", "BUS_1", 17, 0);
    CHECK(bench.monitor.unreported() == 1);
}

// ---- shared ports ----

/// What a beat waits for does not show on the bus; the longest wait is 3 + 3 * (3 + 2 + 3) clocks.
struct SharedPortsBus : BusBench {
    SharedPortsBus() : BusBench(shared()) { put_table(); }

    static Scenario shared() {
        Scenario scenario = bus_scenario();
        scenario.memory.ports = MemoryPorts::kShared;
        scenario.memory.write_block_words = 4;
        return scenario;
    }
};

TEST_CASE("bus monitor: with shared ports a beat may come later, for the link's words were written",
          "[monitors]") {
    SharedPortsBus bench;
    bench.put(16, 1, 0, 4);
    bench.put(23, 1, 2, 2);
    bench.put(23 + 27 + 1, 1, 4, 0);
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("bus monitor: with shared ports too a beat comes within the longest wait", "[monitors]") {
    SharedPortsBus bench;
    bench.put(16, 1, 0, 4);
    bench.run();
    bench.violations.check_only("bus/pace", "BUS_1", 16 + 27 + 1, 0);
}

}  // namespace metabuffer::test::bus_monitor_test
