#pragma once

#include <chrono>
#include <exception>
#include <systemc>
#include <utility>

#include "simulation/frame_shown.h"

namespace metabuffer {

/// Runs the kernel for a level that has time: measures its time without the host's callback, and brings an exception of
/// that callback out of the kernel, which would wrap it.
class SimulationRun {
  public:
    /// on_frame_shown: the host's; may be empty, may throw.
    explicit SimulationRun(FrameShown on_frame_shown) : on_frame_shown_(std::move(on_frame_shown)) {}

    /// The machine calls it within the kernel. After the first exception the host's callback is no longer called.
    void frame_shown(const DisplayedFrame& displayed);
    /// Lets that much time pass, or less if the machine pauses. Throws what the callback has thrown.
    void advance(const sc_core::sc_time& time);
    /// Wall time in the kernel so far.
    double seconds() const { return std::chrono::duration<double>(in_kernel_).count(); }

  private:
    using Clock = std::chrono::steady_clock;

    FrameShown on_frame_shown_;
    std::exception_ptr error_;
    Clock::time_point entered_;
    Clock::duration in_kernel_{};
};

}  // namespace metabuffer
