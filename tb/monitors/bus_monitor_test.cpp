#include "monitors/bus_monitor.h"

#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "pixel_beat.h"
#include "rule_table.h"
#include "support/scenarios.h"

namespace metabuffer::test::bus_monitor_test {

// A stream breaks each rule of docs/monitors.md once, and no other rule before it.
namespace {

using rtl::BusBeat;

constexpr int kImageWidth = 8;  // a page of the memory is a scanline
constexpr int kFrames = 300;    // of the row with the most clocks
constexpr int kEnd = 2 * kFrames + 5;

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
Scenario altered(const std::function<void(Scenario&)>& change, int burst_pixels = 6) {
    Scenario scenario = bus_scenario(burst_pixels);
    change(scenario);
    return scenario;
}

/// The input framebuffer and the composers' wires, played by the test.
struct BusBench : ClockedRuleBench {
    Scenario scenario;
    sc_core::sc_signal<BusBeat> bus{"BUS_1"};
    sc_core::sc_signal<bool> busready_1{"BUSREADY_1_1"};
    sc_core::sc_signal<bool> busready_2{"BUSREADY_1_2"};
    sc_core::sc_signal<bool> tableready_1{"TABLEREADY_1_1"};
    sc_core::sc_signal<bool> tableready_2{"TABLEREADY_1_2"};
    monitors::BusMonitor monitor;
    std::map<int, BusBeat> beats;  ///< by the clock that samples them
    std::set<int> busready_1_low;
    std::set<int> tableready_2_low;

    /// stream: puts what the rows of the table change.
    BusBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench, Scenario with = bus_scenario(),
             const std::function<void(BusBench&)>& stream = &BusBench::put_table)
        : ClockedRuleBench(name, testbench), scenario(std::move(with)), monitor("monitor", scenario, 0, log) {
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
        stream(*this);
    }

    BusBench& put(int clock, const BusBeat& beat) {
        beats[clock] = beat;
        return *this;
    }
    BusBench& put(int clock, int destination, int first, int remaining, int count = 2) {
        return put(clock, pixel_beat(0, destination, first, count, remaining,
                                     [](std::int64_t) { return std::uint64_t{0}; }));
    }
    /// A row of 4 x 2 pixels.
    BusBench& put_row(int clock, int index, int display, bool last) {
        return put_row(clock, index, table_row(display, {display == 1 ? 0 : 4, 0}, {4, 2}, {1, 1}), last);
    }
    BusBench& put_row(int clock, int index, const ViewportRow& row, bool last) {
        return put(clock, BusBeat::table_row(0, static_cast<std::uint32_t>(index), row, last));
    }
    BusBench& take(int clock) {
        beats.erase(clock);
        return *this;
    }
    BusBench& misname(int clock, std::uint32_t frame) {
        beats.at(clock).frame = frame;
        return *this;
    }
    /// A frame's start at clock 10, and two rows after it.
    BusBench& put_table() {
        return put(10, BusBeat::frame_start(0, false)).put_row(11, 0, 1, false).put_row(12, 1, 2, true);
    }
    /// A frame and the start of the next, by the timing table. Granted at 12, the page open three clocks later; two
    /// beats, another page, one beat. What is left of both segments at 31 lies in the open page.
    void put_frame() {
        put_table().put(16, 1, 0, 4).put(17, 1, 2, 2).put(21, 1, 4, 0);
        put(25, 2, 0, 4).put(26, 2, 2, 2).put(30, 2, 4, 0).put(31, 1, 6, 0).put(32, 2, 6, 0);
        put(40, BusBeat::frame_start(1, true));
    }
};

// ---- read latency and registers on the bus ----

constexpr int kLatency = 2;
constexpr int kStages = 1;
constexpr int kLoop = kLatency + 2 * kStages;
constexpr int kFirst = 16 + kLatency;                       ///< edge that samples the first beat
constexpr int kSecond = 17 + kLatency + 1 + kLoop + 3 + 1;  ///< and that of the next burst
/// The grant of the second burst. Its page is opened for three clocks. A word is on the bus a clock and the latency
/// after its read.
constexpr int kSecondGrant = kSecond - 1 - kLatency - 3;

void delay(Scenario& scenario) {
    scenario.memory.read_latency_cycles = kLatency;
    scenario.bus.register_stages = kStages;
    scenario.composer.ready_space_pixels = 12;
}
/// Bursts of one composer, by the timing table. The words of a beat were read `latency` clocks before the clock that
/// put them on the bus. The composer is passed over until its BUSREADY counts a burst's last beat.
void put_delayed(BusBench& bench) {
    bench.put(10 + kLatency, BusBeat::frame_start(0, false)).put_row(11 + kLatency, 0, 1, true);
    bench.put(kFirst, 1, 0, 2).put(kFirst + 1, 1, 2, 0).put(kSecond, 1, 4, 2).put(kSecond + 1, 1, 6, 0);
    bench.put(50, BusBeat::frame_start(1, true));
}
void no_stream(BusBench& /*bench*/) {}

/// Two frames without pixels.
std::function<void(BusBench&)> empty_frames(int second) {
    return [second](BusBench& bench) {
        bench.put(20, BusBeat::frame_start(0, true)).put(second, BusBeat::frame_start(1, true));
    };
}

/// On a bus of 16 bits a beat of a pixel takes four clocks, a table row eight. BUSREADY low at 31 stops the burst while
/// the next pixel moves, and that pixel becomes its last.
void put_narrow(BusBench& bench) {
    bench.put(10, BusBeat::frame_start(0, false)).put_row(18, 0, 1, true);
    bench.put(25, 1, 0, 5, 1).put(29, 1, 1, 4, 1).put(33, 1, 2, 0, 1);
    bench.busready_1_low = {31};
}

}  // namespace

