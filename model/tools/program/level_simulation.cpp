#include "tools/program/level_simulation.h"

#include <stdexcept>
#include <utility>

#include "rtl/run.h"
#include "tlm/run.h"
#include "tools/program/failure.h"
#include "tools/program/wrong_pixel_record.h"

namespace metabuffer {
namespace {

using exploration::Simulation;

/// Runs a level with its own options; `run` is the level's function.
template <typename Options, typename Run>
Simulation simulate(const Scenario& scenario, Options options, bool pictures, Run run) {
    Simulation simulation;
    WrongPixelRecord wrong_pixels(scenario);
    if (pictures) {
        simulation.pictures.resize(static_cast<std::size_t>(scenario.displays.count()));
        options.on_frame_shown = [&](const DisplayedFrame& displayed) {
            simulation.pictures[static_cast<std::size_t>(displayed.display) - 1] = displayed.picture;
            wrong_pixels.take(displayed);
        };
    }
    try {
        simulation.report = run(scenario, options).report;
        if (pictures) wrong_pixels.put_into(simulation.report);
    } catch (const InputError&) {
        throw;
    } catch (...) {
        throw std::runtime_error(current_failure().message);
    }
    return simulation;
}

}  // namespace

exploration::Simulate simulation_at(TimedLevel level) {
    if (level == TimedLevel::kRtl) {
        return [](const Scenario& scenario, bool pictures) {
            return simulate(scenario, rtl::RunOptions{}, pictures, rtl::run);
        };
    }
    return [](const Scenario& scenario, bool pictures) {
        tlm::RunOptions options;
        options.images = pictures;
        return simulate(scenario, options, pictures, tlm::run);
    };
}

}  // namespace metabuffer
