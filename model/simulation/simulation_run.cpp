#include "simulation/simulation_run.h"

namespace metabuffer {

void SimulationRun::frame_shown(const DisplayedFrame& displayed) {
    in_kernel_ += Clock::now() - entered_;
    if (on_frame_shown_ && !error_) {
        try {
            on_frame_shown_(displayed);
        } catch (...) {
            error_ = std::current_exception();
            sc_core::sc_pause();
        }
    }
    entered_ = Clock::now();
}

void SimulationRun::advance(const sc_core::sc_time& time) {
    entered_ = Clock::now();
    sc_core::sc_start(time);
    in_kernel_ += Clock::now() - entered_;
    if (error_) {
        std::rethrow_exception(error_);
    }
}

}  // namespace metabuffer
