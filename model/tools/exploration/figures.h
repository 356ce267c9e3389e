#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "report/report.h"
#include "scenario/scenario.h"
#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// One figure of a run, by the name under which filters, goals, tables and charts know it.
struct FigureKind {
    const char* name;     ///< "starved_pixels": a column of the results
    const char* unit;     ///< "pixels", "clocks", "frames/s", "bits", "" for a ratio
    const char* meaning;  ///< one line for --help and documentation
};

/// Every figure, in the order of the results' columns. Sums are over the machine, as in report.json's totals; beside
/// them: frame_cycles (mean clocks a frame, first composited pixel to last), frames_per_second, latency_cycles (the
/// longest of the frames), demand_pixels_per_cycle (pixels sent on the busiest bus over the clocks that frames took),
/// and the cost: renderers, displays, composers, buffer_bits (composers x buffer_pixels x 64), bus_wires (renderers x
/// width_bits).
const std::vector<FigureKind>& figure_kinds();

/// The place of the figure of that name in that order; none if there is no such figure.
std::optional<std::size_t> figure_index(const std::string& name);

/// The figures of a run, in that order. A figure that the run does not have is nothing.
std::vector<Value> figures_of(const RunReport& report, const Scenario& scenario);

}  // namespace metabuffer::exploration
