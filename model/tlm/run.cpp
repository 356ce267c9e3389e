#include "tlm/run.h"

#include "simulation/simulation_run.h"
#include "tlm/metabuffer.h"

namespace metabuffer::tlm {

RunResult run(const Scenario& scenario, const RunOptions& options) {
    /// Between two looks at the machine from outside: most frames take longer.
    constexpr std::int64_t kChunkCycles = 2'000'000;

    Metabuffer::Options machine_options;
    machine_options.images = options.images;
    machine_options.observer = options.observer;
    Metabuffer machine("metabuffer", scenario, machine_options);
    SimulationRun simulation(options.on_frame_shown);
    machine.on_frame_shown(
        [&simulation](const DisplayedFrame& displayed) { simulation.frame_shown(displayed); });
    machine.on_finished([] { sc_core::sc_pause(); });
    const std::int64_t chunk_picoseconds = kChunkCycles * clock_period_picoseconds(scenario.clocks.core_mhz);
    const auto chunk = sc_core::sc_time::from_value(static_cast<sc_dt::uint64>(chunk_picoseconds));
    // Elaboration is start-up, not simulation.
    sc_core::sc_start(sc_core::SC_ZERO_TIME);
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
