#include "tlm/run.h"

#include <chrono>
#include <exception>

#include "tlm/metabuffer.h"

namespace metabuffer::tlm {
namespace {

class Stopwatch {
  public:
    void start() { started_ = Clock::now(); }
    void stop() { total_ += Clock::now() - started_; }
    double seconds() const { return std::chrono::duration<double>(total_).count(); }

  private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point started_;
    Clock::duration total_{};
};

}  // namespace

RunResult run(const Scenario& scenario, const RunOptions& options) {
    /// Between two looks at the machine from outside: most frames take longer.
    constexpr std::int64_t kChunkCycles = 2'000'000;

    Metabuffer::Options machine_options;
    machine_options.images = options.images;
    machine_options.observer = options.observer;
    Metabuffer machine("metabuffer", scenario, machine_options);
    Stopwatch stopwatch;
    std::exception_ptr callback_error;
    machine.on_frame_shown([&](int frame, int display, const ColourImage& image) {
        stopwatch.stop();
        if (options.on_frame_shown && !callback_error) {
            // The kernel would wrap what is thrown through it: it waits outside.
            try {
                options.on_frame_shown(frame, display, image);
            } catch (...) {
                callback_error = std::current_exception();
                sc_core::sc_pause();
            }
        }
        stopwatch.start();
    });
    machine.on_finished([] { sc_core::sc_pause(); });
    const std::int64_t chunk_picoseconds = kChunkCycles * clock_period_picoseconds(scenario.clocks.core_mhz);
    const auto chunk = sc_core::sc_time::from_value(static_cast<sc_dt::uint64>(chunk_picoseconds));
    // Elaboration is start-up, not simulation.
    sc_core::sc_start(sc_core::SC_ZERO_TIME);
    while (!machine.finished()) {
        stopwatch.start();
        sc_core::sc_start(chunk);
        stopwatch.stop();
        if (callback_error) {
            std::rethrow_exception(callback_error);
        }
        if (options.on_progress) {
            options.on_progress(machine.core_cycle(),
                                static_cast<double>(machine.raster_pixels_taken()) /
                                    static_cast<double>(machine.raster_pixels_to_take()));
        }
    }
    return {machine.report(), stopwatch.seconds()};
}

}  // namespace metabuffer::tlm
