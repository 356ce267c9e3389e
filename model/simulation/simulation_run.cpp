#include "simulation/simulation_run.h"

#include <set>

namespace metabuffer {

namespace {

void throw_image_failure(const Scenario& scenario) {
    for (const Renderer& renderer : scenario.renderers) {
        for (const auto& image : renderer.images) {
            if (const std::exception_ptr failure = image->failure()) std::rethrow_exception(failure);
        }
    }
}

}  // namespace

void advance_kernel(const Scenario& scenario, const sc_core::sc_time& time) {
    try {
        sc_core::sc_start(time);
    } catch (...) {
        throw_image_failure(scenario);
        throw;
    }
}

SimulationRun::Seconds SimulationRun::time_of_reading_images() const {
    std::set<const StoredImage*> images;
    Seconds time{};
    for (const Renderer& renderer : scenario_.renderers) {
        for (const auto& image : renderer.images) {
            if (images.insert(image.get()).second) time += image->reading_time();
        }
    }
    return time;
}

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
    advance_kernel(scenario_, time);
    in_kernel_ += Clock::now() - entered_;
    if (error_) {
        std::rethrow_exception(error_);
    }
}

}  // namespace metabuffer
