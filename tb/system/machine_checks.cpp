#include "machine_checks.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <set>

#include "datapath/arbitration/arbitration_table.h"
#include "functional/functional_compositor.h"
#include "monitors/reference_composition.h"
#include "naive_pipeline.h"
#include "scenario/derived_timing.h"

namespace metabuffer::test {
namespace {

bool lockstep(const Scenario& scenario) { return scenario.pacing == Pacing::kLockstep; }
bool glitches(const Scenario& scenario) { return scenario.composer.on_starvation == StarvationMode::kGlitch; }
bool has_fault(const Scenario& scenario, FaultKind kind) {
    return std::any_of(scenario.faults.begin(), scenario.faults.end(),
                       [kind](const Fault& fault) { return fault.kind == kind; });
}
bool has_delay(const Scenario& scenario) { return has_fault(scenario, FaultKind::kDelay); }
/// Whether a fault may raise STALL in any clock of the run, although no composer needs it.
bool stalls_at_random(const Scenario& scenario) {
    return !glitches(scenario) && has_fault(scenario, FaultKind::kRandomStalls);
}

/// Every display shows every frame once and whole: what the reported pairs give, without the local pixels that the
/// machine located as starved. If none was, that is what the functional level makes of those pairs.
void check_pictures(const MachineRun& run) {
    const Scenario& scenario = run.scenario();
    const bool starved = run.report().total_starved_pixels() > 0;
    for (int frame = 0; frame < scenario.frames; ++frame) {
        const auto contributions = functional::contributions_of(
            scenario, run.report().frames.at(static_cast<std::size_t>(frame)).pairs);
        for (int display = 1; display <= scenario.displays.count(); ++display) {
            INFO("frame " << frame << " on display " << display);
            CHECK(run.times_shown(frame, display) == 1);
            const ColourImage* shown = run.picture(frame, display);
            CHECK(differing_pixels(shown, picture_without_glitches(run, frame, display)) == 0);
            if (!starved) {
                CHECK(differing_pixels(shown,
                                       functional::composite_display(scenario, contributions, display)) == 0);
            }
        }
    }
}

/// Source lines of an axis that no raster line is mixed of.
int unneeded_lines(int destination, int count, int multiple, int raster) {
    std::set<int> needed;
    for (int position = std::max(destination, 0); position < std::min(raster, destination + count * multiple);
         ++position) {
        const monitors::ReferenceLines lines =
            monitors::reference_lines(position - destination, count, multiple);
        needed.insert(lines.own);
        needed.insert(lines.other);
    }
    return count - static_cast<int>(needed.size());
}

/// Pixels that a composer was sent and that no raster pixel needs: of aprons that lie too far beside the raster.
std::int64_t unneeded_pixels(const MachineRun& run, const ComposerCounters& composer) {
    const Scenario& scenario = run.scenario();
    if (scenario.composer.smoothing == Smoothing::kReplicate) return 0;
    std::int64_t pixels = 0;
    for (const FrameRecord& frame : run.report().frames) {
        const auto contributions = functional::contributions_of(scenario, frame.pairs);
        for (const ViewportRow& row : contributions[static_cast<std::size_t>(composer.renderer) - 1].rows) {
            if (row.dcomp != composer.display) continue;
            const int columns =
                unneeded_lines(row.dx, row.sdx, row.dmultiple, scenario.displays.raster_width_pixels());
            const int lines =
                unneeded_lines(row.dy, row.sdy, row.dmultiple, scenario.displays.raster_height_pixels());
            pixels += std::int64_t{row.sdx} * row.sdy - std::int64_t{row.sdx - columns} * (row.sdy - lines);
        }
    }
    return pixels;
}

/// The same, over the composers of a renderer (from 0).
std::int64_t unneeded_pixels_of(const MachineRun& run, std::size_t renderer) {
    std::int64_t pixels = 0;
    for (const ComposerCounters& composer : run.report().composers) {
        if (composer.renderer == static_cast<int>(renderer) + 1) pixels += unneeded_pixels(run, composer);
    }
    return pixels;
}

/// Each starved pixel is counted and located once; `stall` mode has none, `glitch` mode never stalls.
void check_starvation(const MachineRun& run) {
    CHECK_FALSE(run.starved_pixels_malformed());
    for (const ComposerCounters& composer : run.report().composers) {
        INFO("composer " << composer.renderer << "_" << composer.display);
        CHECK(composer.starved_pixels == run.starved_pixels_located(composer.renderer, composer.display));
        CHECK(composer.first_glitch.has_value() == (composer.starved_pixels > 0));
        if (composer.first_glitch) {
            CHECK(run.has_starved_pixel(composer.renderer, composer.display, *composer.first_glitch));
        }
        if (glitches(run.scenario())) {
            CHECK(composer.stalled_cycles == 0);
        } else {
            CHECK(composer.starved_pixels == 0);
            CHECK(composer.late_pixels <= unneeded_pixels(run, composer));
        }
        CHECK(composer.buffer_high_water <= run.scenario().composer.buffer_pixels);
    }
}

/// A column stands still in each clock in which at least one of its composers, or a fault, makes it wait.
void check_column_stalls(const MachineRun& run) {
    const RunReport& report = run.report();
    for (std::size_t d = 0; d < report.displays.size(); ++d) {
        INFO("display " << d + 1);
        std::int64_t most = 0;
        std::int64_t sum = 0;
        for (const ComposerCounters& composer : report.composers) {
            if (composer.display != static_cast<int>(d) + 1) continue;
            most = std::max(most, composer.stalled_cycles);
            sum += composer.stalled_cycles;
        }
        CHECK(report.displays[d].stalled_cycles >= most);
        CHECK((report.displays[d].stalled_cycles <= sum || stalls_at_random(run.scenario())));
    }
}

/// Which pair a frame shows. In lockstep: pair k, or the last good one before it; with a silent link at least never a
/// later one. Always: never an earlier pair than the frame before, and what is shown again is counted.
void check_pairs(const MachineRun& run) {
    const Scenario& scenario = run.scenario();
    const RunReport& report = run.report();
    const auto without_time = functional::pairs_without_time(scenario);
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        INFO("renderer " << r + 1);
        int previous = -1;
        std::int64_t repeated = 0;
        for (std::size_t k = 0; k < report.frames.size(); ++k) {
            INFO("frame " << k);
            const int pair = report.frames[k].pairs.at(r);
            CHECK(report.frames[k].index == static_cast<int>(k));
            CHECK(pair >= previous);
            repeated += pair == previous ? 1 : 0;
            if (lockstep(scenario)) {
                CHECK(pair <= static_cast<int>(k));
                if (!has_delay(scenario)) {
                    CHECK(pair == without_time[k][r]);
                }
            }
            previous = pair;
        }
        CHECK(report.renderers[r].repeated_frames == repeated);
    }
}

/// What the bus must carry for the frames composited: all of each segment.
std::int64_t segment_pixels(const MachineRun& run, std::size_t renderer) {
    std::int64_t pixels = 0;
    for (const FrameRecord& frame : run.report().frames) {
        const auto contributions = functional::contributions_of(run.scenario(), frame.pairs);
        for (const ViewportRow& row : contributions[renderer].rows) {
            pixels += std::int64_t{row.sdx} * row.sdy;
        }
    }
    return pixels;
}

std::int64_t cycles_accounted_for(const BusCounters& bus) {
    return bus.busy_cycles + bus.table_cycles + bus.page_miss_cycles + bus.refresh_cycles + bus.write_cycles +
           bus.grant_cycles + bus.poll_cycles + bus.lost_cycles + bus.idle_cycles;
}

/// Every core clock of a bus is accounted for, no pixel is lost or sent twice, and none faster than bus and
/// memory allow.
void check_buses(const MachineRun& run) {
    const Scenario& scenario = run.scenario();
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        INFO("renderer " << r + 1);
        CHECK(cycles_accounted_for(run.report().renderers[r].bus) == run.report().core_cycles);
        const BusCounters& bus = run.drained_report().renderers[r].bus;
        CHECK(bus.pixels_sent == segment_pixels(run, r));
        if (!glitches(scenario)) {
            // Nobody waits for what no raster pixel needs.
            CHECK(run.report().renderers[r].bus.pixels_sent + unneeded_pixels_of(run, r) >= bus.pixels_sent);
        }
        CHECK(bus.busy_cycles * pixels_per_beat(scenario.bus, scenario.memory) >=
              bus.pixels_sent * cycles_per_beat(scenario.bus));
        CHECK(bus.page_miss_cycles <= bus.page_misses * scenario.memory.page_miss_cycles);
        if (loses_slots(scenario.bus.arbitration)) {
            CHECK(bus.recovered_slots == 0);
        } else {
            CHECK(bus.lost_cycles == 0);
        }
    }
}

