#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/viewport_table.h"

namespace metabuffer::analysis {

/// A periodic task of the bus, as in section 5.1 of the paper: `data_pixels` (C) are needed in each period of
/// `period_cycles` raster clocks (T), by its end (D).
///
/// One task is what displays in one column of the wall need at the same raster columns but never in the same raster
/// row. As the raster goes down, the task only changes its destination from one display to the next.
struct Task {
    /// The paper's names: "1", or "2a" and "2b". Tasks of one number are never needed in the same clock, since they lie
    /// next to each other on their rasters. Letters distinguish them.
    std::string label;
    std::int64_t data_pixels = 0;      ///< Sdx
    std::int64_t period_cycles = 0;    ///< Dmultiple times the raster's width
    std::int64_t deadline_cycles = 0;  ///< the period
    std::vector<int> displays;         ///< from 1, downwards in their column of the wall

    double pixels_per_cycle() const {
        return static_cast<double>(data_pixels) / static_cast<double>(period_cycles);
    }
};

/// The tasks of a table, in the order of their labels. The rows must be valid. The wall has `display_columns` columns.
std::vector<Task> task_table(const ViewportTable& rows, int raster_width_pixels, int raster_height_pixels,
                             int display_columns);

}  // namespace metabuffer::analysis
