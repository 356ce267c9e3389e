#pragma once

#include <cstdint>

#include "report/report.h"
#include "scenario/scenario.h"

namespace metabuffer::test {

/// What a run counted of the pixels that a buffer was too small for.
struct Starvation {
    std::int64_t starved_pixels = 0;
    std::int64_t late_pixels = 0;
    std::int64_t rejected_for_buffer = 0;  ///< table rows
    std::int64_t high_water_pixels = 0;    ///< the most that any composer held
    std::int64_t watchdog_lines = 0;
    int most_starved_renderer = 0;  ///< from 1; 0: nothing starved
    int most_starved_display = 0;
    BusCounters bus;  ///< of all renderers

    bool none() const { return starved_pixels == 0 && rejected_for_buffer == 0 && watchdog_lines == 0; }
};

/// Runs the scenario at level tlm, counters only, with glitches and buffers of so many pixels. It runs in a separate
/// process, since SystemC elaborates once in a process. This process must not have elaborated anything. Throws
/// std::runtime_error if the run fails.
Starvation run_with_buffer(const Scenario& scenario, int buffer_pixels);

}  // namespace metabuffer::test
