#include "monitors/composer_monitor.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "composer_bench.h"
#include "violations.h"

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

Scenario composer_scenario() {
    Scenario scenario = small_scenario(kWidth, kRaster / kWidth);
    scenario.composer.buffer_pixels = 16;
    scenario.composer.ready_space_pixels = 2;
    return scenario;
}

struct MonitorBench {
    ClockedTestbench bench;
    ComposerBench dut;
    Violations violations{bench.core};
    Tap<bool> busready;
    Tap<bool> tableready;
    Tap<bool> startframe;
    Tap<rtl::PipePixel> pipe;
    Tap<bool> pipeready;
    Tap<bool> stall;
    monitors::ComposerMonitor monitor;

    explicit MonitorBench(Scenario scenario = composer_scenario(), Strap strap = Strap::kRelay,
                          StallWire stall_wire = StallWire::kOwn)
        : dut(bench, "composer", std::move(scenario), strap, stall_wire),
          busready("BUSREADY", bench.core, dut.busready),
          tableready("TABLEREADY", bench.core, dut.tableready),
          startframe("STARTFRAME", bench.core, dut.startframe_out),
          pipe("PIPE", bench.core, dut.pipe_out),
          pipeready("PIPEREADY", bench.core, dut.pipeready_out),
          stall("STALL", bench.core, dut.stall),
          monitor("monitor", dut.scenario, 1, 0, violations.log) {
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
    }

    /// A segment of 3 x 2 pixels, its table at clocks 2 and 3, its pixels in one burst from 4 to 9.
    void put_frame() {
        dut.put_table(2, {table_row(1, {0, 0}, {3, 2}, {1, 1})});
        for (int i = 0; i < 6; ++i) dut.put_pixels(4 + i, i, 1, 5 - i);
    }
    /// PIPEREADY from below from clock `ready` on to STARTFRAME, and the raster.
    void composite(int ready = 5) {
        bench.core.drive(dut.pipeready_in, ready, true);
        bench.core.drive(dut.pipeready_in, kStart + 2, false);
        dut.start_frame(kStart);
    }
    void run() { bench.run_through(kEnd); }
};

rtl::PipePixel pixel(std::uint64_t word, bool lost = false) { return {Pixel(word), true, lost}; }

/// What the composer passes on where its segment does not lie, at raster position i.
rtl::PipePixel passed(int i, bool lost = false) { return pixel(ComposerBench::upstream(i).word(), lost); }

}  // namespace

TEST_CASE("composer monitor: a composer by the rules breaks none", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.counters().buffer_high_water == 6);
    REQUIRE(bench.monitor.observer().frame_spans().size() == 1);
    const auto& span = bench.monitor.observer().frame_spans()[0];
    CHECK(span.startframe_cycle - bench.bench.core.reset_clocks() == kStart);
    CHECK(span.start_cycle == span.startframe_cycle + 1);
    CHECK(span.end_cycle == span.startframe_cycle + kRaster);
}

TEST_CASE("composer monitor: a pixel of the wrong value", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    const int place = kWidth + 1;  // the segment's first
    bench.pipe.instead[leaving(place)] = passed(place);
    bench.run();
    bench.violations.check_only("composer/pixel", "PIPE", leaving(place), 0);
    CHECK(bench.violations.list[0].detail.find("raster position 1, 1") != std::string::npos);
}

TEST_CASE("composer monitor: a pixel marked lost that is not", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipe.instead[leaving(4)] = passed(4, true);
    bench.run();
    bench.violations.check_only("composer/lost", "PIPE", leaving(4), 0);
}

TEST_CASE("composer monitor: a frame of lost pixels must be marked", "[monitors]") {
    MonitorBench bench;
    bench.dut.put_table(2, {table_row(1, {0, 0}, {3, 2}, {1, 1})});
    bench.dut.put_single_pixels(4, 0, 2);
    bench.dut.put_single_pixels(7, 3, 3);  // pixel 2 is lost
    bench.composite();
    bench.pipe.instead[leaving(4)] = passed(4, false);
    bench.run();
    bench.violations.check_only("composer/lost", "PIPE", leaving(4), 0);
    CHECK(bench.monitor.counters().lost_pixels == 1);
}

TEST_CASE("composer monitor: a gap in the raster", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipe.instead[leaving(9)] = rtl::PipePixel{};
    bench.run();
    bench.violations.check_only("pipeline/raster", "PIPE", leaving(9), 0);
}

