#include "tools/program/tlm_simulation.h"

#include <stdexcept>
#include <utility>

#include "tlm/run.h"
#include "tools/program/failure.h"

namespace metabuffer {

exploration::Simulation simulate_by_transactions(const Scenario& scenario, bool pictures) {
    exploration::Simulation simulation;
    tlm::RunOptions options;
    options.images = pictures;
    if (pictures) {
        simulation.pictures.resize(static_cast<std::size_t>(scenario.displays.count()));
        options.on_frame_shown = [&simulation](int /*frame*/, int display, const ColourImage& image) {
            simulation.pictures[static_cast<std::size_t>(display) - 1] = image;
        };
    }
    try {
        simulation.report = tlm::run(scenario, options).report;
    } catch (const InputError&) {
        throw;
    } catch (...) {
        throw std::runtime_error(current_failure().message);
    }
    return simulation;
}

}  // namespace metabuffer
