#pragma once

#include "formats/pixel.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// The pixel that a composer makes of its local pixel and the one from upstream, by docs/design.md. Written
/// independently of model/datapath, which it checks.
Pixel reference_composition(Composition composition, Pixel local, Pixel upstream);

/// A raster pixel's own source pixel and those that smoothing mixes with it: beside it, in the other source row, and beside
/// that one. Weights are of 256.
struct ReferenceMixture {
    Pixel own;
    Pixel beside;
    Pixel across;
    Pixel diagonal;
    int weight_x = 0;
    int weight_y = 0;
};

/// The local pixel that smoothing makes of them, by docs/design.md.
Pixel reference_smoothing(const ReferenceMixture& mixture, Composition composition, std::uint32_t far_z);

/// The source lines that smoothing mixes at a raster line of a segment, by division.
struct ReferenceLines {
    int own = 0;
    int other = 0;   ///< the same if there is none
    int weight = 0;  ///< of the other, of 256
};
/// distance: of the raster line from the segment's first one, 0 or more; count: source lines.
ReferenceLines reference_lines(int distance, int count, int multiple);

/// A channel of premultiplied `front` over `back`, each 0 to 255, before it is limited to 255.
int unlimited_over(int front, int back, int front_alpha);

}  // namespace metabuffer::monitors