TEST_CASE("composer monitor: a pixel more than the raster has", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipe.instead[leaving(kRaster)] = passed(0);
    bench.run();
    bench.violations.check_only("pipeline/raster", "PIPE", leaving(kRaster), 0);
}

TEST_CASE("composer monitor: a raster that begins with STARTFRAME", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipe.instead[leaving(-1)] = passed(0);
    bench.run();
    bench.violations.check_only("pipeline/raster", "PIPE", leaving(-1), 0);
}

TEST_CASE("composer monitor: STARTFRAME is passed on a clock later", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.startframe.instead[kStart + 1] = false;
    bench.startframe.instead[kStart + 2] = true;
    bench.run();
    bench.violations.check_only("pipeline/startframe", "STARTFRAME", kStart + 1, 0);
    CHECK(bench.monitor.unreported() == 1);
}

TEST_CASE("composer monitor: STARTFRAME out of nothing", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.startframe.instead[10] = true;
    bench.run();
    bench.violations.check_only("pipeline/startframe", "STARTFRAME", 10, 0);
}

namespace {

/// A PIPEMASTER whose PIPEREADY is high after edge 9: it answers at 10, for edge 11 to read.
struct MasterBench : MonitorBench {
    MasterBench() : MonitorBench(composer_scenario(), Strap::kMaster) {
        put_frame();
        bench.core.drive(dut.pipeready_in, 5, true);
        bench.core.drive(dut.pipeready_in, 12, false);
    }
};

}  // namespace

TEST_CASE("composer monitor: a PIPEMASTER by the rules breaks none", "[monitors]") {
    MasterBench bench;
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.observer().frame() == 0);
}

TEST_CASE("composer monitor: a PIPEMASTER that starts a clock early", "[monitors]") {
    MasterBench bench;
    bench.startframe.instead[10] = true;
    bench.run();
    bench.violations.check_only("pipeline/startframe", "STARTFRAME", 10, 0);
}

TEST_CASE("composer monitor: a PIPEMASTER that does not answer its PIPEREADY", "[monitors]") {
    MasterBench bench;
    bench.startframe.instead[11] = false;
    bench.run();
    bench.violations.check_only("pipeline/startframe", "STARTFRAME", 11, 0);
}

TEST_CASE("composer monitor: BUSREADY low with room for a slot", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.busready.instead[12] = false;
    bench.run();
    bench.violations.check_only("composer/busready", "BUSREADY", 12, 0);
}

TEST_CASE("composer monitor: a fault that is over excuses no low BUSREADY", "[monitors]") {
    Scenario scenario = composer_scenario();
    scenario.memory.page_miss_cycles = 0;
    Fault fault;
    fault.kind = FaultKind::kBusreadyLow;
    fault.renderer = 1;
    fault.display = 1;
    fault.cycles = 3;
    scenario.faults.push_back(fault);
    MonitorBench bench(scenario);
    bench.put_frame();
    bench.composite();
    bench.busready.instead[12] = false;
    bench.run();
    bench.violations.check_only("composer/busready", "BUSREADY", 12, 0);
}

TEST_CASE("composer monitor: BUSREADY high without room for a slot", "[monitors]") {
    Scenario scenario = composer_scenario();
    scenario.composer.buffer_pixels = 7;  // six held leave less than the ready space
    MonitorBench bench(scenario);
    bench.put_frame();
    bench.composite();
    bench.busready.instead[12] = true;
    bench.run();
    bench.violations.check_only("composer/busready", "BUSREADY", 12, 0);
}

TEST_CASE("composer monitor: BUSREADY in a burst stays high while two beats fit", "[monitors]") {
    Scenario scenario = composer_scenario();
    scenario.composer.buffer_pixels = 7;
    MonitorBench bench(scenario);
    bench.put_frame();
    bench.composite();
    // After edge 6 three pixels are held and three are to come: more than one beat. There is room for four.
    bench.busready.instead[7] = false;
    bench.run();
    bench.violations.check_only("composer/busready", "BUSREADY", 7, 0);
}

TEST_CASE(
    "composer monitor: an announced burst is over when no beat has come for a page miss and a "
    "beat",
    "[monitors]") {
    Scenario scenario = composer_scenario();
    scenario.composer.ready_space_pixels = 14;
    MonitorBench bench(scenario);
    bench.dut.put_table(2, {table_row(1, {0, 0}, {3, 2}, {1, 1})});
    bench.dut.put_pixels(4, 0, 1, 5);
    bench.dut.put_pixels(5, 1, 1, 4);
    // Until then BUSREADY is about the burst, for which there is room; after it about a slot, which just fits.
    const int over = 5 + scenario.memory.page_miss_cycles + 1;
    bench.busready.instead[over + 4] = false;
    bench.run();
    bench.violations.check_only("composer/busready", "BUSREADY", over + 4, 0);
    CHECK(bench.monitor.observer().announced_pixels() == 0);
}

