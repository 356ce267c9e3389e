#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/image.h"
#include "functional/functional_compositor.h"
#include "scenario/scenario.h"

namespace metabuffer::functional {

/// Counts the wrong pixels of displays: those shown that differ from what a machine in which nothing starves shows of the
/// same pairs. A raster pixel that starves is not seen where another renderer's is nearer.
class WrongPixels {
  public:
    /// The scenario must outlive it.
    explicit WrongPixels(const Scenario& scenario) : scenario_(scenario), compositor_(scenario) {}

    /// In a picture of a frame (from 0) on a display (from 1) that was made of these pairs (-1: none).
    std::int64_t count(int frame, int display, const ColourImage& picture, const std::vector<int>& pairs);

  private:
    const Scenario& scenario_;
    Compositor compositor_;
    std::optional<int> frame_;  ///< of the compositor, and the pairs that it is made of
    std::vector<int> pairs_;
};

}  // namespace metabuffer::functional
