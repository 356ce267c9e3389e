#include "monitors/composer_monitor.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "composer_bench.h"
#include "pixel_beat.h"
#include "rule_table.h"

namespace metabuffer::test::composer_monitor_test {

// A composer that keeps its rules. The test falsifies a wire to its monitor for one clock.
namespace {

constexpr int kWidth = 8;
constexpr int kRaster = kWidth * 4;
constexpr int kStart = 14;  ///< STARTFRAME is sampled
constexpr int kEnd = kStart + kRaster + 12;
/// The edge that samples raster pixel i as it leaves the composer.
constexpr int leaving(int i) { return kStart + 2 + i; }

/// A signal that a monitor watches: what the composer drives, except for some clocks.
template <typename Value>
class Tap {
  public:
    sc_core::sc_signal<Value> wire;
    std::map<int, Value> instead;  ///< by the edge that samples it

    Tap(const char* name, ClockDomain& core, const sc_core::sc_signal<Value>& source) : wire(name) {
        core.each_clock([this, &source](int clock) {
            const auto entry = instead.find(clock);
            wire.write(entry == instead.end() ? source.read() : entry->second);
        });
    }
};

struct MonitorBench : ClockedRuleBench {
    ComposerBench dut;
    Tap<bool> busready;
    Tap<bool> tableready;
    Tap<bool> startframe;
    Tap<rtl::PipePixel> pipe;
    Tap<bool> pipeready;
    Tap<bool> stall;
    monitors::ComposerMonitor monitor;

    /// stream: what bus and pipeline bring.
    MonitorBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench, Scenario scenario,
                 const std::function<void(MonitorBench&)>& stream, Strap strap = Strap::kRelay,
                 StallWire stall_wire = StallWire::kOwn)
        : ClockedRuleBench(name, testbench),
          dut(bench, "composer", std::move(scenario), strap, stall_wire),
          busready("BUSREADY", bench.core, dut.busready),
          tableready("TABLEREADY", bench.core, dut.tableready),
          startframe("STARTFRAME", bench.core, dut.startframe_out),
          pipe("PIPE", bench.core, dut.pipe_out),
          pipeready("PIPEREADY", bench.core, dut.pipeready_out),
          stall("STALL", bench.core, dut.stall),
          monitor("monitor", dut.scenario, 1, 0, log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.pipemaster_i(dut.pipemaster);
        monitor.bus_i(dut.bus);
        monitor.busready_o(busready.wire);
        monitor.tableready_o(tableready.wire);
        monitor.startframe_i(dut.startframe_in);
        monitor.startframe_o(startframe.wire);
        monitor.pipe_i(dut.pipe_in);
        monitor.pipe_o(pipe.wire);
        monitor.pipeready_i(dut.pipeready_in);
        monitor.pipeready_o(pipeready.wire);
        monitor.column_stall_i(stall_wire == StallWire::kOwn ? stall.wire : dut.column_stall);
        monitor.stall_o(stall.wire);
        stream(*this);
    }

