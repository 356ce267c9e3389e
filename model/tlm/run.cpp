#include "tlm/run.h"

#include "simulation/simulation_run.h"
#include "tlm/metabuffer.h"

namespace metabuffer::tlm {
namespace {

/// Clocks between two checks of the machine from outside; most frames take longer.
constexpr std::int64_t kChunkCycles = 2'000'000;

sc_core::sc_time chunk_of(const Scenario& scenario) {
    const std::int64_t picoseconds = kChunkCycles * clock_period_picoseconds(scenario.clocks.core_mhz);
    return sc_core::sc_time::from_value(static_cast<sc_dt::uint64>(picoseconds));
}

}  // namespace

WindowSearch find_event(const Scenario& scenario, const TraceWindow& window) {
    return scout([&scenario, &window] {
        Metabuffer::Options options;
        options.images = false;
        Metabuffer machine("metabuffer", scenario, options);
        machine.on_finished([] { sc_core::sc_pause(); });
        WindowSearch search;
        while (!(search.event = event_of(window, machine)) && !machine.finished()) {
            advance_kernel(scenario, chunk_of(scenario));
        }
        search.whole_run = machine.finished() && machine.report().watchdog.empty();
        return search;
    });
}

RunResult run(const Scenario& scenario, const RunOptions& options) {
    Metabuffer::Options machine_options;
    machine_options.images = options.images;
    machine_options.observer = options.observer;
    Metabuffer machine("metabuffer", scenario, machine_options);
    SimulationRun simulation(scenario, options.on_frame_shown);
    machine.on_frame_shown(
        [&simulation](const DisplayedFrame& displayed) { simulation.frame_shown(displayed); });
    machine.on_finished([] { sc_core::sc_pause(); });
    const sc_core::sc_time chunk = chunk_of(scenario);
    // Elaboration is start-up, not simulation.
    advance_kernel(scenario, sc_core::SC_ZERO_TIME);
    while (!machine.finished()) {
        simulation.advance(chunk);
        if (options.on_progress) {
            options.on_progress(machine.core_cycle(),
                                static_cast<double>(machine.raster_pixels_taken()) /
                                    static_cast<double>(machine.raster_pixels_to_take()));
        }
    }
    return {machine.report(), simulation.seconds()};
}

}  // namespace metabuffer::tlm
