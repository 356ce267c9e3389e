#pragma once

#include <map>
#include <memory>
#include <utility>

#include "datapath/span.h"
#include "formats/pixel.h"
#include "formats/stored_image.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// A cache of the images as the input framebuffers hold them. Each is converted once, however many renderers show it,
/// and released when no frame needs it any more.
class ContentCache {
  public:
    explicit ContentCache(DepthFormat format) : format_(format) {}

    /// The colour half of one image with the depth half of another.
    FrameContent content(const StoredImage& colour, const StoredImage& depth) {
        std::weak_ptr<const PixelPlanes>& place = cache_[{&colour, &depth}];
        FrameContent content = place.lock();
        if (!content) {
            content = std::make_shared<const PixelPlanes>(
                planes_after_link(colour.pixels(), depth.pixels(), format_));
            place = content;
        }
        return content;
    }

  private:
    DepthFormat format_;
    std::map<std::pair<const StoredImage*, const StoredImage*>, std::weak_ptr<const PixelPlanes>> cache_;
};

}  // namespace metabuffer::tlm
