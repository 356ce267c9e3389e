#include "monitors/swap_lock_monitor.h"

#include <catch2/catch.hpp>
#include <optional>
#include <utility>

#include "altered_machine.h"

namespace metabuffer::test::swap_lock_monitor_test {

namespace {

/// The monitor on the altered wires of a machine of two displays.
struct Bench : AlteredMachine {
    monitors::SwapLockMonitor monitor;
    std::int64_t edge = -1;  ///< at which the alteration is sampled
    int pictures = 0;

    explicit Bench(Scenario scenario_of_it = altered_scenario())
        : AlteredMachine(std::move(scenario_of_it)), monitor("monitor", scenario(), log) {
        monitor.clk_i(machine.core_clk());
        monitor.dvi_clk_i(machine.dvi_out_clk());
        monitor.reset_i(machine.reset());
        monitor.swaplock_i(wires().swaplock);
        monitor.swapskip_i(wires().swapskip);
        for (std::size_t d = 0; d < 2; ++d) {
            monitor.framedone_i[d](wires().framedone[d]);
            monitor.framebad_i[d](wires().framebad[d]);
            monitor.link_i[d](wires().link_out[d]);
        }
        monitor.on_picture([this](const auto&) { ++pictures; });
    }

    /// Alters the wires once, at the first edge from which the condition has held for `clocks` more.
    void once(const std::function<bool(rtl::Wires&)>& condition, int clocks,
              const std::function<void(rtl::Wires& real)>& change) {
        altered.alter = [=, held = 0](std::int64_t next, rtl::Wires& real) mutable {
            held = condition(real) ? held + 1 : 0;
            if (edge < 0 && held == clocks + 1) {
                edge = next;
                change(real);
            }
        };
    }
};

bool all_done(rtl::Wires& real) { return real.framedone[0].read() && real.framedone[1].read(); }
bool none_done(rtl::Wires& real) { return !real.framedone[0].read() && !real.framedone[1].read(); }

}  // namespace

TEST_CASE("swap lock monitor: a legal run breaks no rule and shows each frame once on each display",
          "[monitors]") {
    Bench bench;
    bench.run();
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
    CHECK(bench.monitor.frame() == kAlteredFrames - 1);
    CHECK(bench.monitor.kept_frames() == 0);
    CHECK(bench.pictures == 2 * kAlteredFrames);
}

TEST_CASE("swap lock monitor: SWAPLOCK while a FRAMEDONE is low", "[monitors]") {
    Bench bench;
    bench.once(none_done, 20, [&](rtl::Wires&) { bench.wires().swaplock.write(true); });
    bench.run();
    bench.check_first("swap-lock/all-done", "SWAPLOCK", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: SWAPLOCK low though every FRAMEDONE is high", "[monitors]") {
    Bench bench;
    bench.once(all_done, 20, [&](rtl::Wires&) { bench.wires().swaplock.write(false); });
    bench.run();
    bench.check_first("swap-lock/all-done", "SWAPLOCK", "core", bench.edge, -1);
}

namespace {

/// A fault that may hold the swap lock's wires, and hardly ever does.
Scenario stalled_scenario(int renderer, std::int64_t from_cycle, std::optional<std::int64_t> cycles) {
    return with_fault(altered_scenario(), random_stalls(renderer, 1, from_cycle, cycles));
}
constexpr int kLastRow = 1;

/// Lowers SWAPLOCK in the first clocks of a swap.
AlteredWires::Alter late_swaplock(Bench& bench, int clocks) {
    return [&bench, clocks, done = 0](std::int64_t next, rtl::Wires& real) mutable {
        done = all_done(real) ? done + 1 : 0;
        if (done < 1 || done > clocks) return;
        if (bench.edge < 0) bench.edge = next;
        bench.wires().swaplock.write(false);
    };
}

}  // namespace

TEST_CASE("swap lock monitor: SWAPLOCK may be late while a fault of the last row may hold it", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 0, std::nullopt));
    bench.altered.alter = late_swaplock(bench, 3);
    bench.run();
    CHECK(bench.edge > 0);
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
    CHECK(bench.pictures == 2 * kAlteredFrames);
}

