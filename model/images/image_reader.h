#pragma once

#include "images/image_codec.h"

namespace metabuffer {

/// As ImageCodec::load says.
PixelImage load_image(const std::filesystem::path& colour_file,
                      const std::optional<std::filesystem::path>& depth_file, DepthFormat format,
                      const DepthRange& range);

}  // namespace metabuffer
