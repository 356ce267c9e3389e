#include "monitors/swap_lock_monitor.h"

#include <catch2/catch.hpp>
#include <optional>

#include "altered_machine.h"

namespace metabuffer::test::swap_lock_monitor_test {

namespace {

/// The monitor on the altered wires of a machine of two displays.
struct SwapBench : AlteredBench {
    monitors::SwapLockMonitor monitor;
    int pictures = 0;

    SwapBench(const sc_core::sc_module_name& name, WatchedMachine& watched)
        : AlteredBench(name, watched), monitor("monitor", scenario, log) {
        bind_swap_lock(monitor);
        monitor.on_picture([this](const auto&) { ++pictures; });
    }
};

bool all_done(rtl::Wires& real) { return real.framedone[0].read() && real.framedone[1].read(); }
bool none_done(rtl::Wires& real) { return !real.framedone[0].read() && !real.framedone[1].read(); }

using Change = std::function<void(SwapBench&)>;
using Condition = std::function<bool(rtl::Wires& real)>;

/// Alters the wires once, at the first edge from which the condition has held for `clocks` more.
Change once(const Condition& condition, const std::function<void(rtl::Wires& altered)>& change,
            int clocks = 20) {
    return [=](SwapBench& bench) {
        bench.alter = [=, &bench, held = 0](std::int64_t next, rtl::Wires& real) mutable {
            held = condition(real) ? held + 1 : 0;
            if (bench.edge >= 0 || held != clocks + 1) return;
            bench.edge = next;
            change(bench.wires);
        };
    };
}
/// Raises FRAMEDONE of display 1 so many clocks after the first fall of all.
Change framedone_after_fall(int clocks) {
    return [=](SwapBench& bench) {
        bench.alter = [=, &bench, was_done = false](std::int64_t next, rtl::Wires& real) mutable {
            if (was_done && none_done(real) && bench.edge < 0) bench.edge = next + clocks;
            was_done = all_done(real);
            if (next == bench.edge) bench.wires.framedone[0].write(true);
        };
    };
}
/// Lowers SWAPLOCK in the first clocks of a swap.
Change late_swaplock(int clocks) {
    return [=](SwapBench& bench) {
        bench.alter = [=, &bench, done = 0](std::int64_t next, rtl::Wires& real) mutable {
            done = all_done(real) ? done + 1 : 0;
            if (done < 1 || done > clocks) return;
            if (bench.edge < 0) bench.edge = next;
            bench.wires.swaplock.write(false);
        };
    };
}
/// FRAMEBAD of display 2 is high from the run's start, and SWAPSKIP by a rule of the test; `swap` is the number of edges
/// at which a swap has been due. The bench's edge is that of the first swap.
Change bad_frames(const std::function<bool(std::int64_t next, int swap)>& swapskip) {
    return [=](SwapBench& bench) {
        bench.alter = [=, &bench, swap = 0](std::int64_t next, rtl::Wires& real) mutable {
            swap += all_done(real) ? 1 : 0;
            if (swap == 1 && bench.edge < 0) bench.edge = next;
            bench.wires.framebad[1].write(true);
            bench.wires.swapskip.write(swapskip(next, swap));
        };
    };
}

/// A fault that may hold the swap lock's wires, and hardly ever does.
Scenario stalled_scenario(int renderer, std::int64_t from_cycle = 0,
                          std::optional<std::int64_t> cycles = std::nullopt) {
    return with_fault(altered_scenario(), random_stalls(renderer, 1, from_cycle, cycles));
}
constexpr int kLastRow = 1;

void swaplock_high(rtl::Wires& altered) { altered.swaplock.write(true); }
void swaplock_low(rtl::Wires& altered) { altered.swaplock.write(false); }

}  // namespace

TEST_CASE("swap lock monitor: its rules in a table", "[monitors]") {
    AlteredRuleTable<SwapBench> rules;
    rules.of(altered_scenario());
    rules.row("a run by the rules shows each frame once on each display", {}, {}, [](const auto& bench) {
        CHECK(bench.monitor.frame() == kAlteredFrames - 1);
        CHECK(bench.monitor.kept_frames() == 0);
        CHECK(bench.pictures == 2 * kAlteredFrames);
    });
    rules.row("SWAPLOCK high while a FRAMEDONE is low", {{"swap-lock/all-done", "SWAPLOCK"}},
              once(none_done, swaplock_high));
    rules.row("SWAPLOCK low though every FRAMEDONE is high", {{"swap-lock/all-done", "SWAPLOCK"}},
              once(all_done, swaplock_low));
    rules.row("SWAPSKIP without a FRAMEBAD", {{"swap-lock/any-bad", "SWAPSKIP"}},
              once(none_done, [](auto& altered) { altered.swapskip.write(true); }));
    // FRAMEDONE then rises a second time for the same swap.
    rules.row("FRAMEDONE falls without a swap",
              {{"swap-lock/framedone-fall", "FRAMEDONE_2"},
               {"swap-lock/framedone-rise", "FRAMEDONE_2", 1},
               kOthers},
              once(all_done, [](auto& altered) {
                  altered.framedone[1].write(false);
                  altered.swaplock.write(false);
              }));
    rules.row("FRAMEDONE stays high a clock too long after the swap",
              {{"swap-lock/framedone-fall", "FRAMEDONE_1", 0, 0}, kOthers}, framedone_after_fall(0));
    rules.row("FRAMEDONE rises before the swap's level has come back",
              {{"swap-lock/framedone-rise", "FRAMEDONE_1", 0, 0}, kOthers}, framedone_after_fall(1));
    rules.row("FRAMEBAD rises while FRAMEDONE is high", {{"swap-lock/framebad", "FRAMEBAD_2"}, kOthers},
              once(all_done, [](auto& altered) {
                  altered.framebad[1].write(true);
                  altered.swapskip.write(true);
              }));
    rules.row("displays out of step", {{"swap-lock/in-step", "DVI_OUT_2", 0, -1, "dvi_out"}},
              once([](auto& real) { return !real.link_out[1].read().vsync; },
                   [](auto& altered) {
                       rtl::DviLink link = altered.link_out[1].read();
                       link.vsync = true;
                       altered.link_out[1].write(link);
                   },
                   300));
    rules.row(
        "a picture changes without a swap", {{"swap-lock/picture", "DVI_OUT_1", 0, -1, "dvi_out"}, kOthers},
        [](auto& bench) {
            const LinkPosition start({kAlteredWidth, kAlteredHeight});
            bench.alter = [&bench, position = start](std::int64_t next, rtl::Wires& real) mutable {
                // Black before the first swap: one pixel of it lights up.
                rtl::DviLink link = real.link_out[0].read();
                if (!position.step(link) || bench.edge >= 0 || position.line() != 8 || position.x() != 3)
                    return;
                bench.edge = next;
                link.data = 1;
                bench.wires.link_out[0].write(link);
            };
        },
        [](const auto& bench) {
            CHECK_THAT(bench.violations.at(0).detail,
                       Catch::Contains("pixel 3,2 changes from #000000 to #000001"));
        });
    rules.row(
        "a display swaps though pixels of the frame were lost",
        {{"swap-lock/kept", "DVI_OUT_1", 0, 0, "dvi_out"}, kOthers},
        [](auto& bench) {
            bench.alter = [&bench](std::int64_t next, rtl::Wires& real) {
                // FRAMEBAD is high with FRAMEDONE of display 1, as if the machine had raised and then ignored it.
                const bool bad = real.framedone[0].read();
                bench.wires.framebad[0].write(bad);
                bench.wires.swapskip.write(bad);
                const rtl::DviLink& link = real.link_out[0].read();
                if (link.de && link.data != 0 && bench.edge < 0) bench.edge = next;
            };
        },
        [](const auto& bench) { CHECK(bench.monitor.kept_frames() == kAlteredFrames); });

    rules.of(stalled_scenario(kLastRow));
    rules.row("SWAPLOCK late while a fault of the last row may hold it", {}, late_swaplock(3),
              [](const auto& bench) {
                  CHECK(bench.edge > 0);
                  CHECK(bench.pictures == 2 * kAlteredFrames);
              });
    rules.row("SWAPLOCK is taken back while a fault may hold it", {{"swap-lock/all-done", "SWAPLOCK"}},
              once(all_done, swaplock_low));
    rules.row("SWAPLOCK early while a fault may hold it", {{"swap-lock/all-done", "SWAPLOCK"}},
              once(none_done, swaplock_high));
    rules.row("SWAPSKIP rises with SWAPLOCK while a fault may hold it", {kOthers},
              bad_frames([](std::int64_t /*next*/, int swap) { return swap > 0; }), [](const auto& bench) {
                  for (const auto& violation : bench.violations) CHECK(violation.rule != "swap-lock/any-bad");
              });
    rules.row("SWAPSKIP later than SWAPLOCK while a fault may hold it",
              {{"swap-lock/any-bad", "SWAPSKIP"}, kOthers},
              bad_frames([](std::int64_t /*next*/, int swap) { return swap > 1; }));
    rules.row("SWAPSKIP is taken back while a fault may hold it",
              {{"swap-lock/any-bad", "SWAPSKIP"}, kOthers}, [](auto& bench) {
                  bench.edge = 21;
                  bad_frames([](std::int64_t next, int /*swap*/) { return next == 20; })(bench);
              });

    rules.of(stalled_scenario(kLastRow - 1));
    rules.row("a fault of another row excuses no late SWAPLOCK",
              {{"swap-lock/all-done", "SWAPLOCK"}, kOthers}, late_swaplock(3));
    rules.of(stalled_scenario(kLastRow, 0, 10));
    rules.row("a fault that is over excuses no late SWAPLOCK", {{"swap-lock/all-done", "SWAPLOCK"}, kOthers},
              late_swaplock(1));
    rules.of(stalled_scenario(kLastRow, 1'000'000));
    rules.row("a fault that is still to come excuses no late SWAPLOCK",
              {{"swap-lock/all-done", "SWAPLOCK"}, kOthers}, late_swaplock(1));
    rules.run_and_check();
}

}  // namespace metabuffer::test::swap_lock_monitor_test
