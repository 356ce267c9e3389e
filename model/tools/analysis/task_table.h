#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/viewport_table.h"

namespace metabuffer::analysis {

/// A periodic task of the bus, as in section 5.1 of the paper: `data_pixels` (C) are needed in each period of
/// `period_cycles` raster clocks (T), by their end (D).
///
/// One task is what a column of the wall's displays needs at the same raster columns but never in the same raster row:
/// as the raster goes down, it changes its destination from one display to the next, and nothing else.
struct Task {
    /// The paper's names: tasks of one number are never needed in the same clock, since they lie beside each other on
    /// their rasters; letters tell them apart. "1", or "2a" and "2b".
    std::string label;
    std::int64_t data_pixels = 0;      ///< Sdx
    std::int64_t period_cycles = 0;    ///< Dmultiple times the raster's width
    std::int64_t deadline_cycles = 0;  ///< the period
    std::vector<int> displays;         ///< from 1, in the table's order

    double pixels_per_cycle() const {
        return static_cast<double>(data_pixels) / static_cast<double>(period_cycles);
    }
};

/// The tasks of a table, in the order of their labels. The rows must be valid; displays stand `display_columns` abreast.
std::vector<Task> task_table(const ViewportTable& rows, int raster_width_pixels, int raster_height_pixels,
                             int display_columns);

}  // namespace metabuffer::analysis