/// One raster pixel enters a pipeline a clock, and each composer works a clock after the one above it. With one column
/// a frame takes raster pixels + M - 1 clocks and those of its stalls; several columns start apart.
void check_frame_spans(const MachineRun& run) {
    const Scenario& scenario = run.scenario();
    const std::int64_t undisturbed =
        std::int64_t{scenario.displays.raster_width_pixels()} * scenario.displays.raster_height_pixels() +
        static_cast<std::int64_t>(scenario.renderers.size()) - 1;
    std::int64_t sum = 0;
    std::int64_t previous_end = -1;
    for (const FrameRecord& frame : run.report().frames) {
        INFO("frame " << frame.index);
        const std::int64_t startframe = run.machine().startframe(frame.index).cycle;
        CHECK(startframe < frame.start_cycle);
        const std::int64_t clocks = frame.end_cycle - frame.start_cycle + 1;
        CHECK(clocks >= undisturbed);
        CHECK(frame.start_cycle > previous_end);
        if (scenario.displays.count() == 1 && glitches(scenario)) {
            CHECK(clocks == undisturbed);
        }
        if (frame.latency_cycles) {
            CHECK(*frame.latency_cycles >= undisturbed);
        }
        previous_end = frame.end_cycle;
        // The first pixel follows its STARTFRAME, unless the column stalls there: a smoothed pixel may need more than
        // what a full buffer holds.
        sum += frame.end_cycle - startframe;
    }
    if (scenario.displays.count() == 1) {
        const std::int64_t stalled = sum - undisturbed * scenario.frames;
        CHECK(stalled <= run.report().displays[0].stalled_cycles);
        // A fault makes the column stand still between the frames too.
        CHECK((stalled == run.report().displays[0].stalled_cycles || stalls_at_random(scenario)));
    }
}