    void put_table() { dut.put_table(2, {table_row(1, {0, 0}, {3, 2}, {1, 1})}); }
    /// A segment of 3 x 2 pixels, its table at clocks 2 and 3, its pixels in one burst from 4 to 9.
    void put_frame() {
        put_table();
        for (int i = 0; i < 6; ++i) dut.put_pixels(4 + i, i, 1, 5 - i);
    }
    /// PIPEREADY from below from clock `ready` on to STARTFRAME, and the raster.
    void composite(int ready = 5) {
        bench.core.drive(dut.pipeready_in, ready, true);
        bench.core.drive(dut.pipeready_in, kStart + 2, false);
        dut.start_frame(kStart);
    }
    void put_picture() {
        put_frame();
        composite();
    }
};

Scenario composer_scenario(int buffer_pixels = 16, int ready_space_pixels = 2) {
    Scenario scenario = small_scenario(kWidth, kRaster / kWidth);
    scenario.composer.buffer_pixels = buffer_pixels;
    scenario.composer.ready_space_pixels = ready_space_pixels;
    return scenario;
}
/// A fault that holds BUSREADY low.
Scenario busready_low(std::optional<std::int64_t> cycles) {
    Scenario scenario = composer_scenario();
    if (cycles) scenario.memory.page_miss_cycles = 0;
    Fault fault;
    fault.kind = FaultKind::kBusreadyLow;
    fault.renderer = 1;
    fault.display = 1;
    fault.cycles = cycles;
    scenario.faults.push_back(fault);
    return scenario;
}
/// A fault that may raise STALL of the composer's row.
Scenario stalls_of(int renderer, StarvationMode mode, std::int64_t cycles) {
    Scenario scenario = composer_scenario();
    scenario.composer.on_starvation = mode;
    scenario.faults.push_back(random_stalls(renderer, 1, 0, cycles));
    return scenario;
}

/// The run of a PIPEMASTER whose PIPEREADY is high after edge 9: it answers at 10, for edge 11 to read.
void put_master(MonitorBench& bench) {
    bench.put_frame();
    bench.bench.core.drive(bench.dut.pipeready_in, 5, true);
    bench.bench.core.drive(bench.dut.pipeready_in, 12, false);
}

/// Pixel 4 is needed at raster position 18, composited at the edge kNeeded, and comes four clocks late.
constexpr int kNeeded = kStart + 19;
constexpr int kLate = 4;
Scenario stalling() {
    Scenario scenario = composer_scenario(16, 13);  // no further slot with four of the six
    scenario.composer.on_starvation = StarvationMode::kStall;
    return scenario;
}
void put_late(MonitorBench& bench) {
    bench.put_table();
    bench.dut.put_single_pixels(4, 0, 4);
    bench.dut.put_single_pixels(kNeeded + kLate - 1, 4, 2);
    bench.composite();
    bench.bench.core.drive(bench.dut.column_stall, kNeeded, true);
    bench.bench.core.drive(bench.dut.column_stall, kNeeded + kLate, false);
}

void no_stream(MonitorBench& /*bench*/) {}

/// What the composer passes on where its segment does not lie, at raster position i.
rtl::PipePixel passed(int i, bool lost = false) { return {ComposerBench::upstream(i), true, lost}; }

/// The monitor's wire carries a value at one clock.
template <typename Value>
std::function<void(MonitorBench&)> shows(Tap<Value> MonitorBench::*tap, int clock, const Value& value) {
    return [=](MonitorBench& bench) { (bench.*tap).instead[clock] = value; };
}

/// Pixels for display 1.
rtl::BusBeat pixels_beat(int first, const std::vector<std::uint64_t>& words) {
    return pixel_beat(0, 1, first, static_cast<int>(words.size()), 0,
                      [first, &words](std::int64_t k) { return words[static_cast<std::size_t>(k - first)]; });
}

}  // namespace

