#pragma once

#include "images/image_codec.h"

namespace metabuffer {

/// As ImageSource has them.
ImageSize image_size(const ImageFiles& files);
PixelImage load_image(const ImageFiles& files, DepthFormat format, const DepthRange& range);

}  // namespace metabuffer