TEST_CASE("swap lock monitor: a fault of another row excuses no late SWAPLOCK", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow - 1, 0, std::nullopt));
    bench.altered.alter = late_swaplock(bench, 3);
    bench.run();
    bench.check_first("swap-lock/all-done", "SWAPLOCK", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: a fault that is over excuses no late SWAPLOCK", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 0, 10));
    bench.altered.alter = late_swaplock(bench, 1);
    bench.run();
    bench.check_first("swap-lock/all-done", "SWAPLOCK", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: a fault that is still to come excuses no late SWAPLOCK", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 1'000'000, std::nullopt));
    bench.altered.alter = late_swaplock(bench, 1);
    bench.run();
    bench.check_first("swap-lock/all-done", "SWAPLOCK", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: SWAPLOCK is taken back while a fault may hold it", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 0, std::nullopt));
    bench.once(all_done, 20, [&](rtl::Wires&) { bench.wires().swaplock.write(false); });
    bench.run();
    bench.check_first("swap-lock/all-done", "SWAPLOCK", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: SWAPLOCK too early while a fault may hold it", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 0, std::nullopt));
    bench.once(none_done, 20, [&](rtl::Wires&) { bench.wires().swaplock.write(true); });
    bench.run();
    bench.check_first("swap-lock/all-done", "SWAPLOCK", "core", bench.edge, -1);
}

namespace {

/// A FRAMEBAD that is high from the run's start, and a SWAPSKIP that rises when it may.
void check_late_swapskip(Bench& bench, const std::function<bool(rtl::Wires& real)>& swapskip) {
    bench.altered.alter = [&bench, swapskip](std::int64_t, rtl::Wires& real) {
        bench.wires().framebad[1].write(true);
        bench.wires().swapskip.write(swapskip(real));
    };
    bench.run();
}

}  // namespace

TEST_CASE("swap lock monitor: SWAPSKIP may rise with SWAPLOCK while a fault may hold it", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 0, std::nullopt));
    bool risen = false;
    check_late_swapskip(bench, [&risen](rtl::Wires& real) { return risen = risen || all_done(real); });
    for (const auto& violation : bench.violations) CHECK(violation.rule != "swap-lock/any-bad");
}

TEST_CASE("swap lock monitor: SWAPSKIP later than SWAPLOCK while a fault may hold it", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 0, std::nullopt));
    int done = 0;
    std::int64_t edge = -1;
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        done += all_done(real) ? 1 : 0;
        if (done == 1 && edge < 0) edge = next;
        bench.wires().framebad[1].write(true);
        bench.wires().swapskip.write(done > 1);
    };
    bench.run();
    bench.check_first("swap-lock/any-bad", "SWAPSKIP", "core", edge, -1);
}

TEST_CASE("swap lock monitor: SWAPSKIP is taken back while a fault may hold it", "[monitors]") {
    Bench bench(stalled_scenario(kLastRow, 0, std::nullopt));
    bench.altered.alter = [&](std::int64_t next, rtl::Wires&) {
        bench.wires().framebad[1].write(true);
        bench.wires().swapskip.write(next == 20);
        bench.edge = 21;
    };
    bench.run();
    bench.check_first("swap-lock/any-bad", "SWAPSKIP", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: SWAPSKIP without a FRAMEBAD", "[monitors]") {
    Bench bench;
    bench.once(none_done, 20, [&](rtl::Wires&) { bench.wires().swapskip.write(true); });
    bench.run();
    bench.check_first("swap-lock/any-bad", "SWAPSKIP", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: FRAMEDONE falls without a swap", "[monitors]") {
    Bench bench;
    bench.once(all_done, 20, [&](rtl::Wires&) {
        bench.wires().framedone[1].write(false);
        bench.wires().swaplock.write(false);
    });
    bench.run();
    bench.check_first("swap-lock/framedone-fall", "FRAMEDONE_2", "core", bench.edge, -1);
    // It then rises a second time for the same swap.
    REQUIRE(bench.violations.size() >= 2);
    CHECK(bench.violations[1].rule == "swap-lock/framedone-rise");
    CHECK(bench.violations[1].cycle == bench.edge + 1);
}

TEST_CASE("swap lock monitor: FRAMEDONE stays high a clock too long after the swap", "[monitors]") {
    Bench bench;
    bool was_done = false;
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        if (was_done && none_done(real) && bench.edge < 0) {
            bench.edge = next;
            bench.wires().framedone[0].write(true);
        }
        was_done = all_done(real);
    };
    bench.run();
    bench.check_first("swap-lock/framedone-fall", "FRAMEDONE_1", "core", bench.edge, 0);
}

TEST_CASE("swap lock monitor: FRAMEDONE rises before the swap's level has come back", "[monitors]") {
    Bench bench;
    bool was_done = false;
    std::int64_t fall = -1;
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        if (was_done && none_done(real) && fall < 0) fall = next;
        was_done = all_done(real);
        if (fall >= 0 && next == fall + 1) {
            bench.edge = next;
            bench.wires().framedone[0].write(true);
        }
    };
    bench.run();
    bench.check_first("swap-lock/framedone-rise", "FRAMEDONE_1", "core", bench.edge, 0);
}

