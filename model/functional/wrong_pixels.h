#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "formats/image.h"
#include "functional/functional_compositor.h"
#include "scenario/scenario.h"

namespace metabuffer::functional {

/// Finds the wrong pixels of displays: shown pixels that differ from what a machine in which nothing starves shows for
/// the same pairs. A starved raster pixel is not visible where another renderer's pixel is nearer.
class WrongPixels {
  public:
    /// The scenario must outlive it.
    explicit WrongPixels(const Scenario& scenario) : scenario_(scenario), compositor_(scenario) {}

    /// Those in the picture of a frame (from 0) on a display (from 1) that was made of these pairs (-1: none): their
    /// indices among the picture's values, ascending.
    std::vector<std::size_t> find(int frame, int display, const ColourImage& picture,
                                  const std::vector<int>& pairs);

  private:
    const Scenario& scenario_;
    Compositor compositor_;
    std::optional<int> frame_;  ///< that the compositor has begun, and its pairs
    std::vector<int> pairs_;
};

}  // namespace metabuffer::functional