TEST_CASE("composer monitor: its rules in a table", "[monitors]") {
    using B = MonitorBench;
    ClockedRuleTable<MonitorBench> rules;
    rules.of(composer_scenario(), &B::put_picture);
    rules.row("a composer by the rules", {}, {}, [](const auto& bench) {
        CHECK(bench.monitor.counters().buffer_high_water == 6);
        REQUIRE(bench.monitor.observer().frame_spans().size() == 1);
        const auto& span = bench.monitor.observer().frame_spans()[0];
        CHECK(span.startframe_cycle - bench.clock_zero() == kStart);
        CHECK(span.start_cycle == span.startframe_cycle + 1);
        CHECK(span.end_cycle == span.startframe_cycle + kRaster);
    });
    constexpr int kPlace = kWidth + 1;  // the segment's first
    rules.row("a pixel of the wrong value", {{"composer/pixel", "PIPE", leaving(kPlace), 0}},
              shows(&B::pipe, leaving(kPlace), passed(kPlace)), [](const auto& bench) {
                  CHECK_THAT(bench.violations.at(0).detail, Catch::Contains("raster position 1, 1"));
              });
    rules.row(
        "one report of a wire for a frame", {{"composer/pixel", "PIPE", leaving(2), 0}},
        [](auto& bench) {
            for (const int i : {2, 3, 5}) bench.pipe.instead[leaving(i)] = {Pixel(1), true, false};
        },
        [](const auto& bench) { CHECK(bench.monitor.unreported() == 2); });
    rules.row("a pixel marked lost that is not", {{"composer/lost", "PIPE", leaving(4), 0}},
              shows(&B::pipe, leaving(4), passed(4, true)));
    rules.row("a gap in the raster", {{"pipeline/raster", "PIPE", leaving(9), 0}},
              shows(&B::pipe, leaving(9), {}));
    rules.row("a pixel more than the raster has", {{"pipeline/raster", "PIPE", leaving(kRaster), 0}},
              shows(&B::pipe, leaving(kRaster), passed(0)));
    rules.row("a raster that begins with STARTFRAME", {{"pipeline/raster", "PIPE", leaving(-1), 0}},
              shows(&B::pipe, leaving(-1), passed(0)));
    rules.row(
        "STARTFRAME is passed on a clock later", {{"pipeline/startframe", "STARTFRAME", kStart + 1, 0}},
        [](auto& bench) {
            bench.startframe.instead = {{kStart + 1, false}, {kStart + 2, true}};
        },
        [](const auto& bench) { CHECK(bench.monitor.unreported() == 1); });
    rules.row("STARTFRAME out of nothing", {{"pipeline/startframe", "STARTFRAME", 10, 0}},
              shows(&B::startframe, 10, true));
    rules.row("BUSREADY low with room for a slot", {{"composer/busready", "BUSREADY", 12, 0}},
              shows(&B::busready, 12, false));
    rules.row("TABLEREADY low with one table kept", {{"composer/tableready", "TABLEREADY", 8, 0}},
              shows(&B::tableready, 8, false));
    rules.row("TABLEREADY high with two tables kept", {{"composer/tableready", "TABLEREADY", 20, 1}},
              [](auto& bench) {
                  bench.dut.put_table(11, {});
                  bench.tableready.instead[20] = true;
              });
    rules.row("STALL that nothing asks for", {{"composer/stall", "STALL", 20, 0}},
              shows(&B::stall, 20, true));
    rules.row("PIPEREADY before the segment is prefetched", {{"pipeready/prefetched", "PIPEREADY", 8, 0}},
              shows(&B::pipeready, 8, true));
    rules.row("PIPEREADY taken back before STARTFRAME", {{"pipeready/taken-back", "PIPEREADY", 12, 0}},
              shows(&B::pipeready, 12, false));
    rules.row("PIPEREADY stays high after STARTFRAME", {{"pipeready/startframe", "PIPEREADY", kStart + 1, 0}},
              shows(&B::pipeready, kStart + 1, true));
    rules.row("PIPEREADY a clock late", {{"pipeready/late", "PIPEREADY", 10, 0}},
              shows(&B::pipeready, 10, false));

    rules.of(composer_scenario(), &B::put_frame);
    rules.row("STARTFRAME to a composer that is not ready",
              {{"pipeready/unready", "composer_startframe_in", kStart, 0}},
              [](auto& bench) { bench.dut.start_frame(kStart); });
    rules.row("PIPEREADY without PIPEREADY from below", {{"pipeready/below", "PIPEREADY", 11, 0}},
              [](auto& bench) {
                  bench.composite(12);
                  bench.pipeready.instead[11] = true;
              });
    rules.of(composer_scenario(), no_stream);
    rules.row("PIPEREADY before a table has come", {{"pipeready/prefetched", "PIPEREADY", 8, 0}},
              [](auto& bench) {
                  bench.bench.core.drive(bench.dut.pipeready_in, 2, true);
                  bench.pipeready.instead[8] = true;
              });
    rules.row(
        "a frame of lost pixels must be marked", {{"composer/lost", "PIPE", leaving(4), 0}},
        [](auto& bench) {
            bench.put_table();
            bench.dut.put_single_pixels(4, 0, 2);
            bench.dut.put_single_pixels(7, 3, 3);  // pixel 2 is lost
            bench.composite();
            bench.pipe.instead[leaving(4)] = passed(4, false);
        },
        [](const auto& bench) { CHECK(bench.monitor.counters().lost_pixels == 1); });

    rules.of(composer_scenario(), put_master, Strap::kMaster);
    rules.row("a PIPEMASTER by the rules", {}, {},
              [](const auto& bench) { CHECK(bench.monitor.observer().frame() == 0); });
    rules.row("a PIPEMASTER that starts a clock early", {{"pipeline/startframe", "STARTFRAME", 10, 0}},
              shows(&B::startframe, 10, true));
    rules.row("a PIPEMASTER that does not answer its PIPEREADY",
              {{"pipeline/startframe", "STARTFRAME", 11, 0}}, shows(&B::startframe, 11, false));

    rules.of(composer_scenario(7), &B::put_picture);  // six held leave less than the ready space
    rules.row("BUSREADY high without room for a slot", {{"composer/busready", "BUSREADY", 12, 0}},
              shows(&B::busready, 12, true));
    // After edge 6 three pixels are held and three are to come: more than one beat. There is room for four.
    rules.row("BUSREADY low in a burst while two beats fit", {{"composer/busready", "BUSREADY", 7, 0}},
              shows(&B::busready, 7, false));
    const Scenario just_fits = composer_scenario(16, 14);
    rules.of(just_fits, &B::put_table);
    // Until no beat has come for a page miss and a beat BUSREADY is about the burst, for which there is room; after
    // that about a slot, which just fits.
    rules.row(
        "an announced burst of which no more beats come is over",
        {{"composer/busready", "BUSREADY", 10 + just_fits.memory.page_miss_cycles, 0}},
        [](auto& bench) {
            bench.dut.put_pixels(4, 0, 1, 5);
            bench.dut.put_pixels(5, 1, 1, 4);
            bench.busready.instead[10 + bench.dut.scenario.memory.page_miss_cycles] = false;
        },
        [](const auto& bench) { CHECK(bench.monitor.observer().announced_pixels() == 0); });
    rules.of(busready_low(std::nullopt), &B::put_picture);
    rules.row("a fault may hold BUSREADY low and not TABLEREADY",
              {{"composer/tableready", "TABLEREADY", 13, 0}}, [](auto& bench) {
                  bench.busready.instead[12] = false;
                  bench.tableready.instead[13] = false;
              });
    rules.of(busready_low(3), &B::put_picture);
    rules.row("a fault that is over excuses no low BUSREADY", {{"composer/busready", "BUSREADY", 12, 0}},
              shows(&B::busready, 12, false));

    const auto of_stalls = [&rules](int renderer, StarvationMode mode, int cycles) {
        rules.of(stalls_of(renderer, mode, cycles), &B::put_picture, Strap::kRelay, StallWire::kDriven);
    };
    of_stalls(1, StarvationMode::kStall, kEnd);
    rules.row("STALL that a fault may raise", {}, shows(&B::stall, 20, true));
    of_stalls(0, StarvationMode::kStall, kEnd);
    rules.row("a fault of another row excuses no STALL", {{"composer/stall", "STALL", 20, 0}},
              shows(&B::stall, 20, true));
    of_stalls(1, StarvationMode::kStall, 5);
    rules.row("a fault that is over excuses no STALL", {{"composer/stall", "STALL", 20, 0}},
              shows(&B::stall, 20, true));
    of_stalls(1, StarvationMode::kGlitch, kEnd);
    rules.row("no fault raises STALL in glitch mode", {{"composer/stall", "STALL", 20, 0}},
              shows(&B::stall, 20, true));

    rules.of(stalling(), put_late, Strap::kRelay, StallWire::kDriven);
    rules.row("a column that stalls by the rules", {}, {},
              [](const auto& bench) { CHECK(bench.monitor.counters().stalled_cycles == kLate); });
    rules.row("STALL low one clock before a pixel that has not come is needed",
              {{"composer/stall", "STALL", kNeeded, 0}}, shows(&B::stall, kNeeded, false));
    rules.row("a pixel that moves on while the column stands still",
              {{"pipeline/freeze", "PIPE", kNeeded + 2, 0}}, shows(&B::pipe, kNeeded + 2, passed(0)));
    rules.row("a STARTFRAME that moves on while the column stands still",
              {{"pipeline/freeze", "STARTFRAME", kNeeded + 2, 0}}, shows(&B::startframe, kNeeded + 2, true));
    rules.run_and_check(kEnd);
}

