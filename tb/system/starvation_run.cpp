#include "starvation_run.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

#include "scenario/quiet_fork.h"
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

[[noreturn]] void run_in_child(Scenario scenario, int buffer_pixels, int descriptor) {
    try {
        scenario.composer.buffer_pixels = buffer_pixels;
        scenario.composer.on_starvation = StarvationMode::kGlitch;
        tlm::RunOptions options;
        options.images = false;
        const Starvation result = starvation_of(tlm::run(scenario, options).report);
        if (write(descriptor, &result, sizeof result) == static_cast<ssize_t>(sizeof result)) {
            _exit(EXIT_SUCCESS);
        }
    } catch (const std::exception& error) {
        std::cerr << scenario.name << ": " << error.what() << std::endl;
    }
    _exit(EXIT_FAILURE);
}

}  // namespace

Starvation run_with_buffer(const Scenario& scenario, int buffer_pixels) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe for a run");
    // Or both processes would print what is still in there.
    std::cout.flush();
    std::fflush(nullptr);
    const pid_t child = quiet_fork();
    if (child == 0) {
        close(ends[0]);
        run_in_child(scenario, buffer_pixels, ends[1]);
    }
    close(ends[1]);
    Starvation result;
    const ssize_t got = child > 0 ? read(ends[0], &result, sizeof result) : -1;
    close(ends[0]);
    int status = 0;
    while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (got != static_cast<ssize_t>(sizeof result) || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        throw std::runtime_error(scenario.name + ": the run with " + std::to_string(buffer_pixels) +
                                 " pixels a composer failed");
    }
    return result;
}

}  // namespace metabuffer::test
