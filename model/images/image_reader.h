#pragma once

#include "images/image_codec.h"

namespace metabuffer {

/// As ImageSource has them.
ImageSize image_size(const ImageFiles& files);
ReadImage load_image(const ImageFiles& files, DepthFormat format, const ImageReading& reading);

}  // namespace metabuffer
