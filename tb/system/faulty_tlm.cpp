#include <cstdlib>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <systemc>
#include <utility>

#include "host/errors.h"
#include "rtl/run.h"
#include "tlm/run.h"

// Replaces level tlm in a separate program, so that `metabuffer compare` has something to find: level rtl under another
// name. The scenario's name says what is wrong with it.

namespace metabuffer::tlm {
namespace {

/// Nothing if the picture is not to be shown.
std::optional<ColourImage> corrupt(const std::string& fault, int frame, int display, ColourImage image) {
    if (fault == "picture" && frame == 1 && display == 2) {
        image.at(12, 5) ^= 0x00'0001U;
        image.at(3, 6) ^= 0xFF'0000U;
    }
    if (fault == "memory") throw std::bad_alloc();  // in a process of SystemC's
    if (fault == "lost picture" && frame == 0 && display == 1) return std::nullopt;
    if (fault == "all pictures") image.values.back() ^= 1U;
    return image;
}

void corrupt(const std::string& fault, RunReport& report) {
    if (fault == "counter") ++report.composers.at(2).late_pixels;
    if (fault == "watchdog") report.watchdog = {"composer_1_1 waits for a pixel"};
}

}  // namespace

WindowSearch find_event(const Scenario& scenario, const TraceWindow& window) {
    WindowSearch search = rtl::find_event(scenario, window);
    if (scenario.name == "window" && search.event) ++search.event->start.cycle;
    return search;
}

RunResult run(const Scenario& scenario, const RunOptions& options) {
    const std::string& fault = scenario.name;
    if (fault == "error") SC_REPORT_ERROR("metabuffer/test", "told to fail");
    if (fault == "crash") std::abort();
    if (fault == "exit") std::_Exit(EXIT_SUCCESS);
    if (fault == "input") throw InputError("told to refuse");
    if (fault == "exception") throw std::runtime_error("told to throw");
    rtl::RunOptions rtl_options;
    if (options.images) {
        rtl_options.on_frame_shown = [&](const DisplayedFrame& displayed) {
            const auto shown = corrupt(fault, displayed.frame, displayed.display, displayed.picture);
            if (!shown) return;
            options.on_frame_shown({displayed.frame, displayed.display, *shown, displayed.pairs,
                                    displayed.starved_pixels, displayed.kept});
        };
    }
    rtl::RunResult rtl = rtl::run(scenario, rtl_options);
    corrupt(fault, rtl.report);
    rtl.report.level = "tlm";
    if (fault == "late crash") std::abort();
    return {std::move(rtl.report), rtl.simulation_seconds};
}

}  // namespace metabuffer::tlm