TEST_CASE("composer monitor: TABLEREADY low with one table kept", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.tableready.instead[8] = false;
    bench.run();
    bench.violations.check_only("composer/tableready", "TABLEREADY", 8, 0);
}

TEST_CASE("composer monitor: TABLEREADY high with two tables kept", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.dut.put_table(11, {});
    bench.composite();
    bench.tableready.instead[20] = true;
    bench.run();
    bench.violations.check_only("composer/tableready", "TABLEREADY", 20, 1);
}

TEST_CASE("composer monitor: STALL that nothing asks for", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.stall.instead[20] = true;
    bench.run();
    bench.violations.check_only("composer/stall", "STALL", 20, 0);
}

namespace {

/// A fault that may raise STALL of the composer's row.
Scenario stalls_of(int renderer, StarvationMode mode, std::int64_t cycles) {
    Scenario scenario = composer_scenario();
    scenario.composer.on_starvation = mode;
    scenario.faults.push_back(random_stalls(renderer, 1, 0, cycles));
    return scenario;
}
constexpr std::int64_t kWholeRun = 1000;

}  // namespace

TEST_CASE("composer monitor: STALL that a fault may raise", "[monitors]") {
    MonitorBench bench(stalls_of(1, StarvationMode::kStall, kWholeRun), Strap::kRelay, StallWire::kDriven);
    bench.put_frame();
    bench.composite();
    bench.stall.instead[20] = true;
    bench.run();
    bench.violations.check_none();
}

TEST_CASE("composer monitor: a fault of another row excuses no STALL", "[monitors]") {
    MonitorBench bench(stalls_of(0, StarvationMode::kStall, kWholeRun), Strap::kRelay, StallWire::kDriven);
    bench.put_frame();
    bench.composite();
    bench.stall.instead[20] = true;
    bench.run();
    bench.violations.check_only("composer/stall", "STALL", 20, 0);
}

TEST_CASE("composer monitor: a fault that is over excuses no STALL", "[monitors]") {
    MonitorBench bench(stalls_of(1, StarvationMode::kStall, 5), Strap::kRelay, StallWire::kDriven);
    bench.put_frame();
    bench.composite();
    bench.stall.instead[20] = true;
    bench.run();
    bench.violations.check_only("composer/stall", "STALL", 20, 0);
}

TEST_CASE("composer monitor: no fault raises STALL in glitch mode", "[monitors]") {
    MonitorBench bench(stalls_of(1, StarvationMode::kGlitch, kWholeRun), Strap::kRelay, StallWire::kDriven);
    bench.put_frame();
    bench.composite();
    bench.stall.instead[20] = true;
    bench.run();
    bench.violations.check_only("composer/stall", "STALL", 20, 0);
}

namespace {

/// Pixel 4 is needed at raster position 18, composited at the edge kNeeded, and comes four clocks late.
struct StallBench : MonitorBench {
    static constexpr int kNeeded = kStart + 19;
    static constexpr int kLate = 4;

    StallBench() : MonitorBench(stalling(), Strap::kRelay, StallWire::kDriven) {
        dut.put_table(2, {table_row(1, {0, 0}, {3, 2}, {1, 1})});
        dut.put_single_pixels(4, 0, 4);
        dut.put_single_pixels(kNeeded + kLate - 1, 4, 2);
        composite();
        bench.core.drive(dut.column_stall, kNeeded, true);
        bench.core.drive(dut.column_stall, kNeeded + kLate, false);
    }
    static Scenario stalling() {
        Scenario scenario = composer_scenario();
        scenario.composer.on_starvation = StarvationMode::kStall;
        scenario.composer.ready_space_pixels = 13;  // no further slot with four of the six
        return scenario;
    }
};

}  // namespace

TEST_CASE("composer monitor: a column that stalls by the rules breaks none", "[monitors]") {
    StallBench bench;
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.counters().stalled_cycles == StallBench::kLate);
}

TEST_CASE("composer monitor: STALL is high one clock before a pixel that has not come is needed",
          "[monitors]") {
    StallBench bench;
    bench.stall.instead[StallBench::kNeeded] = false;
    bench.run();
    bench.violations.check_only("composer/stall", "STALL", StallBench::kNeeded, 0);
}

