#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "functional/functional_compositor.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Which renderer wins a raster pixel and with which value, also where pixels of some renderers starved. Computed one
/// renderer after the other, independently of the machine's datapath and of the functional level, which composites whole
/// rasters.
class PictureReference {
  public:
    /// The scenario must outlive the reference.
    explicit PictureReference(const Scenario& scenario) : scenario_(scenario) {}

    /// What a renderer (index, from 0) contributes with a pair; -1: none yet.
    functional::Contribution contribution(std::size_t renderer, int pair) const;

    /// What the link leaves of an image's pixel: the word of the memory.
    Pixel over_the_link(Pixel pixel) const;

    /// A renderer's local pixel at a raster position, smoothed if its composer smooths.
    struct Local {
        int source_x = 0;  ///< in its image
        int source_y = 0;
        Pixel pixel;
    };
    std::optional<Local> local(const functional::Contribution& contribution, int display, int x, int y) const;

    static constexpr int kBackground = -1;
    /// The pipeline of a display (from 1) at a raster position.
    struct Column {
        std::vector<Pixel> stages;  ///< out of each composer, from the top
        int winner = kBackground;   ///< index of the renderer that changed the pixel last
        std::optional<Local> winning;

        Pixel bottom() const { return stages.back(); }
    };
    /// missing: indices of renderers whose pixel starved there.
    Column column(const std::vector<functional::Contribution>& contributions, int display, int x, int y,
                  const std::vector<int>& missing = {}) const;

  private:
    Pixel smoothed(const PixelImage& image, const ViewportRow& row, int x, int y) const;

    const Scenario& scenario_;
};

/// The first position at which two pictures differ, if any: "pixel 12,5: #102030 instead of #112030", and how many
/// pixels differ. Also reports different sizes.
std::optional<std::string> picture_fault(const ColourImage& seen, const ColourImage& expected);

/// 0xRRGGBB as "#rrggbb".
std::string colour_text(std::uint32_t rgb);

}  // namespace metabuffer::monitors
