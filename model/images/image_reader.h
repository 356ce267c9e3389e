#pragma once

#include "images/image_codec.h"

namespace metabuffer {

/// As ImageCodec::load says.
PixelImage load_image(const ImageFiles& files, DepthFormat format, const DepthRange& range);

}  // namespace metabuffer