TEST_CASE("composer monitor: a pixel that moves on while the column stands still", "[monitors]") {
    StallBench bench;
    bench.pipe.instead[StallBench::kNeeded + 2] = passed(0);
    bench.run();
    bench.violations.check_only("pipeline/freeze", "PIPE", StallBench::kNeeded + 2, 0);
}

TEST_CASE("composer monitor: a STARTFRAME that moves on while the column stands still", "[monitors]") {
    StallBench bench;
    bench.startframe.instead[StallBench::kNeeded + 2] = true;
    bench.run();
    bench.violations.check_only("pipeline/freeze", "STARTFRAME", StallBench::kNeeded + 2, 0);
}

namespace {

/// The composer itself reports what the bus does wrong; here its monitor must report it.
void let_the_composer_go_on() {
    sc_core::sc_report_handler::set_actions("/metabuffer/composer/protocol", sc_core::SC_DO_NOTHING);
}

}  // namespace

TEST_CASE("composer monitor: a pixel for a full buffer", "[monitors]") {
    let_the_composer_go_on();
    Scenario scenario = composer_scenario();
    scenario.composer.buffer_pixels = 5;
    MonitorBench bench(scenario);
    bench.put_frame();
    bench.run();
    bench.violations.check_only("composer/occupancy", bench.dut.bus.basename(), 9, 0);
}

TEST_CASE("composer monitor: a third frame's table", "[monitors]") {
    let_the_composer_go_on();
    MonitorBench bench;
    bench.put_frame();
    bench.dut.put_table(11, {});
    bench.dut.put_table(13, {});
    bench.run();
    bench.violations.check_only("composer/table", bench.dut.bus.basename(), 13, 2);
}

TEST_CASE("composer monitor: PIPEREADY before the segment is prefetched", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipeready.instead[8] = true;
    bench.run();
    bench.violations.check_only("pipeready/prefetched", "PIPEREADY", 8, 0);
}

TEST_CASE("composer monitor: PIPEREADY before a table has come", "[monitors]") {
    MonitorBench bench;
    bench.bench.core.drive(bench.dut.pipeready_in, 2, true);
    bench.pipeready.instead[8] = true;
    bench.run();
    bench.violations.check_only("pipeready/prefetched", "PIPEREADY", 8, 0);
}

TEST_CASE("composer monitor: PIPEREADY without PIPEREADY from below", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite(12);
    bench.pipeready.instead[11] = true;
    bench.run();
    bench.violations.check_only("pipeready/below", "PIPEREADY", 11, 0);
}

TEST_CASE("composer monitor: PIPEREADY taken back before STARTFRAME", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipeready.instead[12] = false;
    bench.run();
    bench.violations.check_only("pipeready/taken-back", "PIPEREADY", 12, 0);
}

TEST_CASE("composer monitor: PIPEREADY that stays high after STARTFRAME", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipeready.instead[kStart + 1] = true;
    bench.run();
    bench.violations.check_only("pipeready/startframe", "PIPEREADY", kStart + 1, 0);
}

TEST_CASE("composer monitor: PIPEREADY a clock late", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    bench.pipeready.instead[10] = false;
    bench.run();
    bench.violations.check_only("pipeready/late", "PIPEREADY", 10, 0);
}

TEST_CASE("composer monitor: STARTFRAME to a composer that is not ready", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.dut.start_frame(kStart);
    bench.run();
    bench.violations.check_only("pipeready/unready", bench.dut.startframe_in.basename(), kStart, 0);
}

TEST_CASE("composer monitor: one report of a wire for a frame", "[monitors]") {
    MonitorBench bench;
    bench.put_frame();
    bench.composite();
    for (const int i : {2, 3, 5}) bench.pipe.instead[leaving(i)] = pixel(1);
    bench.run();
    bench.violations.check_only("composer/pixel", "PIPE", leaving(2), 0);
    CHECK(bench.monitor.unreported() == 2);
}

TEST_CASE("composer monitor: a handshake that a fault of the scenario holds low", "[monitors]") {
    Scenario scenario = composer_scenario();
    Fault fault;
    fault.kind = FaultKind::kBusreadyLow;
    fault.renderer = 1;
    fault.display = 1;
    scenario.faults.push_back(fault);
    MonitorBench bench(scenario);
    bench.put_frame();
    bench.composite();
    bench.busready.instead[12] = false;
    bench.tableready.instead[13] = false;
    bench.run();
    bench.violations.check_only("composer/tableready", "TABLEREADY", 13, 0);
}

