#pragma once

#include "formats/pixel.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// The pixel that a composer makes of its local pixel and the one from upstream, by docs/design.md. Written
/// independently of model/datapath, which it checks.
Pixel reference_composition(Composition composition, Pixel local, Pixel upstream);

/// A channel of premultiplied `front` over `back`, each 0 to 255, before it is limited to 255.
int unlimited_over(int front, int back, int front_alpha);

}  // namespace metabuffer::monitors