TEST_CASE("composer monitor: the rules in a table of a bus that sends what does not fit", "[monitors]") {
    // The composer itself reports what the bus does wrong; here its monitor must report it.
    sc_core::sc_report_handler::set_actions("/metabuffer/composer/protocol", sc_core::SC_DO_NOTHING);
    ClockedRuleTable<MonitorBench> rules;
    rules.of(composer_scenario(5), &MonitorBench::put_frame);
    rules.row("a pixel for a full buffer", {{"composer/occupancy", "composer_bus", 9, 0}});
    rules.of(composer_scenario(), &MonitorBench::put_frame);
    rules.row("a third frame's table", {{"composer/table", "composer_bus", 13, 2}}, [](auto& bench) {
        bench.dut.put_table(11, {});
        bench.dut.put_table(13, {});
    });
    rules.run_and_check(kEnd);
}

TEST_CASE("composer observer: the results of over and the alpha key for every pair of alphas", "[monitors]") {
    constexpr int kPixels = 256;
    const auto local = [](int i, int alpha) {
        return Pixel(static_cast<std::uint8_t>(i), 200, 7, static_cast<std::uint8_t>(alpha), 100);
    };
    // In front of it and behind it in turn.
    const auto above = [](int i) {
        return Pixel(99, static_cast<std::uint8_t>(i), 255, static_cast<std::uint8_t>(255 - i),
                     i % 2 == 0 ? 99U : 101U);
    };
    // Rounding by hand, in floating point.
    const auto over = [](const Pixel& front, const Pixel& back) {
        const auto channel = [&front](int f, int b) {
            const double sum = f + std::floor(b * (255.0 - front.a()) / 255.0 + 0.5);
            return static_cast<std::uint8_t>(std::min(255.0, sum));
        };
        return Pixel(channel(front.r(), back.r()), channel(front.g(), back.g()), channel(front.b(), back.b()),
                     channel(front.a(), back.a()), front.z());
    };
    for (const CompositionRow& composition : kCompositionTable) {
        Scenario scenario = small_scenario(16, 16);
        scenario.composition = composition.value;
        scenario.composer.buffer_pixels = kPixels;
        for (int alpha = 0; alpha < 256; alpha += 15) {
            monitors::ComposerObserver observer(scenario, 0, 0);
            observer.reset(false);
            std::int64_t cycle = 0;
            const auto edge = [&](const rtl::BusBeat& beat, bool startframe = false,
                                  const rtl::PipePixel& pipe = {}) {
                observer.edge({beat, startframe, pipe, false, false}, cycle++);
            };
            edge(rtl::BusBeat::frame_start(0, false));
            edge(rtl::BusBeat::table_row(0, 0, table_row(1, {0, 0}, {16, 16}, {0, 0}), true));
            for (int i = 0; i < kPixels; ++i) edge(pixels_beat(i, {local(i, alpha).word()}));
            edge({}, true);
            for (int i = 0; i < kPixels; ++i) {
                edge({}, false, {above(i), true, false});
                const bool nearer = i % 2 == 1;
                const Pixel front = nearer ? local(i, alpha) : above(i);
                const Pixel key = nearer && alpha > 0 ? local(i, alpha) : above(i);
                const Pixel expected = composition.value == Composition::kOver
                                           ? over(front, nearer ? above(i) : local(i, alpha))
                                           : (composition.value == Composition::kZAlphaKey ? key : front);
                if (observer.expected().pipe.pixel == expected) continue;
                FAIL(composition.name << ", pixel " << i << " of alpha " << alpha << ": " << std::hex
                                      << observer.expected().pipe.pixel.word() << ", not "
                                      << expected.word());
            }
        }
    }
}