TEST_CASE("composer observer: the results of over and the alpha key for every pair of alphas", "[monitors]") {
    // The observer's arithmetic against rounding by hand, in floating point.
    for (const CompositionRow& composition : kCompositionTable) {
        Scenario scenario = small_scenario(16, 16);
        scenario.composition = composition.value;
        scenario.composer.buffer_pixels = 256;
        for (int alpha = 0; alpha < 256; alpha += 15) {
            monitors::ComposerObserver observer(scenario, 0, 0);
            observer.reset(false);
            const rtl::PipePixel nothing;
            std::int64_t cycle = 0;
            const auto beat = [&](const rtl::BusBeat& value) {
                observer.edge({value, false, nothing, false, false}, cycle++);
            };
            const auto local = [alpha](int i) {
                return Pixel(static_cast<std::uint8_t>(i), 200, 7, static_cast<std::uint8_t>(alpha), 100);
            };
            // In front of it and behind it in turn.
            const auto above = [](int i) {
                return Pixel(99, static_cast<std::uint8_t>(i), 255, static_cast<std::uint8_t>(255 - i),
                             i % 2 == 0 ? 99U : 101U);
            };
            beat(rtl::BusBeat::frame_start(0, false));
            beat(rtl::BusBeat::table_row(0, 0, table_row(1, {0, 0}, {16, 16}, {0, 0}), true));
            for (int i = 0; i < 256; ++i) {
                rtl::BusBeat one;
                one.kind = rtl::BusBeat::Kind::kPixels;
                one.destination = 1;
                one.count = 1;
                one.first = static_cast<std::uint32_t>(i);
                one.words[0] = local(i).word();
                beat(one);
            }
            observer.edge({rtl::BusBeat{}, true, nothing, false, false}, cycle++);
            for (int i = 0; i < 256; ++i) {
                observer.edge({rtl::BusBeat{}, false, rtl::PipePixel{above(i), true, false}, false, false},
                              cycle++);
                const bool nearer = i % 2 == 1;
                const Pixel front = nearer ? local(i) : above(i);
                const Pixel back = nearer ? above(i) : local(i);
                const auto channel = [&](int f, int b) {
                    const double sum = f + std::floor(b * (255.0 - front.a()) / 255.0 + 0.5);
                    return static_cast<std::uint8_t>(std::min(255.0, sum));
                };
                Pixel expected;
                switch (composition.value) {
                    case Composition::kZ:
                        expected = front;
                        break;
                    case Composition::kZAlphaKey:
                        expected = nearer && alpha > 0 ? local(i) : above(i);
                        break;
                    case Composition::kOver:
                        expected =
                            Pixel(channel(front.r(), back.r()), channel(front.g(), back.g()),
                                  channel(front.b(), back.b()), channel(front.a(), back.a()), front.z());
                        break;
                }
                if (!(observer.expected().pipe.pixel == expected)) {
                    FAIL(composition.name << ", pixel " << i << " of alpha " << alpha << ": " << std::hex
                                          << observer.expected().pipe.pixel.word() << ", not "
                                          << expected.word());
                }
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
    const auto pixels = [](std::uint32_t first) {
        rtl::BusBeat beat;
        beat.kind = rtl::BusBeat::Kind::kPixels;
        beat.destination = 1;
        beat.count = 2;
        beat.first = first;
        beat.words = {first + 1, first + 2};
        return beat;
    };
    edge(pixels(0), true);
    CHECK(observer.kept_pixels() == 2);
    CHECK(observer.arrived_pixels() == 2);
    CHECK(observer.missing_pixels() == 2);
    CHECK(observer.free_pixels() == 6);
    CHECK(observer.running());
    for (int place = 0; place < 8; ++place) {
        INFO("raster position " << place);
        const monitors::ComposerObserver::LocalPixel local = next();
        CHECK(local.index == place % 4 / 2);
        CHECK(local.column == place % 4 / 2);
        CHECK(local.arrived);
        CHECK(local.pixel == Pixel(static_cast<std::uint64_t>(local.index) + 1));
        CHECK(local.repeated == (place >= 4));
        CHECK(local.last_use == (place >= 4 && place % 2 == 1));
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
    for (int place = 11; place < 16; ++place) edge(rtl::BusBeat{});
    CHECK_FALSE(observer.running());
    CHECK(observer.has_room_for_table());
    CHECK(observer.table_complete());
    CHECK_FALSE(observer.has_segment());
    CHECK(observer.segment_complete());
}

}  // namespace metabuffer::test::composer_monitor_test
