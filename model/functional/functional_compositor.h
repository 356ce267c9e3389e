#pragma once

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

#include "formats/colour_table.h"
#include "formats/image.h"
#include "formats/pixel_planes.h"
#include "formats/viewport_table.h"
#include "scenario/scenario.h"

namespace metabuffer::functional {

/// What one renderer contributes to one composited frame: its image and the valid table rows. The image is null if the
/// renderer has had no good pair yet.
struct Contribution {
    const PixelImage* image = nullptr;
    ViewportTable rows;
    /// Owns the image if it is not the scenario's own but a copy with the bits that a fault flips on the link.
    std::shared_ptr<const PixelImage> copy = nullptr;
};

/// The golden reference, written without the clocked model's datapath. It paints every renderer's rectangle over the
/// background, top of the pipeline first. Keep one compositor for a whole run: what the link leaves of an image, with
/// colour and depth apart, is computed once for all displays and all consecutive frames that show the image. That needs
/// 8 bytes for each pixel of a frame's images.
class Compositor {
  public:
    /// The scenario must outlive the compositor.
    explicit Compositor(const Scenario& scenario);

    /// Goes on to the next frame. An image is known by its address: it must neither move nor change while consecutive
    /// frames contribute it.
    void begin_frame(std::vector<Contribution> contributions);

    /// The frame's raster of one display (counted from 1), before averaging.
    PixelImage raster(int display);

    /// What the display shows: the raster averaged s x s, and its colours corrected.
    ColourImage picture(int display);

    /// The last step of picture(): corrects the colours of an averaged raster of that display.
    void correct_colours(int display, ColourImage& picture) const;

  private:
    template <typename Take>
    void paint(int display, const Take& take);
    const PixelPlanes& planes_of(const PixelImage& image);

    const Scenario& scenario_;
    std::map<int, ColourTable> colour_tables_;  ///< of displays that have one
    std::vector<Contribution> contributions_;
    std::unordered_map<const PixelImage*, PixelPlanes> planes_;  ///< of this frame's images
    std::vector<PixelPlanes> spare_planes_;  ///< memory of images that are no longer used, for other images
};

/// Compositor::raster of a single frame.
PixelImage composite_raster(const Scenario& scenario, const std::vector<Contribution>& contributions,
                            int display);

/// The mean of each square of supersample x supersample pixels, which is 1, 2 or 4.
ColourImage average_raster(const PixelImage& raster, int supersample);

/// Compositor::picture of a single frame.
ColourImage composite_display(const Scenario& scenario, const std::vector<Contribution>& contributions,
                              int display);

/// Which pair each renderer contributes to each frame, [frame][renderer], if time does not matter: pair k to frame k; where
/// faults lose pair k, the last good pair before it (-1: none yet).
std::vector<std::vector<int>> pairs_without_time(const Scenario& scenario);

/// The pairs of one frame: those of the frame before it, which `pairs` has, or the frame's own where they are not lost.
/// Waits for the applications of live renderers. False if there is no such frame.
bool take_pairs_without_time(const Scenario& scenario, int frame, std::vector<int>& pairs);

/// The contributions of one frame, given each renderer's pair (-1: none).
std::vector<Contribution> contributions_of(const Scenario& scenario, const std::vector<int>& pairs);

}  // namespace metabuffer::functional
