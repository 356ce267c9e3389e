#pragma once

#include <chrono>
#include <exception>
#include <systemc>
#include <utility>

#include "scenario/scenario.h"
#include "simulation/frame_shown.h"

namespace metabuffer {

/// Lets that much time pass, or less if the machine pauses. If an image cannot be read meanwhile, throws what its reader
/// has thrown, not the kernel's wrapping of it.
void advance_kernel(const Scenario& scenario, const sc_core::sc_time& time);

/// Runs the kernel for a level that has time. Measures the kernel's time, without the host's callback and without the
/// reading of images. An exception of the callback reaches the caller unwrapped.
class SimulationRun {
  public:
    /// on_frame_shown: the host's; may be empty, may throw. The scenario must outlive it.
    SimulationRun(const Scenario& scenario, FrameShown on_frame_shown)
        : scenario_(scenario),
          on_frame_shown_(std::move(on_frame_shown)),
          read_before_(time_of_reading_images()) {}

    /// The machine calls it within the kernel. After the first exception the host's callback is no longer called.
    void frame_shown(const DisplayedFrame& displayed);
    /// As advance_kernel(). Throws also what the callback has thrown.
    void advance(const sc_core::sc_time& time);
    /// Wall time in the kernel so far.
    double seconds() const { return (in_kernel_ - (time_of_reading_images() - read_before_)).count(); }

  private:
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;

    Seconds time_of_reading_images() const;

    const Scenario& scenario_;
    FrameShown on_frame_shown_;
    std::exception_ptr error_;
    Clock::time_point entered_;
    Seconds read_before_;
    Seconds in_kernel_{};
};

}  // namespace metabuffer
