#include "starvation_run.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "host/child_process.h"
#include "tlm/run.h"

namespace metabuffer::test {
namespace {

Starvation starvation_of(const RunReport& report) {
    Starvation result;
    std::int64_t most = 0;
    for (const ComposerCounters& composer : report.composers) {
        result.starved_pixels += composer.starved_pixels;
        result.late_pixels += composer.late_pixels;
        result.high_water_pixels = std::max(result.high_water_pixels, composer.buffer_high_water);
        if (composer.starved_pixels > most) {
            most = composer.starved_pixels;
            result.most_starved_renderer = composer.renderer;
            result.most_starved_display = composer.display;
        }
    }
    for (const RendererCounters& renderer : report.renderers) {
        result.rejected_for_buffer += renderer.rejected_rows[static_cast<std::size_t>(RowDefect::kBuffer)];
    }
    result.bus = report.total_bus();
    result.watchdog_lines = static_cast<std::int64_t>(report.watchdog.size());
    return result;
}

}  // namespace

Starvation run_with_buffer(const Scenario& scenario, int buffer_pixels) {
    ChildProcess process([&scenario, buffer_pixels](const ChildProcess::Sender& sender) {
        Scenario sized = scenario;
        sized.composer.buffer_pixels = buffer_pixels;
        sized.composer.on_starvation = StarvationMode::kGlitch;
        tlm::RunOptions options;
        options.images = false;
        const Starvation result = starvation_of(tlm::run(sized, options).report);
        sender.send(&result, sizeof result);
    });
    std::string bytes;
    while (!process.ended()) process.receive(bytes);
    Starvation result;
    if (!process.complaint().empty() || bytes.size() != sizeof result) {
        throw std::runtime_error(scenario.name + ": the run with " + std::to_string(buffer_pixels) +
                                 " pixels a composer failed: " + process.complaint());
    }
    std::memcpy(&result, bytes.data(), sizeof result);
    return result;
}

}  // namespace metabuffer::test
