#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "machine_run.h"
#include "monitored_machine.h"
#include "random_batches.h"
#include "random_scenario.h"
#include "scenario/derived_timing.h"
#include "support/random_seed.h"

namespace metabuffer::test::monitored_machines_test {

namespace {

using MonitoredMachines = std::vector<std::unique_ptr<MonitoredMachine>>;

std::string first_lines(const std::vector<monitors::Violation>& violations) {
    constexpr std::size_t kLines = 5;
    std::string text;
    for (std::size_t i = 0; i < std::min(kLines, violations.size()); ++i) {
        text += to_string(violations[i]) + "\n";
    }
    return text;
}

bool same(const ComposerCounters& a, const ComposerCounters& b) {
    const auto glitch = [](const std::optional<StarvedPixel>& pixel) {
        return pixel ? std::vector<int>{pixel->frame, pixel->x, pixel->y} : std::vector<int>{};
    };
    return a.renderer == b.renderer && a.display == b.display && a.starved_pixels == b.starved_pixels &&
           a.stalled_cycles == b.stalled_cycles && a.buffer_high_water == b.buffer_high_water &&
           a.busready_drops == b.busready_drops && a.late_pixels == b.late_pixels &&
           a.replayed_pixels == b.replayed_pixels && a.lost_pixels == b.lost_pixels &&
           a.lost_tables == b.lost_tables && glitch(a.first_glitch) == glitch(b.first_glitch) &&
           glitch(a.last_glitch) == glitch(b.last_glitch) && a.starved_run_count == b.starved_run_count &&
           a.starved_runs == b.starved_runs;
}

std::string text(const ComposerCounters& c) {
    return "starved " + std::to_string(c.starved_pixels) + ", stalled " + std::to_string(c.stalled_cycles) +
           ", high water " + std::to_string(c.buffer_high_water) + ", drops " +
           std::to_string(c.busready_drops) + ", late " + std::to_string(c.late_pixels) + ", replayed " +
           std::to_string(c.replayed_pixels) + ", lost " + std::to_string(c.lost_pixels) + ", runs " +
           std::to_string(c.starved_run_count);
}

/// Runs until every machine has ended, and on until its buses have sent everything, with the monitors on: the last frame
/// may be abandoned, and then it ends before its pixels are sent.
bool run_to_end(const MonitoredMachines& monitored) {
    std::vector<rtl::Metabuffer*> machines;
    for (const auto& machine : monitored) machines.push_back(&machine->machine());
    return test::run_to_end(machines);
}

void check_counters(const MonitoredMachine& machine) {
    const RunReport report = machine.machine().report();
    std::int64_t drop = rtl::Composer::kNever;
    std::int64_t starved = rtl::Composer::kNever;
    const auto earlier = [](std::int64_t a, std::int64_t b) {
        return a < 0 || b < 0 ? std::max(a, b) : std::min(a, b);
    };
    for (std::size_t i = 0; i < report.composers.size(); ++i) {
        const monitors::ComposerObserver& observer = machine.monitors().composer(i).observer();
        INFO("composer " << i << " counts " << text(report.composers[i]));
        INFO("its monitor counts " << text(observer.counters()));
        CHECK(same(report.composers[i], observer.counters()));
        drop = earlier(drop, observer.first_busready_drop_cycle());
        starved = earlier(starved, observer.first_starved_cycle());
    }
    CHECK(drop == machine.machine().first_busready_drop().cycle);
    CHECK(starved == machine.machine().first_starved().cycle);
    for (std::size_t r = 0; r < machine.renderers(); ++r) {
        // What is on its way when a reset begins does not come: the monitors have checked how much that may be.
        const std::vector<Fault>& faults = machine.scenario().faults;
        if (std::any_of(faults.begin(), faults.end(),
                        [](const Fault& fault) { return fault.kind == FaultKind::kReset; })) {
            CHECK(machine.monitors().bus(r).bursts() <= report.renderers[r].bus.bursts);
            CHECK(machine.monitors().bus(r).pixels_sent() <= report.renderers[r].bus.pixels_sent);
            continue;
        }
        CHECK(machine.monitors().bus(r).bursts() == report.renderers[r].bus.bursts);
        CHECK(machine.monitors().bus(r).pixels_sent() == report.renderers[r].bus.pixels_sent);
    }
    // Of a frame: the first composer of any column to start, the last of any to end.
    for (const FrameRecord& frame : report.frames) {
        std::int64_t start = -1;
        std::int64_t end = -1;
        for (std::size_t i = 0; i < report.composers.size(); ++i) {
            const auto& span = machine.monitors().composer(i).observer().frame_spans().at(
                static_cast<std::size_t>(frame.index));
            start = i < machine.displays() ? earlier(start, span.start_cycle) : start;
            end = std::max(end, span.end_cycle);
        }
        CHECK(start == frame.start_cycle);
        CHECK(end == frame.end_cycle);
    }
    for (std::size_t d = 0; d < machine.displays(); ++d) {
        CHECK(machine.monitors().pipeline(d).frames_taken() >= report.displays[d].frames_shown);
    }
}

void run_and_check(const std::vector<std::uint64_t>& seeds, Scenario (*make)(std::uint64_t)) {
    MonitoredMachines machines;
    for (const std::uint64_t seed : seeds) {
        machines.push_back(std::make_unique<MonitoredMachine>("machine_" + std::to_string(seed), make(seed)));
    }
    const bool ended = run_to_end(machines);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        INFO("METABUFFER_SEED=" << seeds[i] << " replays this machine alone");
        INFO(describe(machines[i]->scenario()));
        INFO(first_lines(machines[i]->violations()));
        CHECK((ended || machines[i]->machine().finished()));
        CHECK(machines[i]->violations().empty());
        check_counters(*machines[i]);
    }
}

/// A random machine, some of whose handshakes are held low for a while and some of whose beats are lost.
Scenario random_faulty_scenario(std::uint64_t seed) {
    Scenario scenario = random_level_scenario(seed);
    Random random(seed);
    const int faults = random.between(1, 4);
    for (int i = 0; i < faults; ++i) {
        constexpr FaultKind kKinds[] = {FaultKind::kBusreadyLow, FaultKind::kPipereadyLow,
                                        FaultKind::kLostBeat, FaultKind::kRandomStalls};
        Fault fault;
        fault.kind = kKinds[random.between(0, 3)];
        fault.renderer = random.between(0, static_cast<int>(scenario.renderers.size()) - 1);
        fault.display = random.between(1, scenario.displays.count());
        fault.from_cycle = random.between(0, 4000);
        fault.cycles = random.between(1, 2000);
        fault.beats = random.between(1, 5);
        fault.percent = random.between(1, 90);
        fault.seed = random.bits();
        fault.of = static_cast<LostBeats>(random.between(0, static_cast<int>(LostBeats::kAny)));
        scenario.faults.push_back(fault);
    }
    for (int resets = random.one_in(3) ? random.between(1, 3) : 0; resets > 0; --resets) {
        Fault reset;
        reset.kind = FaultKind::kReset;
        reset.from_cycle = random.between(0, 6000);
        reset.cycles = least_reset_cycles(scenario.clocks) + random.between(0, 20);
        scenario.faults.push_back(reset);
    }
    return scenario;
}

const bool kRandom = register_random_batches(
    "random machines break no rule", [](const auto& seeds) { run_and_check(seeds, random_scenario); });
const bool kRandomLong = register_random_batches("long random machines break no rule", [](const auto& seeds) {
    run_and_check(seeds, random_long_scenario);
});
const bool kRandomFaulty =
    register_random_batches("random machines with faults inside break no rule",
                            [](const auto& seeds) { run_and_check(seeds, random_faulty_scenario); });

}  // namespace

TEST_CASE("random machines are registered", "[monitors]") {
    CHECK((kRandom && kRandomLong && kRandomFaulty));
}

}  // namespace metabuffer::test::monitored_machines_test