TEST_CASE("composer observer: which local pixel comes next, what is held and what is missing", "[monitors]") {
    Scenario scenario = small_scenario(4, 4);
    scenario.composer.on_starvation = StarvationMode::kGlitch;
    scenario.composer.buffer_pixels = 8;
    monitors::ComposerObserver observer(scenario, 0, 0);
    observer.reset(false);
    std::int64_t cycle = 0;
    const rtl::PipePixel upstream{scenario.background_pixel(), true, false};
    const auto edge = [&](const rtl::BusBeat& bus, bool startframe = false) {
        observer.edge({bus, startframe, upstream, false, false}, cycle++);
    };
    const auto next = [&observer] {
        const auto local = observer.next_local_pixel();
        REQUIRE(local.has_value());
        return *local;
    };
    CHECK_FALSE(observer.has_frame());
    CHECK(observer.has_room_for_table());
    CHECK(observer.missing_pixels() == 0);
    edge(rtl::BusBeat::frame_start(0, false));
    CHECK(observer.has_frame());
    CHECK_FALSE(observer.table_complete());
    // Two by two pixels, each of which shows four times.
    edge(rtl::BusBeat::table_row(0, 0, table_row(1, {0, 0}, {2, 2}, {0, 0}, 2), true));
    CHECK(observer.table_complete());
    CHECK(observer.has_segment());
    CHECK(observer.segment().pixels() == 4);
    CHECK(observer.missing_pixels() == 4);
    CHECK_FALSE(observer.segment_complete());
    const auto pixels = [](int first) { return pixels_beat(first, {first + 1U, first + 2U}); };
    edge(pixels(0), true);
    CHECK(observer.kept_pixels() == 2);
    CHECK(observer.arrived_pixels() == 2);
    CHECK(observer.missing_pixels() == 2);
    CHECK(observer.free_pixels() == 6);
    CHECK(observer.running());
    for (int position = 0; position < 8; ++position) {
        INFO("raster position " << position);
        const monitors::ComposerObserver::LocalPixel local = next();
        CHECK(local.index == position % 4 / 2);
        CHECK(local.column == position % 4 / 2);
        CHECK(local.arrived);
        CHECK(local.pixel == Pixel(static_cast<std::uint64_t>(local.index) + 1));
        CHECK(local.repeated == (position >= 4));
        CHECK(local.last_use == (position >= 4 && position % 2 == 1));
        edge({});
        CHECK(observer.kept_pixels() == 0);
    }
    CHECK(observer.held_pixels() == 0);
    CHECK(next().index == 2);
    CHECK(next().starves());
    edge(rtl::BusBeat{});
    edge(pixels(2));
    CHECK(observer.segment_complete());
    CHECK_FALSE(next().starves());
    // Nothing of the frame is missing when the next one begins.
    edge(rtl::BusBeat::frame_start(1, true));
    CHECK_FALSE(observer.has_room_for_table());
    CHECK_FALSE(next().abandoned);
    for (int position = 11; position < 16; ++position) edge(rtl::BusBeat{});
    CHECK_FALSE(observer.running());
    CHECK(observer.has_room_for_table());
    CHECK(observer.table_complete());
    CHECK_FALSE(observer.has_segment());
    CHECK(observer.segment_complete());
}

}  // namespace metabuffer::test::composer_monitor_test