/// A frame begins after the swap to the one before. From one swap to the next the displays show a whole number of their
/// frames. No rate is more than displays, links and raster allow.
void check_rates(const MachineRun& run) {
    const Scenario& scenario = run.scenario();
    const DisplayConfig& displays = scenario.displays;
    const auto core_period = static_cast<double>(clock_period_picoseconds(scenario.clocks.core_mhz));
    // Blanking is 80 clocks a line and 15 lines a frame.
    const double refresh = static_cast<double>(clock_period_picoseconds(scenario.clocks.dvi_out_mhz)) *
                           (displays.width_pixels + 80) * (displays.height_pixels + 15);
    const FrameRecord* previous = nullptr;
    for (const FrameRecord& frame : run.report().frames) {
        INFO("frame " << frame.index);
        CHECK(frame.swap_cycle >= frame.end_cycle);
        if (previous != nullptr) {
            CHECK(frame.start_cycle > previous->swap_cycle);
            const double refreshes =
                static_cast<double>(frame.swap_cycle - previous->swap_cycle) * core_period / refresh;
            CHECK(std::abs(refreshes - std::max(1.0, std::round(refreshes))) * refresh <= core_period);
        }
        previous = &frame;
    }
    const FrameRates rates = run.report().frame_rates();
    CHECK(rates.composition_hz.has_value() == (scenario.frames >= 2));
    CHECK(rates.held_hz().has_value() == (scenario.frames >= 3));
    const double second = 1.000001e12;  // rounding
    CHECK(rates.composition_hz.value_or(0.0) <= second / refresh);
    CHECK(rates.composition_hz.value_or(0.0) <=
          second / core_period / displays.raster_width_pixels() / displays.raster_height_pixels());
    CHECK(rates.display_hz.value_or(0.0) <= second / refresh);
    CHECK(rates.held_hz().value_or(0.0) <= rates.display_hz.value_or(0.0));
    double links = 0.0;
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        const Renderer& renderer = scenario.renderers[r];
        const double pair = static_cast<double>(shortest_link_period_picoseconds(scenario, r)) * 2.0 *
                            (renderer.image_width_pixels + 80) * (renderer.image_height_pixels + 16);
        links += second / pair;
        if (lockstep(scenario)) CHECK(rates.composition_hz.value_or(0.0) <= second / pair);
    }
    CHECK(rates.display_hz.value_or(0.0) <= links);
}

/// Lockstep without faults: each pair is taken once, so its table is judged once.
void check_rejections(const MachineRun& run) {
    const Scenario& scenario = run.scenario();
    if (!scenario.faults.empty()) {
        return;
    }
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        INFO("renderer " << r + 1);
        const RendererCounters& counters = run.report().renderers[r];
        CHECK(std::accumulate(counters.rejected_frames.begin(), counters.rejected_frames.end(),
                              std::int64_t{0}) == 0);
        if (!lockstep(scenario)) {
            continue;
        }
        CHECK(counters.repeated_frames == 0);
        CHECK(counters.dropped_frames == 0);
        const Renderer& renderer = scenario.renderers[r];
        std::array<std::int64_t, kRowDefectCount> expected{};
        for (int pair = 0; pair < scenario.frames; ++pair) {
            const ViewportTable& table = renderer.frame_of_pair(static_cast<std::uint32_t>(pair)).table;
            for (const RejectedRow& row : validate_table(table, scenario.limits(renderer)).rejected) {
                ++expected[static_cast<std::size_t>(row.defect)];
            }
        }
        CHECK(counters.rejected_rows == expected);
    }
}

}  // namespace

void check_run(const MachineRun& run) {
    CHECK(run.machine().watchdog_findings().empty());
    REQUIRE(run.report().frames.size() == static_cast<std::size_t>(run.scenario().frames));
    for (const DisplayCounters& display : run.report().displays) {
        CHECK(display.frames_shown == run.scenario().frames);
    }
    check_pairs(run);
    check_pictures(run);
    check_starvation(run);
    check_column_stalls(run);
    check_buses(run);
    check_frame_spans(run);
    check_rates(run);
    check_rejections(run);
}

}  // namespace metabuffer::test
