#pragma once

#include <vector>

#include "formats/image.h"
#include "formats/viewport_table.h"
#include "scenario/scenario.h"

namespace metabuffer::functional {

/// What one renderer contributes to one composited frame: its image and the table rows that stand. A null
/// image is a renderer that has had no good pair yet.
struct Contribution {
    const PixelImage* image = nullptr;
    ViewportTable rows;
};

/// The raster of one display (counted from 1) before averaging: every renderer's segment painted over the
/// background, top of the pipeline first. The golden reference, written without the clocked model's datapath.
PixelImage composite_raster(const Scenario& scenario, const std::vector<Contribution>& contributions,
                            int display);

/// What the display shows: the raster averaged s x s.
ColourImage average_raster(const PixelImage& raster, int supersample);

/// composite_raster and average_raster in one.
ColourImage composite_display(const Scenario& scenario, const std::vector<Contribution>& contributions,
                              int display);

/// Which pair each renderer contributes to each frame when time does not matter: pair k to frame k, and where
/// pair k has a fault, the last good one before it (-1: none yet). result[frame][renderer].
std::vector<std::vector<int>> pairs_without_time(const Scenario& scenario);

/// The contributions of one frame, given each renderer's pair (-1: none).
std::vector<Contribution> contributions_of(const Scenario& scenario, const std::vector<int>& pairs);

}  // namespace metabuffer::functional
