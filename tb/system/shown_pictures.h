#pragma once

#include <cstddef>
#include <vector>

#include "formats/image.h"
#include "scenario/scenario.h"

namespace metabuffer::test {

/// What the displays (from 1) of one run showed of each frame (from 0).
class ShownPictures {
  public:
    explicit ShownPictures(const Scenario& scenario)
        : displays_(scenario.displays.count()),
          shown_(static_cast<std::size_t>(scenario.frames) * static_cast<std::size_t>(displays_)) {}

    void take(int frame, int display, const ColourImage& image) {
        Shown& shown = shown_.at(index(frame, display));
        shown.image = image;
        ++shown.times;
    }
    /// Null if the display never showed it.
    const ColourImage* picture(int frame, int display) const {
        const Shown& shown = shown_.at(index(frame, display));
        return shown.times == 0 ? nullptr : &shown.image;
    }
    /// How often the frame was shown first: 1 in a whole run.
    int times_shown(int frame, int display) const { return shown_.at(index(frame, display)).times; }

  private:
    struct Shown {
        ColourImage image;
        int times = 0;
    };

    std::size_t index(int frame, int display) const {
        return static_cast<std::size_t>(frame) * static_cast<std::size_t>(displays_) +
               static_cast<std::size_t>(display - 1);
    }

    int displays_;
    std::vector<Shown> shown_;  ///< by frame and display
};

}  // namespace metabuffer::test