TEST_CASE("swap lock monitor: FRAMEBAD rises while FRAMEDONE is high", "[monitors]") {
    Bench bench;
    bench.once(all_done, 20, [&](rtl::Wires&) {
        bench.wires().framebad[1].write(true);
        bench.wires().swapskip.write(true);
    });
    bench.run();
    bench.check_first("swap-lock/framebad", "FRAMEBAD_2", "core", bench.edge, -1);
}

TEST_CASE("swap lock monitor: displays out of step", "[monitors]") {
    Bench bench;
    bench.once([](rtl::Wires& real) { return !real.link_out[1].read().vsync; }, 300,
               [&](rtl::Wires& real) {
                   rtl::DviLink link = real.link_out[1].read();
                   link.vsync = true;
                   bench.wires().link_out[1].write(link);
               });
    bench.run();
    REQUIRE_FALSE(bench.violations.empty());
    bench.check_first("swap-lock/in-step", "DVI_OUT_2", "dvi_out", bench.edge, bench.violations[0].frame);
}

TEST_CASE("swap lock monitor: a picture that changes without a swap", "[monitors]") {
    Bench bench;
    LinkPosition position({kAlteredWidth, kAlteredHeight});
    int shown_in = -1;  // the DVI frame in which a composited picture was shown first
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        rtl::DviLink link = real.link_out[0].read();
        if (!position.step(link)) return;
        if (link.de && link.data != 0 && shown_in < 0) shown_in = position.frame();
        // Black before the first swap: one pixel of it lights up.
        if (shown_in < 0 && link.de && position.line() == 8 && position.x() == 3 && bench.edge < 0) {
            bench.edge = next;
            link.data = 1;
            bench.wires().link_out[0].write(link);
        }
    };
    bench.run();
    bench.check_first("swap-lock/picture", "DVI_OUT_1", "dvi_out", bench.edge, -1);
    CHECK_THAT(bench.violations[0].detail, Catch::Contains("pixel 3,2 changes from #000000 to #000001"));
}

TEST_CASE("swap lock monitor: a display that swaps though pixels of the frame were lost", "[monitors]") {
    Bench bench;
    std::int64_t first_pixel = -1;
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        // FRAMEBAD is high with FRAMEDONE of display 1, as if the machine had raised and then ignored it.
        const bool bad = real.framedone[0].read();
        bench.wires().framebad[0].write(bad);
        bench.wires().swapskip.write(bad);
        const rtl::DviLink& link = real.link_out[0].read();
        if (link.de && link.data != 0 && first_pixel < 0) first_pixel = next;
    };
    bench.run();
    bench.check_first("swap-lock/kept", "DVI_OUT_1", "dvi_out", first_pixel, 0);
    CHECK(bench.monitor.kept_frames() == kAlteredFrames);
}

}  // namespace metabuffer::test::swap_lock_monitor_test