TEST_CASE("bus monitor: its rules in a table", "[monitors]") {
    ClockedRuleTable<BusBench> rules;
    rules.of(bus_scenario(), &BusBench::put_frame);
    rules.row("a stream by the rules", {}, {}, [](const auto& bench) {
        CHECK(bench.monitor.bursts() == 4);
        CHECK(bench.monitor.pixels_sent() == 16);
        CHECK(bench.monitor.frames_started() == 2);
    });
    rules.row("TABLEREADY low at the edge that drives a frame's start", {{"bus/tableready", "BUS_1", 40, 1}},
              [](auto& bench) { bench.tableready_2_low = {39}; });
    rules.row("TABLEREADY low at the edges beside that", {}, [](auto& bench) {
        bench.tableready_2_low = {38, 40};
    });
    rules.row("a frame starts before the last is sent to its end", {{"bus/incomplete", "BUS_1", 40, 0}},
              [](auto& bench) { bench.take(32); });
    rules.row("more frames than the run has", {{"bus/frames", "BUS_1", 45, 2}},
              [](auto& bench) { bench.put(45, BusBeat::frame_start(2, true)); });
    rules.row("a frame's start names another frame than the next", {{"bus/frame-number", "BUS_1", 40, 0}},
              [](auto& bench) { bench.misname(40, 2); });
    rules.row("a row names another frame", {{"bus/frame-number", "BUS_1", 12, 0}},
              [](auto& bench) { bench.misname(12, 1); });
    rules.row("pixels name another frame", {{"bus/frame-number", "BUS_1", 26, 0}},
              [](auto& bench) { bench.misname(26, 255); });
    rules.row("a row names another index", {{"bus/row-number", "BUS_1", 12, 0}},
              [](auto& bench) { bench.put_row(12, 2, 2, true); });
    rules.row("pixels before their table is complete", {{"bus/table", "BUS_1", 13, 0}},
              [](auto& bench) { bench.put_row(12, 1, 2, false); });
    rules.row("a beat carries less than width and page allow", {{"bus/count", "BUS_1", 26, 0}, kOthers},
              [](auto& bench) { bench.put(26, 2, 2, 3, 1); });
    rules.row("a beat announces more than comes", {{"bus/remaining", "BUS_1", 17, 0}},
              [](auto& bench) { bench.put(17, 1, 2, 3); });
    rules.row("a burst longer than it may be", {{"bus/remaining", "BUS_1", 16, 0}},
              [](auto& bench) { bench.put(16, 1, 0, 6); });
    rules.row(
        "one report of a rule for a frame", {{"bus/remaining", "BUS_1", 17, 0}},
        [](auto& bench) { bench.put(17, 1, 2, 3).put(26, 2, 2, 3); },
        [](const auto& bench) { CHECK(bench.monitor.unreported() == 1); });
    rules.row("a pixel is lost", {{"bus/order", "BUS_1", 17, 0}},
              [](auto& bench) { bench.put(17, 1, 3, 2); });
    rules.row("a pixel comes twice", {{"bus/order", "BUS_1", 31, 0}},
              [](auto& bench) { bench.put(31, 1, 4, 0); });
    rules.row("a pixel after its segment's last", {{"bus/beyond", "BUS_1", 34, 0}},
              [](auto& bench) { bench.put(34, 1, 8, 0); });
    rules.row("a beat of a burst is late", {{"bus/pace", "BUS_1", 17, 0}, kOthers},
              [](auto& bench) { bench.take(17); });
    rules.row("a beat of a burst before its page is open", {{"bus/pace", "BUS_1", 20, 0}},
              [](auto& bench) { bench.take(21).put(20, 1, 4, 0); });
    rules.row("a slot for a composer whose BUSREADY is low", {{"bus/busready", "BUSREADY_1_1", 31, 0}},
              [](auto& bench) { bench.busready_1_low = {30}; });
    rules.row("BUSREADY low beside the clock of the grant, before the page is opened", {}, [](auto& bench) {
        bench.busready_1_low = {11, 13, 14, 15};
    });
    rules.row("a burst goes on after a low BUSREADY", {{"bus/busready", "BUSREADY_1_1", 21, 0}, kOthers},
              [](auto& bench) { bench.busready_1_low = {17}; });
    rules.row(
        "BUSREADY is about the next slot while the rest of a burst fits one beat, or nothing is announced",
        {}, [](auto& bench) {
            bench.busready_1_low = {16, 18, 19, 20, 21};
        });

    rules.of(bus_scenario());
    rules.row("a row is late", {{"bus/table", "BUS_1", 12, 0}},
              [](auto& bench) { bench.take(12).put_row(13, 1, 2, true); });
    rules.row("a row after the last of its table", {{"bus/table", "BUS_1", 12, 0}},
              [](auto& bench) { bench.put_row(11, 0, 1, true); });
    rules.row("a second row for a display", {{"bus/row", "BUS_1", 12, 0}},
              [](auto& bench) { bench.put_row(12, 1, 1, true); });
    rules.row("a row for a display that is not there", {{"bus/row", "BUS_1", 12, 0}},
              [](auto& bench) { bench.put_row(12, 1, 3, true); });
    rules.row("a row whose last pixel lies off the raster", {{"bus/row", "BUS_1", 12, 0}}, [](auto& bench) {
        bench.put_row(12, 1, table_row(2, {0, 0}, {4, 2}, {5, 1}), true);
    });
    rules.row("pixels for a display without a row", {{"bus/destination", "BUS_1", 15, 0}},
              [](auto& bench) { bench.take(12).put_row(11, 0, 1, true).put(15, 2, 0, 4); });
    rules.row("a burst within another", {{"bus/one-burst", "BUS_1", 17, 0}},
              [](auto& bench) { bench.put(16, 1, 0, 4).put(17, 2, 0, 4).put(18, 2, 2, 2).put(22, 2, 4, 0); });
    rules.row("a burst begins before its page is open", {{"bus/pace", "BUS_1", 15, 0}},
              [](auto& bench) { bench.put(15, 1, 0, 4).put(16, 1, 2, 2).put(20, 1, 4, 0); });
    rules.row("a low BUSREADY in a burst passes the slot on in the same clock", {}, [](auto& bench) {
        bench.busready_1_low = {17};
        bench.put(16, 1, 0, 4).put(17, 1, 2, 2);  // driven at the edge before the one that reads BUSREADY
        bench.put(18, 2, 0, 4).put(19, 2, 2, 2).put(23, 2, 4, 0);
        bench.put(24, 1, 4, 2).put(25, 1, 6, 0).put(26, 2, 6, 0).put(40, BusBeat::frame_start(1, true));
    });

    rules.of(altered([](Scenario& scenario) { scenario.composer.buffer_pixels = 6; }));
    rules.row("a row that the buffer can never serve", {{"bus/row", "BUS_1", 12, 0}}, [](auto& bench) {
        bench.put_row(12, 1, table_row(2, {0, 0}, {4, 1}, {0, 0}, 2), true);
    });

    rules.of(altered([](Scenario& scenario) { scenario.frames = kFrames; }), no_stream);
    rules.row(
        "the frames' numbers go on", {},
        [](auto& bench) {
            for (int i = 0; i < kFrames; ++i)
                bench.put(2 + 2 * i, BusBeat::frame_start(static_cast<std::uint32_t>(i), true));
        },
        [](const auto& bench) { CHECK(bench.monitor.frames_started() == kFrames); });

    rules.of(bus_scenario(2));
    rules.row("a composer is not passed over after a burst of one beat",
              {{"bus/passed-over", "BUSREADY_1_1", 17, 0}},
              [](auto& bench) { bench.put(16, 1, 0, 0).put(17, 1, 2, 0); });
    rules.row("a composer is passed over for one clock and others are not", {},
              [](auto& bench) { bench.put(16, 1, 0, 0).put(17, 2, 0, 0).put(18, 1, 2, 0).put(23, 1, 4, 0); });

    // An arbiter that answers two clocks after the one in which it samples BUSREADY; the first is clock 12.
    rules.of(altered([](Scenario& scenario) { scenario.bus.grant_cycles = 2; }));
    rules.row("BUSREADY counts at the clock at which a slow arbiter decides", {}, [](auto& bench) {
        bench.busready_1_low = {11, 13, 14, 15, 16, 17};
        bench.put(18, 1, 0, 4).put(19, 1, 2, 2).put(23, 1, 4, 0);
    });
    rules.row("BUSREADY low when a slow arbiter decides", {{"bus/busready", "BUSREADY_1_1", 18, 0}},
              [](auto& bench) {
                  bench.busready_1_low = {12};
                  bench.put(18, 1, 0, 4).put(19, 1, 2, 2).put(23, 1, 4, 0);
              });
    rules.row("a burst begins before a slow arbiter can have answered", {{"bus/pace", "BUS_1", 17, 0}},
              [](auto& bench) { bench.put(17, 1, 0, 4).put(18, 1, 2, 2).put(22, 1, 4, 0); });

    // A memory that is refreshed from clocks 20 and 40 on, for four clocks. The third beat's page would be open at 20.
    const Scenario refreshed = altered([](Scenario& scenario) {
        scenario.memory.refresh_interval_cycles = 20;
        scenario.memory.refresh_cycles = 4;
    });
    rules.of(refreshed, [](BusBench& bench) { bench.put_table().put(16, 1, 0, 4).put(17, 1, 2, 2); });
    rules.row("a page whose opening a refresh breaks off is opened after the refresh", {},
              [](auto& bench) { bench.put(20 + 4 + 3 + 1, 1, 4, 0); });
    rules.row("a beat was read during a refresh", {{"bus/pace", "BUS_1", 21, 0}},
              [](auto& bench) { bench.put(21, 1, 4, 0); });
    // An opening that begins three clocks before the refresh is broken off by it.
    rules.row("a burst may have been granted in any clock of the refresh that it waited for", {},
              [](auto& bench) {
                  bench.busready_1_low = {37, 38, 39, 40, 42, 43, 44};
                  bench.put(28, 1, 4, 0).put(48, 1, 6, 0);
              });
    rules.row("a burst after a refresh can have been granted in no clock with BUSREADY high",
              {{"bus/busready", "BUSREADY_1_1", 48, 0}}, [](auto& bench) {
                  bench.busready_1_low = {37, 38, 39, 40, 41, 42, 43, 44};
                  bench.put(28, 1, 4, 0).put(48, 1, 6, 0);
              });
    rules.row("a burst's first word was read during a refresh", {{"bus/pace", "BUS_1", 24, 0}},
              [](auto& bench) { bench.take(16).take(17).put(24, 1, 0, 4); });

    rules.of(altered(delay, 4), put_delayed);
    rules.row("a stream by the rules of a bus with read latency and registers", {}, {},
              [](const auto& bench) { CHECK(bench.monitor.bursts() == 2); });
    rules.row("a composer is not passed over until its BUSREADY has come back all the way",
              {{"bus/passed-over", "BUSREADY_1_1", kSecond - 1, 0}},
              [](auto& bench) { bench.take(kSecond + 1).put(kSecond - 1, 1, 4, 2).put(kSecond, 1, 6, 0); });
    rules.row("BUSREADY low beside the clock of the grant, and while the words come", {}, [](auto& bench) {
        bench.busready_1_low = {kSecondGrant - 1, kSecondGrant + 1, kSecondGrant + 2, kSecondGrant + 3};
    });
    rules.row("BUSREADY low at the clock of the grant, before the words come",
              {{"bus/busready", "BUSREADY_1_1", kSecond, 0}},
              [](auto& bench) { bench.busready_1_low = {kSecondGrant}; });
    rules.row("TABLEREADY low at the clock that decided on a frame's start",
              {{"bus/tableready", "BUS_1", 50, 1}},
              [](auto& bench) { bench.tableready_2_low = {50 - 1 - kLatency}; });

    rules.of(altered(delay, 4), no_stream);
    rules.row("a frame starts before TABLEREADY has come back all the way",
              {{"bus/tableready", "BUS_1", 21 + kLoop, 1}}, empty_frames(21 + kLoop));
    rules.row("a frame starts as soon as TABLEREADY has come back", {}, empty_frames(22 + kLoop));

    rules.of(bus_scenario(6, 16), put_narrow);
    rules.row("a burst stopped while a beat of a narrow bus moves", {}, [](auto& bench) {
        // Granted at 34, one clock after it could have been.
        bench.put(38, 1, 3, 4, 1)
            .put(45, 1, 4, 3, 1)
            .put(49, 1, 5, 2, 1)
            .put(53, 1, 6, 1, 1)
            .put(57, 1, 7, 0, 1);
    });
    rules.row("the last beat of a stopped burst does not say so", {{"bus/remaining", "BUS_1", 33, 0}},
              [](auto& bench) { bench.put(33, 1, 2, 3, 1); });
    rules.row("a composer is not passed over after a stopped beat",
              {{"bus/passed-over", "BUSREADY_1_1", 37, 0}, kOthers},
              [](auto& bench) { bench.put(37, 1, 3, 4, 1); });
    rules.row("a beat of a narrow bus comes too soon", {{"bus/pace", "BUS_1", 28, 0}, kOthers},
              [](auto& bench) { bench.take(29).put(28, 1, 1, 4, 1); });

    // With shared ports a beat may wait for the link's words, at most 3 + 3 * (3 + 2 + 3) clocks, which the bus does not
    // show.
    rules.of(altered([](Scenario& scenario) {
        scenario.memory.ports = MemoryPorts::kShared;
        scenario.memory.write_block_words = 4;
    }));
    rules.row("with shared ports a beat comes later", {},
              [](auto& bench) { bench.put(16, 1, 0, 4).put(23, 1, 2, 2).put(23 + 27 + 1, 1, 4, 0); });
    rules.row("with shared ports a beat does not come within the longest wait",
              {{"bus/pace", "BUS_1", 16 + 27 + 1, 0}}, [](auto& bench) { bench.put(16, 1, 0, 4); });
    rules.run_and_check(kEnd);
}

}  // namespace metabuffer::test::bus_monitor_test
